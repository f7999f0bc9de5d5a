"""Finite elements with dolfinx: shells, solids, constraints, bodies and eigensolvers."""
