"""Shear tests: capacity, stiffness and modulus, hysteresis loops, coefficient over slip rate."""
