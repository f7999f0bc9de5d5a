"""Meshes: cylindrical shells, grids of coil points, axisymmetric half planes, and mesh files."""
