"""Natural frequencies and modes of a case."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp
import xarray as xr

from wroll_fem.analyses.forecasts.computing_time import estimate_modes
from wroll_fem.analyses.fourier import run_fourier_modal
from wroll_fem.analyses.registry import Analysis
from wroll_fem.analyses.shared import figures, preflight, summary
from wroll_fem.analyses.shared.assembly import build_bodies, build_system
from wroll_fem.analyses.shared.material_damping import mode_ratios, with_damping
from wroll_fem.analyses.shared.mode_shapes import shape_variables
from wroll_fem.analyses.shared.preparation import prepare, read_structure
from wroll_fem.analyses.shared.prestress import add_geometric_stiffness, contact_state, prestressed_roll
from wroll_fem.analyses.shared.resolution import edge_remark, frequency_remark
from wroll_fem.analyses.shared.springs import linear_springs
from wroll_fem.bodies.mode_shapes import align_pairs, classify_mode, effective_mass_fractions
from wroll_fem.case.kinds import ModalCase, RollModalCase, StructureModalCase
from wroll_fem.dynamics.system.system import System
from wroll_fem.results.dataset import annotate
from wroll_fem.typing import FloatArray

if TYPE_CHECKING:
    from wroll_fem.progress import Progress

DENSE_MODES = 500
"""Largest number of DOFs for which the modes of matrices read from a file are computed by a dense eigensolver."""


def run_modal(case: ModalCase, *, progress: Progress) -> xr.Dataset:
    """Compute the lowest modes of the whole roll, or of matrices from a file."""
    if isinstance(case, StructureModalCase):
        return run_structure(case, progress=progress)
    roll = case.expect(RollModalCase)
    return _RUNS[roll.mesh.discretisation](roll, progress=progress)


def run_three_dimensional(case: RollModalCase, *, progress: Progress) -> xr.Dataset:
    """Compute the lowest modes of the three-dimensional model, with kinds and effective masses.

    Returns
    -------
    xr.Dataset
        `mode_frequency`, `mode_kind`, `mode_harmonic`, `effective_mass_fraction` (mode, component), `mode_residual`,
        `tip_participation`, `mode_shape` (mode, node, component) and its mesh.
    """
    from wroll_fem.fem.eigen import solve_pairs

    with progress.stage("mesh and matrices", 2) as stage:
        bodies = build_bodies(case, symmetric=False)
        roll = prestressed_roll(case, bodies)
        bodies = bodies if roll is None else roll.bodies
        stage.update(1)
        system = with_damping(case, build_system(case, bodies), bodies)
        stage.update(2, f"{system.n_dofs} DOFs")
    state, factor = None, None
    if roll is not None:
        with progress.stage("geometric stiffness", 1) as stage:
            system, state = contact_state(case, roll, system)
            springs = linear_springs(case, system, state) if system.interfaces else np.zeros(0)
            system, factor = add_geometric_stiffness(case, roll, system, state, springs)
            stage.update(1, f"buckling load: {factor:.4g} x preload")
    with progress.stage("modes", 2) as stage:
        stiffness = system.stiffness
        if system.interfaces:
            stiffness = sp.csr_matrix(system.with_interface_springs(linear_springs(case, system, state)))
        stage.update(1, "matrices ready")
        # one more than wanted: half a pair at the end would have an arbitrary direction
        more = min(case.modal.count + 1, system.n_dofs)
        pairs = solve_pairs(stiffness, system.mass, more, sigma=-((2 * np.pi * 10.0) ** 2))
        stage.update(2)
    hertz = np.sqrt(np.maximum(pairs.values, 0.0)) / (2 * np.pi)
    influence = np.vstack([body.influence for body in bodies])
    vectors = align_pairs(hertz, pairs.vectors, system.mass, influence)[:, : case.modal.count]
    hertz, residuals = hertz[: case.modal.count], pairs.residuals[: case.modal.count]
    kinds = [classify_mode(bodies, vector) for vector in vectors.T]
    # semi-analytical elements have no prestress
    unresolved = "" if roll is not None else frequency_remark(case, [k.kind for k in kinds], hertz.tolist())
    for remark in (unresolved, edge_remark(case, system)):
        if remark:
            progress.warning(remark)
    total = sum(body.mass_total for body in bodies)
    dataset = xr.Dataset(
        {
            "mode_frequency": ("mode", hertz),
            "mode_kind": ("mode", np.array([k.kind for k in kinds])),
            "mode_harmonic": ("mode", np.array([k.wave_number for k in kinds])),
            "mode_residual": ("mode", residuals),
            "effective_mass_fraction": (
                ("mode", "component"),
                effective_mass_fractions(system.mass, influence, vectors, total),
            ),
            "tip_participation": ("mode", tip_participation(system, vectors)),
            **mode_ratios(system, (2.0 * np.pi * hertz) ** 2, vectors),
            **shape_variables(bodies, vectors),
        },
        coords={"mode": np.arange(1, len(hertz) + 1), "component": ["x", "y", "z"]},
    )
    dataset = with_probes(dataset, system, vectors)
    dataset.attrs |= {"dofs": system.n_dofs, "interface_points": system.n_points, "mass_total_kg": total}
    if factor is not None and np.isfinite(factor):
        dataset.attrs["buckling_load_factor"] = factor
    return annotate(dataset)


def with_probes(dataset: xr.Dataset, system: System, vectors: FloatArray) -> xr.Dataset:
    """Dataset with the displacement of each M-normalised mode at the probes, if the case defines probes."""
    names = list(system.probe_names)
    if len(names) == 1:
        return dataset
    rows = np.array([system.probes[name] for name in names])
    return dataset.assign_coords(probe=names).assign(mode_at_probe=(("mode", "probe"), (rows @ vectors).T))


def tip_participation(system: System, vectors: FloatArray) -> FloatArray:
    """Participation p (n_modes,) of each M-normalised mode in the tip motion under base motion.

    The undamped transmissibility is |1 + sum over modes of p f^2 / (f_n^2 - f^2)|.
    """
    return np.asarray((system.probes["tip"] @ vectors) * (system.mass @ system.influence @ vectors))


def run_structure(case: StructureModalCase, *, progress: Progress) -> xr.Dataset:
    """Compute frequencies and effective masses of the undamped modes of matrices read from a file."""
    stuck = case.modal.interface == "stuck"
    system, state = prepare(case, progress) if stuck else read_structure(case)
    system = system if stuck else with_damping(case, system)
    springs = linear_springs(case, system, state) if system.interfaces else np.zeros(0)
    stiffness, mass = sp.csr_matrix(system.with_interface_springs(springs)), system.mass
    count = min(case.modal.count, system.n_dofs)
    with progress.stage("modes", 1) as stage:
        if system.n_dofs <= DENSE_MODES:
            values, vectors = la.eigh(stiffness.toarray(), mass.toarray(), subset_by_index=(0, count - 1))
            product = mass @ vectors
            scale = np.linalg.norm(stiffness @ vectors, axis=0) + np.linalg.norm(product * values, axis=0)
            residuals = np.linalg.norm(stiffness @ vectors - product * values, axis=0) / scale
        else:
            from wroll_fem.fem.eigen import DEFAULT_SHIFT, solve_pairs

            pairs = solve_pairs(stiffness, mass, count, sigma=DEFAULT_SHIFT)
            values, vectors, residuals = pairs.values, pairs.vectors, pairs.residuals
        stage.update(1)
    influence = system.influence if system.force is None else np.zeros(system.n_dofs)
    inertia = mass @ influence
    moved = float(influence @ inertia)
    fraction = (vectors.T @ inertia) ** 2 / moved if moved > 0.0 else np.zeros(count)
    dataset = xr.Dataset(
        {
            "mode_frequency": ("mode", np.sqrt(np.maximum(values, 0.0)) / (2 * np.pi)),
            "mode_residual": ("mode", residuals),
            "effective_mass_fraction": ("mode", fraction),
            **mode_ratios(system, values, vectors),
        },
        coords={"mode": np.arange(1, count + 1)},
    )
    dataset = with_probes(dataset, system, vectors)
    dataset.attrs |= {"dofs": system.n_dofs, "interface_points": system.n_points, "mass_total_kg": moved}
    return annotate(dataset)


_RUNS = {"three_dimensional": run_three_dimensional, "fourier": run_fourier_modal}
"""Value of `mesh.discretisation` -> its eigenvalue analysis."""

ANALYSIS = Analysis(
    name="modal",
    sentence="Natural frequencies and mode shapes.",
    sections=("geometry", "mandrel", "coil"),
    run=run_modal,
    summary=(summary.interfaces, summary.modes),
    figures=(figures.figure("modes", "modes"), figures.mode_shapes),
    fields=(figures.write_modes,),
    variables={
        "mode": ("mode_frequency", "mode_kind", "mode_harmonic", "tip_participation", "mode_damping_ratio"),
        "mode, component": ("effective_mass_fraction",),
        "mode, node, component": ("mode_shape",),
    },
    plots=("modes",),
    preflight=preflight.CHECKS["modal"],
    estimate=estimate_modes,
)
