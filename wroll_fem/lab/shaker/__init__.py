"""Shaker tests: records of base and tip to curves, frequencies and damping ratios."""
