"""Modal analysis by semi-analytical (Fourier) finite elements: frequencies, effective masses and mode shapes in 3D."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
import xarray as xr

from wroll_fem.analyses.shared.resolution import fourier_remark
from wroll_fem.mesh.revolve import cartesian, revolve
from wroll_fem.results.dataset import annotate
from wroll_fem.typing import FloatArray

if TYPE_CHECKING:
    from wroll_fem.case.kinds import RollModalCase
    from wroll_fem.fem.fourier import FourierModel
    from wroll_fem.fem.fourier_modes import FourierMode
    from wroll_fem.fem.fourier_roll import FourierRoll
    from wroll_fem.progress import Progress


def run_fourier_modal(case: RollModalCase, *, progress: Progress) -> xr.Dataset:
    """Compute the lowest modes of the whole roll; the variables are named as in a three-dimensional analysis.

    Modes of wave numbers m >= 1 come in degenerate pairs, the one along x first. Shapes are given on the outer surface
    of the revolved half plane, with `mesh.circumferential` cells along the circumference.
    """
    from wroll_fem.fem.fourier_modes import lowest_modes
    from wroll_fem.fem.fourier_roll import FourierRoll

    with progress.stage("mesh and matrices", 1) as stage:
        roll = FourierRoll(case)
        stage.update(1, f"{3 * len(roll.model.nodes)} DOFs per wave number")
    with progress.stage("modes", 1) as stage:
        found = lowest_modes(roll, case.modal.count)
        stage.update(1, f"wave numbers 0 to {max(mode.symmetry.wave_number for mode in found)}")
    if remark := fourier_remark(case):
        progress.warning(remark)
    listed = [(mode, turned) for mode in found for turned in ((False, True) if mode.symmetry.wave_number else (False,))]
    listed = listed[: case.modal.count]
    fraction, share, tip = np.zeros((len(listed), 3)), np.zeros(len(listed)), np.zeros(len(listed))
    for row, (mode, turned) in enumerate(listed):
        direction = "y" if turned and mode.symmetry.wave_number == 1 else mode.symmetry.direction
        if direction is not None:
            fraction[row, "xyz".index(direction)] = mode.participation**2 / roll.mass_total
            tip[row] = mode.tip if direction == case.direction else 0.0
            share[row] = tip[row] * mode.participation
    nodes, cells, shapes = _shapes(roll.model, listed, case.mesh.circumferential)
    dataset = xr.Dataset(
        {
            "mode_frequency": ("mode", np.array([mode.frequency_hz for mode, _ in listed])),
            "mode_kind": ("mode", np.array([mode.kind for mode, _ in listed])),
            "mode_harmonic": ("mode", np.array([mode.symmetry.wave_number for mode, _ in listed])),
            "mode_residual": ("mode", np.array([mode.residual for mode, _ in listed])),
            "effective_mass_fraction": (("mode", "component"), fraction),
            "tip_participation": ("mode", share),
            "mode_shape": (("mode", "node", "component"), shapes),
            "node_position": (("node", "component"), nodes),
            "cell_nodes": (("cell", "corner"), cells),
        },
        coords={"mode": np.arange(1, len(listed) + 1), "component": ["x", "y", "z"]},
    )
    if case.probes:
        dataset = _with_probes(dataset, case, roll, listed, tip)
    dofs = 3 * len(roll.model.nodes)
    dataset.attrs |= {"dofs": dofs, "interface_points": 0, "mass_total_kg": roll.mass_total}
    return annotate(dataset)


def _with_probes(
    dataset: xr.Dataset, case: RollModalCase, roll: FourierRoll, modes: list[tuple[FourierMode, bool]], tip: FloatArray
) -> xr.Dataset:
    """Dataset with the modal displacements at the tip (along the excitation) and at the probes of the case."""
    from wroll_fem.analyses.shared.assembly import named_probes
    from wroll_fem.fem.fourier_probe import mode_at_probe
    from wroll_fem.mesh.generate import shell_layout

    radius = {name: at for name, at, _ in shell_layout(case)}
    probes = named_probes(case.probes)
    rows = [
        [mode_at_probe(roll, mode, probe, radius[probe.body], turned=turned) for mode, turned in modes]
        for probe in probes.values()
    ]
    return dataset.assign_coords(probe=["tip", *probes]).assign(
        mode_at_probe=(("mode", "probe"), np.array([tip, *rows]).T)
    )


def _shapes(
    model: FourierModel, modes: list[tuple[FourierMode, bool]], around: int
) -> tuple[FloatArray, npt.NDArray[np.int64], FloatArray]:
    """Nodes (n, 3), cells (c, 9) and mode shapes (modes, n, 3; largest value 1) on the revolved outer surface."""
    outline = model.half_plane.outline
    nodes, cells = revolve(outline, around)
    values = model.evaluate(np.column_stack([mode.values for mode, _ in modes]), outline)[0]
    amplitudes = values.reshape(len(outline), len(modes), 3)
    shapes = np.array(
        [
            cartesian(amplitudes[:, k], mode.symmetry.wave_number, around, turned)
            for k, (mode, turned) in enumerate(modes)
        ]
    )  # fmt: skip
    largest = np.linalg.norm(shapes, axis=2).max(axis=1)
    return nodes, cells, shapes / largest[:, None, None]
