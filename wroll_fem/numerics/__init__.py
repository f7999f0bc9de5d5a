"""General numerical methods: sparse solvers, GMRES, Newton's method, arc-length continuation, numba's cache."""
