"""Units beyond SI that levels are given in."""

GRAVITY = 9.80665
"""Standard acceleration of gravity, m/s^2: one g."""
