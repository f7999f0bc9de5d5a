"""Free vibration K x = (2 pi f)^2 M x by shift-invert Krylov-Schur (SLEPc), with a check that no mode is missed."""

from __future__ import annotations

import logging
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from petsc4py import PETSc
from slepc4py import SLEPc

from wroll_fem.errors import WrollError
from wroll_fem.fem import compat
from wroll_fem.typing import FloatArray

DEFAULT_SHIFT = -((2 * np.pi * 10.0) ** 2)
"""Spectral shift sigma, (rad/s)^2. It is negative so that K - sigma M is positive definite even for a free body."""

_TOLERANCE = 1e-10
_RESIDUAL_LIMIT = 1e-6
_ROUNDING = 20 * np.finfo(float).eps  # of the product of stiff bonds and a mode that hardly strains them
_SPARE = 4

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class EigenPairs:
    """Eigenpairs nearest to a spectral shift sigma.

    Attributes
    ----------
    values
        (n_modes,) eigenvalues (2 pi f)^2, (rad/s)^2, ascending.
    vectors
        (n_dofs, n_modes) eigenvectors, M-normalised (x^T M x = 1); the entry of largest magnitude is positive.
    residuals
        (n_modes,) relative residuals |K x - lambda M x| / (|K x| + |sigma| |M x|).
    """

    values: FloatArray
    vectors: FloatArray
    residuals: FloatArray


def solve_modes(
    stiffness: sp.spmatrix, mass: sp.spmatrix, count: int, sigma: float = DEFAULT_SHIFT
) -> tuple[FloatArray, FloatArray]:
    """Lowest natural frequencies and modes.

    Parameters
    ----------
    stiffness, mass
        (n, n) sparse symmetric, N/m and kg; stiffness positive semi-definite, mass positive definite. Constraints must
        be eliminated: equal Dirichlet diagonals in both matrices would appear as modes at lambda = 1.
    count
        Number of modes.
    sigma
        Spectral shift, (rad/s)^2; negative if rigid-body modes can occur.

    Returns
    -------
    frequencies_hz : (count,) natural frequencies, Hz, ascending; those of rigid-body modes are zero to rounding errors.
    vectors : (n, count) modes, M-normalised.

    Raises
    ------
    WrollError
        If an eigenvalue is negative (the structure is unstable, or the model is wrong), if a residual exceeds 1e-6, or
        if a mode is missed.
    ValueError
        If `count` is not between 1 and n.
    """
    pairs = solve_pairs(stiffness, mass, count, sigma)
    zero = 1e-3 * abs(sigma)
    negative = pairs.values[pairs.values < -zero]
    if negative.size:
        raise WrollError(
            f"the stiffness is not positive definite: {negative.size} negative eigenvalue(s), "
            f"lowest {negative.min():.3e} (rad/s)^2; check the supports; keep the preload below buckling"
        )
    log.debug("%d modes, largest relative residual %.1e", count, pairs.residuals.max())
    return np.sqrt(np.maximum(pairs.values, 0.0)) / (2 * np.pi), pairs.vectors


def solve_pairs(stiffness: sp.spmatrix, mass: sp.spmatrix, count: int, sigma: float) -> EigenPairs:
    """Eigenpairs nearest to a spectral shift.

    Parameters
    ----------
    stiffness, mass
        (n, n) sparse symmetric, N/m and kg, as for `solve_modes`.
    count
        Number of eigenpairs.
    sigma
        Spectral shift, (rad/s)^2.

    Raises
    ------
    WrollError
        If a residual exceeds 1e-6, or if an eigenpair is missed.
    ValueError
        If `count` is not between 1 and n.
    """
    compat.require_real_scalars()
    n = stiffness.shape[0]
    if not 0 < count <= n:
        raise ValueError(f"the number of modes must be 1 to {n} (the number of unknowns), got {count}")
    wanted = min(n, count + _SPARE)
    K, M = _petsc(stiffness), _petsc(mass)
    values, vectors = _krylov_schur(K, M, wanted, sigma)
    if missed := _missed(K, M, values, count, sigma):
        values, vectors = _krylov_schur(K, M, min(n, wanted + missed + 2 * _SPARE), sigma, subspace=6)
        if missed := _missed(K, M, values, count, sigma):
            raise WrollError(f"the eigensolver missed {missed} of the lowest {count} modes; request more modes")
    K.destroy()
    M.destroy()
    # petsc4py frees objects lazily: without this, the factors (100 MB and more) stay in memory until the process ends
    PETSc.garbage_cleanup(PETSc.COMM_SELF)
    values, vectors = values[:count], vectors[:, :count]
    Kx, Mx = stiffness @ vectors, mass @ vectors
    scale = np.linalg.norm(Kx, axis=0) + abs(sigma) * np.linalg.norm(Mx, axis=0)
    residuals = np.linalg.norm(Kx - Mx * values, axis=0) / scale
    rounding = _ROUNDING * np.linalg.norm(abs(stiffness) @ np.abs(vectors), axis=0) / scale
    if (residuals > _RESIDUAL_LIMIT + rounding).any():
        raise WrollError(
            f"modes did not converge: largest relative residual {residuals.max():.1e} (limit {_RESIDUAL_LIMIT:.0e}); "
            "reduce the number of modes or change the shift"
        )
    vectors = vectors / np.sqrt(np.einsum("ij,ij->j", vectors, Mx))
    largest = np.abs(vectors).argmax(axis=0)
    vectors = vectors * np.where(vectors[largest, np.arange(count)] < 0, -1.0, 1.0)
    return EigenPairs(values, vectors, residuals)


def _petsc(matrix: sp.spmatrix) -> PETSc.Mat:
    csr = sp.csr_matrix(matrix)
    csr.sort_indices()
    index = PETSc.IntType
    # the factorisation requires every diagonal entry to be stored
    csr = (csr + sp.csr_matrix((np.zeros(csr.shape[0]), (range(csr.shape[0]),) * 2), shape=csr.shape)).tocsr()
    built = PETSc.Mat().createAIJ(
        csr.shape, csr=(csr.indptr.astype(index), csr.indices.astype(index), csr.data), comm=PETSc.COMM_SELF
    )
    built.setOption(PETSc.Mat.Option.SYMMETRIC, True)
    return built


def _krylov_schur(
    K: PETSc.Mat, M: PETSc.Mat, wanted: int, sigma: float, subspace: int = 3
) -> tuple[FloatArray, FloatArray]:
    """At least `wanted` eigenpairs nearest to sigma, in ascending order."""
    n = K.getSize()[0]
    solver = SLEPc.EPS().create(PETSc.COMM_SELF)
    solver.setOperators(K, M)
    solver.setProblemType(SLEPc.EPS.ProblemType.GHEP)
    solver.setType(SLEPc.EPS.Type.KRYLOVSCHUR)
    solver.setWhichEigenpairs(SLEPc.EPS.Which.TARGET_MAGNITUDE)
    solver.setTarget(sigma)
    solver.setDimensions(nev=wanted, ncv=min(n, subspace * wanted + 10))
    solver.setTolerances(_TOLERANCE, 200)
    transform = solver.getST()
    transform.setType(SLEPc.ST.Type.SINVERT)
    _direct(transform.getKSP())
    start = K.createVecRight()
    start.setArray(np.random.default_rng(1).standard_normal(n))
    solver.setInitialSpace(start)
    solver.solve()
    found = solver.getConverged()
    if found < wanted:
        raise WrollError(f"the eigensolver found {found} of {wanted} modes near {sigma:.3e} (rad/s)^2; move the shift")
    values, vectors = np.empty(found), np.empty((n, found))
    x = K.createVecRight()
    for i in range(found):
        values[i] = solver.getEigenpair(i, x).real
        vectors[:, i] = x.getArray()
    solver.destroy()
    order = np.argsort(values)
    return values[order], vectors[:, order]


def _direct(ksp: PETSc.KSP) -> None:
    """Select a sparse direct solver: MUMPS (LDL^T) if PETSc provides it, otherwise PETSc's LU."""
    ksp.setType(PETSc.KSP.Type.PREONLY)
    pc = ksp.getPC()
    if _has_mumps():
        pc.setType(PETSc.PC.Type.CHOLESKY)
        pc.setFactorSolverType(PETSc.Mat.SolverType.MUMPS)
    else:
        pc.setType(PETSc.PC.Type.LU)


def _has_mumps() -> bool:
    return bool(PETSc.Sys.hasExternalPackage("mumps"))


def _missed(K: PETSc.Mat, M: PETSc.Mat, values: FloatArray, count: int, sigma: float) -> int:
    """Number of eigenvalues that the solver has missed among the lowest modes, by Sylvester's law of inertia.

    The number of negative pivots of K - s M is the number of eigenvalues below s. The value s is placed in the widest
    relative gap above mode `count`. The check needs a shift below the spectrum and MUMPS; otherwise the result is 0.
    """
    if sigma >= 0.0 or not _has_mumps() or len(values) <= count:
        return 0
    gaps = np.diff(values[count - 1 :])
    last = count - 1 + int(np.argmax(gaps / (np.abs(values[count:]) + abs(sigma))))
    level = 0.5 * (values[last] + values[last + 1])
    shifted = K.duplicate(copy=True)
    shifted.axpy(-level, M, structure=PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN)
    shifted.setOption(PETSc.Mat.Option.SYMMETRIC, True)
    ksp = PETSc.KSP().create(PETSc.COMM_SELF)
    ksp.setOperators(shifted)
    _direct(ksp)
    pc = ksp.getPC()
    pc.setFactorSetUpSolverType()
    pc.getFactorMatrix().setMumpsIcntl(24, 1)  # detect null pivots; MUMPS needs it for the inertia
    ksp.setUp()
    below = int(pc.getFactorMatrix().getInertia()[0])
    ksp.destroy()
    shifted.destroy()
    return below - (last + 1)
