"""Structure of the user: matrices and joints in place of a roll, and a method per analysis."""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from wroll_fem.dynamics.joints.assembly import with_joints
from wroll_fem.dynamics.joints.force import Force, patterns
from wroll_fem.dynamics.joints.joint import At, Joint, row_of
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.system.harmonic_force import HarmonicForce
from wroll_fem.dynamics.system.io import save_system
from wroll_fem.dynamics.system.matrix_checks import is_singular, negative_problem, symmetry_problem
from wroll_fem.dynamics.system.modal_damping import ModalDamping
from wroll_fem.dynamics.system.system import System
from wroll_fem.errors import InputError
from wroll_fem.results.storage.atomic import make_folder
from wroll_fem.runs import Runs
from wroll_fem.typing import FloatArray

Matrix = Any
"""Array-like (n, n), or a sparse matrix of scipy."""


@dataclass(frozen=True, eq=False)
class OwnStructure(Runs):
    """Structure from matrices with joints; `structure` makes it.

    Attributes
    ----------
    system
        Matrices and interfaces.
    rest
        State at rest, from which motions start.
    """

    system: System
    rest: ContactState

    @cached_property
    def file(self) -> Path:
        """Matrix file of the structure in the user's cache folder; its name is the hash of its content."""
        folder = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "wroll_fem" / "structures"
        make_folder(folder)
        with tempfile.TemporaryDirectory(dir=folder) as place:
            written = self.save(Path(place) / "structure.npz")
            path = folder / f"{hashlib.sha256(written.read_bytes()).hexdigest()[:16]}.npz"
            if not path.exists():  # the same content has the same name; a file in use is not touched
                written.replace(path)
        return path

    def save(self, path: str | Path) -> Path:
        """Write the structure to a .npz or .mat file for `structure.file` of a case.

        Raises
        ------
        InputError
            If the path has another ending.
        """
        return save_system(self.system, path, preload=self.rest)

    def own_sections(self) -> dict[str, Any]:
        """Return the case section `structure`, with the path of `file`."""
        return {"structure": {"file": str(self.file)}}


def structure(
    stiffness: Matrix,
    mass: Matrix,
    joints: Sequence[Joint] = (),
    *,
    damping: float | Sequence[float] | Matrix | None = None,
    tip: At | None = None,
    probes: Mapping[str, At] | None = None,
    influence: npt.ArrayLike | None = None,
    force: Mapping[int, float] | Sequence[Force] | npt.ArrayLike | None = None,
) -> OwnStructure:
    """Structure from matrices with joints, excited by its base or by a force.

    Parameters
    ----------
    stiffness, mass
        (n, n) symmetric matrices, N/m and kg; dense or sparse, supports eliminated.
    joints
        Joints of `wroll_fem.joints`.
    damping
        (n, n) viscous damping, N s/m; or the damping ratio of all modes, or a sequence with those of modes 1, 2, ...
        with sticking joints.
    tip
        Degree of freedom (or pair, or row) whose motion is the tip; the last degree of freedom if None.
    probes
        Further places whose motion the results contain, by name.
    influence
        (n,) displacement of each degree of freedom when the base moves by 1 m; ones if None. All displacements are
        relative to the base.
    force
        Force in N that excites the structure in place of the base: (n,), or degree of freedom -> force. The excitation
        of a case is then its factor, and the transmissibility is the accelerance, tip acceleration per factor. A list
        of `wroll_fem.joints.Force` has phases and harmonics (harmonic balance only).

    Returns
    -------
    OwnStructure
        With `run_modal`, `run_harmonic`, `run_backbone`, `run_sweep`, `run_dwell`, `run_random` and `run_shock`.

    Raises
    ------
    InputError
        If a matrix is not square and symmetric, or not positive semi-definite, or a place does not exist.

    Examples
    --------
    >>> import wroll_fem as wf
    >>> joint = wf.joints.Jenkins(at=(1, 0), stiffness=5.0e3, limit=2.0)
    >>> chain = wf.structure([[2.0e4, -1.0e4], [-1.0e4, 1.0e4]], [[1.0, 0.0], [0.0, 1.0]], [joint], damping=0.005)
    >>> chain.system.n_dofs
    2
    """
    k, m = _matrix(stiffness, "stiffness"), _matrix(mass, "mass")
    n = k.shape[0]
    if m.shape != k.shape:
        raise InputError(f"stiffness {k.shape} and mass {m.shape} differ in shape", key="mass", remedy="give (n, n)")
    if influence is not None and force is not None:
        raise InputError("is given with influence", key="force", remedy="excite the structure by its base or a force")
    named = {"tip": n - 1 if tip is None else tip} | dict(probes or {})
    plain = System(
        stiffness=k, mass=m,
        influence=np.ones(n) if influence is None else _vector(influence, n, "influence"),
        probes={name: row_of(place, n) for name, place in named.items()},
    )  # fmt: skip
    if force is not None:
        if is_singular(m):
            raise InputError("is singular, but a force needs a regular one", key="mass", remedy="give every DOF a mass")
        first, further = _force(force, n)
        plain = replace(plain.excited_by(first), harmonic_forces=further)
    system, rest = with_joints(_damped(plain, damping), joints)
    return OwnStructure(system, rest)


def _matrix(values: Matrix, key: str) -> sp.csr_matrix:
    matrix = sp.csr_matrix(values, dtype=float)
    if matrix.shape[0] != matrix.shape[1]:
        raise InputError(f"has the shape {matrix.shape}", key=key, remedy="give a square matrix")
    problem, remedy = symmetry_problem(matrix)
    if problem:
        raise InputError(problem, key=key, remedy=remedy)
    problem = negative_problem(matrix, pivots=key != "stiffness")
    if problem:
        raise InputError(f"is not positive semi-definite: {problem}", key=key, remedy="check signs and units")
    return matrix


def _vector(values: npt.ArrayLike, n: int, key: str) -> FloatArray:
    vector = np.asarray(values, float)
    if vector.shape != (n,) or not np.isfinite(vector).all():
        problem = f"has the shape {vector.shape} or contains nan"
        raise InputError(problem, key=key, remedy=f"give {n} numbers, one per degree of freedom")
    return vector


def _force(
    force: Mapping[int, float] | Sequence[Force] | npt.ArrayLike, n: int
) -> tuple[FloatArray, tuple[HarmonicForce, ...]]:
    if isinstance(force, Mapping):
        force = [Force(at=int(place), amplitude=value) for place, value in force.items()]
    if isinstance(force, Sequence) and all(isinstance(part, Force) for part in force):
        return patterns(force, n)  # type: ignore[arg-type]
    return _vector(force, n, "force"), ()  # type: ignore[arg-type]


def _damped(system: System, damping: float | Sequence[float] | Matrix | None) -> System:
    if damping is None:
        return system
    if sp.issparse(damping) or np.ndim(damping) == 2:
        return replace(system, damping=_matrix(damping, "damping"))
    ratios = tuple(float(ratio) for ratio in np.atleast_1d(np.asarray(damping, float)))
    return replace(system, modal_damping=ModalDamping(ratios, ()))
