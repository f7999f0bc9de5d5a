"""Numerical methods that know nothing of rolls: linear solvers, continuation, numba's cache."""
