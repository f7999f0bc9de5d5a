"""Static equilibrium with contact and friction: load steps and preload."""
