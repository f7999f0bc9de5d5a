r"""Quasi-static path of loads on a structure with sticking and sliding contact, in a basis that grows along the path.

Displacements v are relative to a state at rest, with tractions :math:`t_0` and the stick stiffness :math:`D_0`:

.. math:: K_s v + G^T W s = f, \qquad s = t(g_0 + G v) - t_0 - D_0 G v, \qquad K_s = K + G^T W D_0 G

:math:`K_s` is factorised once. v is sought in the span of vectors :math:`\Phi` with :math:`\Phi^T K_s \Phi = I`, where
only the points that do not stick enter Newton's matrix. The residual of the whole structure has the static response
:math:`z = K_s^{-1} r`. Its energy norm :math:`\sqrt{r^T z}` is the error, relative to that of the response with
sticking contact to the largest load so far (loads may pass through zero); while it is too large, z joins the basis.
Earlier vectors remain, so that a basis serves all further loads of a path: some ten new vectors per load, in place of a
factorisation per iteration.

Friction depends on the path: each load starts from the committed state of the one before.

The normal traction at a point may follow a stress of the structure, :math:`t_n = -P + R v` with given rows R, as inside
a body: friction feels this pressure, which is no contact force. Its limit then depends on the solution, the rows of the
friction in Newton's matrix on R: friction is not associated, the matrix not symmetric. Newton's method solves for both
together; there is no potential, so that steps are damped by the norm of the residual as long as it falls.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp

from wroll_fem.contact import kernels
from wroll_fem.contact.point import NORMAL
from wroll_fem.dynamics.statics.contact_springs import stick_springs
from wroll_fem.dynamics.statics.contact_state import ContactState, TrialContact
from wroll_fem.dynamics.system.system import System
from wroll_fem.errors import ConvergenceError
from wroll_fem.numerics.linear import factorise
from wroll_fem.numerics.newton import NO_RENEWAL, damped_newton, first_decrease, gradient_slope
from wroll_fem.typing import FloatArray

TOLERANCE = 1e-3
"""Default of the largest error of a state, in the energy norm. Tip motion and frequency of a slipping coil are then
within 1e-4, its damping within 2e-3."""

NEWTON_SHARE = 0.02
"""Residual of Newton's method in the basis, relative to the load, divided by the tolerance."""

MOST_VECTORS, ITERATIONS = 1500, 40
"""Largest number of basis vectors, and of Newton iterations."""

ROOM = 64
"""Number of vectors for which memory is reserved at a time."""


class LoadPath:
    """Equilibria of a system under successive loads, from a state at rest.

    Parameters
    ----------
    system
        Structure with its interfaces, which must be held when all points stick.
    start
        State at rest. Its displacement is the reference of the loads: a load of zero leaves the structure there.
    tolerance
        Largest error of a state, see `TOLERANCE`.
    stress
        (n_points, n_dofs) rows R of the stress that changes the normal traction, Pa/m; None: the relative displacement
        of the interfaces alone changes it.

    Attributes
    ----------
    state : `ContactState` under the last load
    vectors : basis, orthonormal in the stiffness with sticking contact
    error : error of the last state
    scale : energy norm of the response with sticking contact to the largest load so far, N^(1/2) m^(1/2)
    """

    def __init__(
        self,
        system: System,
        start: ContactState,
        *,
        tolerance: float = TOLERANCE,
        stress: sp.csr_matrix | None = None,
    ):
        self.system, self.start, self.state, self.tolerance = system, start, start, tolerance
        self.springs = stick_springs(system, start)
        self.stiffness = system.with_interface_springs(self.springs).tocsr()
        self.factor = factorise(self.stiffness)
        self.trial = TrialContact(system)
        self.stress, self.jump, self.weights = stress, system.jump, system.weights
        if stress is not None:  # as a normal displacement without a force
            n = system.n_points
            self.jump = sp.vstack([system.jump[: 2 * n], sp.diags(1.0 / system.laws.kn) @ stress], format="csr")
            self.weights = np.concatenate([system.weights[: 2 * n], np.zeros(n)])
        self._count, self._room = 0, [np.empty((0, k)) for k in (system.n_dofs, system.n_dofs, 3 * system.n_points)]
        self.error = self.scale = 0.0

    @property
    def vectors(self) -> FloatArray:
        """(m, n_dofs) basis."""
        return self._room[0][: self._count]

    @property
    def forces(self) -> FloatArray:
        """(m, n_dofs) forces of the sticking structure for each vector of the basis, N."""
        return self._room[1][: self._count]

    @property
    def jumps(self) -> FloatArray:
        """(m, 3 n_points) relative displacement of each vector of the basis."""
        return self._room[2][: self._count]

    def stuck(self, load: FloatArray) -> FloatArray:
        """(n_dofs,) response to a ``load`` (n_dofs,), N, if every point sticks, m."""
        return self.factor.solve(load)

    def add(self, vector: FloatArray) -> None:
        """Add a displacement (n_dofs,) to the basis."""
        part = vector
        for _ in range(2):
            part = part - (self.forces @ part) @ self.vectors
        force = self.stiffness @ part
        part = part / np.sqrt(part @ force)
        if self._count == len(self._room[0]):
            self._room = [np.concatenate([rows, np.empty((ROOM, rows.shape[1]))]) for rows in self._room]
        new = (part, self.stiffness @ part, self.jump @ part)
        for rows, values in zip(self._room, new, strict=True):
            rows[self._count] = values
        self._count += 1

    def to(self, load: FloatArray) -> ContactState:
        """State under the ``load`` (n_dofs,), N, in addition to the loads at rest; it becomes the committed state.

        Raises
        ------
        ConvergenceError
            If Newton's method does not converge, or the basis grows beyond `MOST_VECTORS`.
        """
        system, stuck = self.system, self.stuck(load)
        self.scale = scale = max(self.scale, float(np.sqrt(load @ stuck)))
        if not len(self.vectors):
            self.add(stuck)
        history: list[float] = []
        x = self.forces @ (self.state.displacement - self.start.displacement)
        while len(self.vectors) <= MOST_VECTORS:
            problem = _InBasis(self, load, NEWTON_SHARE * self.tolerance * scale)
            guess = np.append(x, np.zeros(len(self.vectors) - len(x)))
            found, sizes = damped_newton(
                problem,
                guess,
                max_iterations=ITERATIONS,
                search=first_decrease,
                renewal=NO_RENEWAL,
                slope=gradient_slope,
            )
            if found is None:
                history = sizes
                break
            x = found
            moved = x @ self.vectors
            residual = load - x @ self.forces - system.jump.T @ (self.weights * problem.correction)
            response = self.stuck(residual)
            self.error = float(np.sqrt(max(residual @ response, 0.0))) / scale
            history.append(self.error)
            if self.error <= self.tolerance:
                jump = self.start.jump + x @ self.jumps
                self.state = self.trial.committed(self.start.displacement + moved, jump)
                return self.state
            self.add(response)
        raise ConvergenceError(
            f"quasi-static path: no equilibrium in a basis of {len(self.vectors)} vectors", time_s=None,
            iterations=len(history), residual_history=history, advice="use smaller steps of the load",
        )  # fmt: skip


class _InBasis:
    """Equilibrium in the basis as a `NewtonProblem` for the coordinates (m,)."""

    def __init__(self, path: LoadPath, load: FloatArray, limit: float):
        self.path, self.limit = path, limit
        self.load, self.jumps = path.vectors @ load, path.jumps
        self.weights = path.weights
        self.correction = np.zeros(self.jumps.shape[1])

    def residual(self, x: FloatArray) -> tuple[FloatArray, float]:
        """Unbalanced force in the basis (m,), and its norm."""
        path, moved = self.path, x @ self.jumps
        traction = path.trial(path.start.jump + moved, path.state)
        self.correction = traction - path.start.traction - path.springs * moved
        r = x + self.jumps @ (self.weights * self.correction) - self.load
        return r, float(np.linalg.norm(r))

    def linearise(self, x: FloatArray) -> Callable[[FloatArray], FloatArray]:
        """Function that solves the linearised equations, with the consistent tangent at ``x``."""
        path, system = self.path, self.path.system
        n = system.n_points
        kernels.consistent_tangent(
            path.start.jump + x @ self.jumps, path.state.jump, path.state.elastic_slip, system.laws, np.inf,
            path.trial.tangent,
        )  # fmt: skip
        change = path.trial.tangent.copy()
        springs = np.column_stack([path.springs[: 2 * n].reshape(n, 2), path.springs[2 * n :]])
        change[:, range(3), range(3)] -= springs
        if path.stress is not None:
            change[:, NORMAL, :] = 0.0
        points = np.flatnonzero(np.abs(change).max(axis=(1, 2)) > 1e-12 * np.abs(springs).max(axis=1))
        dofs = np.column_stack([2 * points, 2 * points + 1, 2 * n + points])
        jumps = self.jumps[:, dofs.ravel()].reshape(len(x), len(points), 3)
        forces = np.einsum("p,pij,mpj->mpi", system.laws.area[points], change[points], jumps)
        matrix = np.eye(len(x)) + jumps.reshape(len(x), -1) @ forces.reshape(len(x), -1).T
        factors = la.lu_factor(matrix, check_finite=False)
        return lambda r: np.asarray(la.lu_solve(factors, r, check_finite=False))

    def converged(self, size: float, previous: float) -> bool:
        """Whether the unbalanced force is small enough."""
        return size <= self.limit
