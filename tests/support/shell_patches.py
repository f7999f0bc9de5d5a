"""Structured quad9 patches on any surface, and a plain static solve: shared by the shell tests."""

import numpy as np
import scipy.sparse.linalg as spla


def patch(surface, n_s, n_t):
    """Nodes and gmsh-ordered quad9 cells of a grid s, t in [0, 1] mapped by `surface(s, t) -> (3, ...)`."""
    s, t = np.meshgrid(np.linspace(0, 1, 2 * n_s + 1), np.linspace(0, 1, 2 * n_t + 1), indexing="ij")
    nodes = np.stack(np.broadcast_arrays(*surface(s, t)), axis=-1).reshape(-1, 3).astype(float)
    number = np.arange(s.size).reshape(s.shape)
    offsets = [(0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1), (1, 1)]
    cells = [[number[2 * i + a, 2 * j + b] for a, b in offsets] for i in range(n_s) for j in range(n_t)]
    return nodes, np.array(cells), s.ravel(), t.ravel()


def solve_static(stiffness, force, fixed, values=0.0):
    """Displacements with the degrees of freedom in the boolean mask `fixed` prescribed."""
    u = np.where(fixed, values, 0.0)
    free = np.flatnonzero(~fixed)
    u[free] = spla.spsolve(stiffness[free][:, free].tocsc(), (force - stiffness @ u)[free])
    return u


def mask(n_nodes, *conditions):
    """Boolean mask (6 n_nodes,) from pairs (nodes, components)."""
    fixed = np.zeros((n_nodes, 6), bool)
    for nodes, components in conditions:
        fixed[np.ix_(np.flatnonzero(nodes), components)] = True
    return fixed.ravel()
