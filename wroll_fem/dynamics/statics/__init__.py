"""Static equilibrium with contact: load steps and preload."""
