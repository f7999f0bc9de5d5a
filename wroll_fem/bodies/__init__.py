"""Linear structures: bodies and their matrices, materials, mode shapes, probes and the cantilever beam."""
