"""Signals: base motions, transmissibility and damping estimates."""
