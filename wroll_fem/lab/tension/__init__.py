"""Tension of a winding machine, and the pressure that it winds."""
