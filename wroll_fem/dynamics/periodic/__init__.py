"""Periodic motions: harmonic balance with the alternating frequency/time method, and backbone curves."""
