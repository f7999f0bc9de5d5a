"""Slip of a solid coil from one set of modes, for many levels, damping ratios, frequencies and winding tensions."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Self

import numpy as np
import xarray as xr

from wroll_fem.analyses.shared.assembly import DIRECTIONS, build_bodies, named_probes
from wroll_fem.analyses.shared.resolution import fourier_remark, frequency_remark
from wroll_fem.analyses.transient_results import CoilShape, remarks, transient_dataset
from wroll_fem.case.kinds import ModalTransientCase
from wroll_fem.coiled_stiff.stress_modes import ShearModes, needs_solid_coil
from wroll_fem.errors import InputError
from wroll_fem.typing import FloatArray
from wroll_fem.winding import WoundRoll, wound_roll

if TYPE_CHECKING:
    from wroll_fem.case import Case
    from wroll_fem.progress import Progress

_MODES = ("geometry", "mandrel", "coil", "mesh", "modal", "probes")
"""Case sections on which the modes depend, besides the direction of the excitation."""


def shear_modes(case: ModalTransientCase) -> ShearModes:
    """Modes with their shear stress, in the discretisation of the case (three-dimensional or Fourier).

    Raises
    ------
    InputError
        If the coil is not solid, or no mode has effective mass along the excitation.
    WrollError
        If the eigensolver misses modes or does not converge.
    """
    if case.coil.model != "solid":
        raise needs_solid_coil()
    material, count = case.coil.solid(), case.modal.count
    direction, probes = DIRECTIONS[case.direction], named_probes(case.probes)
    if case.mesh.discretisation == "fourier":
        from wroll_fem.coiled_stiff import fourier_stress
        from wroll_fem.fem.fourier_roll import FourierRoll
        from wroll_fem.mesh.axisymmetric import unrefined_mesh
        from wroll_fem.mesh.generate import shell_layout

        radius = {name: at for name, at, _ in shell_layout(case)}
        return fourier_stress.shear_modes(
            FourierRoll(case), material, unrefined_mesh(case), count=count, direction=direction,
            circumferential=case.mesh.circumferential,
            probes={name: (probe, radius[probe.body]) for name, probe in probes.items()},
        )  # fmt: skip
    from wroll_fem.coiled_stiff import solid_stress

    bodies = build_bodies(case, symmetric=False)
    return solid_stress.shear_modes(bodies, material, count=count, direction=direction, probes=probes)


@dataclass(frozen=True)
class SlipModel:
    """Modes of a coil with their shear stress, and the friction capacity from winding.

    The coil is linear, so one set of modes is valid for every excitation level, friction coefficient, damping ratio,
    frequency and winding.

    Attributes
    ----------
    case
        The case that was solved.
    modes
        Modes and their shear stress in the coil.
    roll
        Stress in its wound roll: `radius`, `pressure`, `capacity` (n,).
    """

    case: ModalTransientCase
    modes: ShearModes = field(repr=False)
    roll: WoundRoll = field(repr=False)

    @classmethod
    def of(cls, case: Case, *, progress: Progress | None = None) -> Self:
        """Solve a case of the analysis modal_transient for its modes and its winding pressure.

        Raises
        ------
        InputError
            If the case has another analysis.
        """
        from wroll_fem.progress import SilentProgress

        if not isinstance(case, ModalTransientCase):
            remedy = "use analysis: modal_transient"
            problem = f"SlipModel needs analysis: modal_transient, got {case.analysis}"
            raise InputError(problem, key="analysis", remedy=remedy)
        progress = progress if progress is not None else SilentProgress()
        with progress.stage("winding", 1) as stage:
            roll = wound_roll(case.wound)
            stage.update(1)
        with progress.stage("modes and their stress", 1) as stage:
            modes = shear_modes(case)
            stage.update(1, f"{len(modes.frequencies_hz)} modes, {len(modes.volumes)} quadrature points")
        fourier = case.mesh.discretisation == "fourier"
        remark = fourier_remark(case) if fourier else frequency_remark(case, modes.kinds, modes.frequencies_hz.tolist())
        if remark:
            progress.warning(remark)
        return cls(case, modes, roll)

    def run(self, case: Case | None = None, *, progress: Progress | None = None) -> xr.Dataset:
        """Compute the result of ``case`` from the stored modes; None means the case for which they were computed.

        Parameters
        ----------
        case
            For example ``model.case.changed({"excitation.amplitude_g": [1, 5], "winding.mu": 0.3})``.
        progress
            Receives a stage, and warnings about the result.

        Raises
        ------
        InputError
            If the case has different modes.
        """
        from wroll_fem.progress import SilentProgress

        case = self.case if case is None else self._same_modes(case)
        progress = progress if progress is not None else SilentProgress()
        wound, excitation = case.wound, case.excitation
        roll = self.roll if wound == self.case.wound else wound_roll(wound)
        radius = 0.5 * case.geometry.mandrel_outer_diameter
        shape = CoilShape(radius, radius + case.coil.total_thickness, case.geometry.length)
        with progress.stage("response and slip", 1) as stage:
            frequency = None if excitation.frequency == "resonance" else float(excitation.frequency)
            dataset = transient_dataset(
                self.modes, lambda r: roll.capacity_at(in_wound_roll(r, shape, roll.radius)), shape,
                damping_ratio=case.damping_ratio, frequency_hz=frequency, levels_g=excitation.amplitude_g,
            )  # fmt: skip
            stage.update(1)
        dataset.attrs["excitation_direction"] = excitation.direction
        for text in remarks(dataset):
            progress.warning(text)
        return dataset

    def _same_modes(self, case: Case) -> ModalTransientCase:
        if not isinstance(case, ModalTransientCase):
            changed = ["analysis"]
        elif changed := [name for name in _MODES if getattr(case, name) != getattr(self.case, name)]:
            pass
        elif case.excitation.direction != self.case.excitation.direction:
            changed = ["excitation.direction"]
        else:
            return case
        remedy = "make a new model with SlipModel.of(case), or run the case"
        raise InputError("changes the modes of the slip model", key=", ".join(changed), remedy=remedy)


def in_wound_roll(radius: FloatArray, shape: CoilShape, wound: FloatArray) -> FloatArray:
    """Map radii of the coil to radii of the wound roll, whose size may differ slightly.

    Without the map, the outer surface of a slightly thicker coil would have no capacity.
    """
    share = (radius - shape.mandrel_radius) / (shape.outer_radius - shape.mandrel_radius)
    return np.asarray(wound[0] + share * (wound[-1] - wound[0]))
