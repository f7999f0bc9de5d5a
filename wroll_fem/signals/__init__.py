"""Signals: base motions, transmissibility and damping estimates (numpy and scipy only)."""
