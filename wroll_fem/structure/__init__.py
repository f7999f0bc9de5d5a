"""Linear structures: bodies and their matrices, materials, mode shapes, the cantilever beam."""
