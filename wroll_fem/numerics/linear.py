"""Sparse direct solvers: SuperLU for small systems, MUMPS (through PETSc) for larger ones."""

from __future__ import annotations

from typing import Protocol

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from wroll_fem.typing import FloatArray

SMALL = 1000
"""Largest number of unknowns solved by SuperLU. Up to this number SuperLU is as fast as MUMPS and needs no PETSc."""


class Factorisation(Protocol):
    """Factorised matrix that solves linear systems."""

    def solve(self, rhs: FloatArray) -> FloatArray:
        """Solution for one right-hand side ``rhs`` (n,) or for k of them (n, k), in the shape of ``rhs``."""
        ...


class _Mumps:
    """LU factorisation by MUMPS, with the factors stored by PETSc."""

    def __init__(self, matrix: sp.csr_matrix):
        from petsc4py import PETSc

        self._petsc = PETSc
        csr = sp.csr_matrix(matrix)
        csr.sort_indices()
        index = PETSc.IntType
        self._matrix = PETSc.Mat().createAIJ(
            csr.shape, csr=(csr.indptr.astype(index), csr.indices.astype(index), csr.data), comm=PETSc.COMM_SELF
        )
        ksp = PETSc.KSP().create(PETSc.COMM_SELF)
        ksp.setOperators(self._matrix)
        ksp.setType("preonly")
        ksp.getPC().setType("lu")
        ksp.getPC().setFactorSolverType("mumps")
        ksp.setUp()
        self._ksp = ksp

    def __del__(self) -> None:
        """Free the factors. petsc4py would keep them until the program ends (about 30 MB per step of a full roll)."""
        # names of a module are None while the interpreter ends
        if hasattr(self, "_ksp") and self._petsc.Sys is not None and not self._petsc.Sys.isFinalized():
            self._ksp.destroy()
            self._matrix.destroy()

    def solve(self, rhs: FloatArray) -> FloatArray:
        n = rhs.shape[0]
        if rhs.ndim == 1:
            b = self._petsc.Vec().createWithArray(np.ascontiguousarray(rhs), comm=self._petsc.COMM_SELF)
            x = b.duplicate()
            self._ksp.solve(b, x)
            found = np.array(x.getArray())
            b.destroy()
            x.destroy()
            return found
        dense = self._petsc.Mat().createDense(
            (n, rhs.shape[1]), array=np.asfortranarray(rhs), comm=self._petsc.COMM_SELF
        )
        result = self._petsc.Mat().createDense((n, rhs.shape[1]), comm=self._petsc.COMM_SELF)
        result.setUp()
        dense.assemble()
        result.assemble()
        self._ksp.getPC().getFactorMatrix().matSolve(dense, result)
        found = np.array(result.getDenseArray())
        dense.destroy()
        result.destroy()
        return found


def factorise(matrix: sp.spmatrix) -> Factorisation:
    """Factorise a square sparse matrix once, to solve for many right-hand sides.

    Raises
    ------
    RuntimeError
        If the matrix is exactly singular (SuperLU).
    """
    if matrix.shape[0] <= SMALL:
        return spla.splu(sp.csc_matrix(matrix))
    return _Mumps(matrix)
