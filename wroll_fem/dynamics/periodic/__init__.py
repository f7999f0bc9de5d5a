"""Periodic motions: harmonic balance with alternating frequency and time, backbones."""
