"""Meshes: cylinders for shells, hexahedra of the coil, the r-z half plane, and their files."""
