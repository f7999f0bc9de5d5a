"""Largest number of time steps; without imports, because the check of a case reads it."""

MOST_STEPS = 50_000_000
"""Largest number of steps of a history: its records take some 10 GB."""
