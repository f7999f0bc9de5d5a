"""Mesh checks: natural frequencies without friction against those of a finer mesh, contact points at free edges."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from wroll_fem.case.kinds import ModalCase
from wroll_fem.case.roll import RollSections
from wroll_fem.case.structural import OnRoll

if TYPE_CHECKING:
    from wroll_fem.dynamics.system.system import System
    from wroll_fem.fem.fourier_roll import SymmetryClass

TOLERANCE = 0.01
"""Relative difference between the natural frequencies of the mesh and of the finer mesh, above which a run warns."""

COILS = ("solid", "bonded", "nonstructural_mass", "none")
"""Coil models whose mesh is checked: those without friction, which semi-analytical elements can represent."""

AT_EDGE = 1e-6
"""Distance of the highest contact point from the upper edge of its surface, relative to the length, up to which it lies
on the edge."""

_FINE = {"axial": 24, "grading": 12.0, "radial": 3, "radial_grading": 10.0}
"""Keys of the section `mesh` -> their smallest values in the finer mesh. Its semi-analytical elements are cubic.
`mesh.axisymmetric.refined_mesh` adds cells at the clamp, at the tip and at the inner surface of the coil."""

_LOWEST = 8  # modes among which the one with the largest effective mass is the first bending mode
_RIGID = 2  # most rigid motions of a symmetry class


def frequency_remark(case: OnRoll, kinds: Sequence[str], hertz: Sequence[float], *, pairs: bool = True) -> str:
    """Warning about the least accurate natural frequency, if its error exceeds `TOLERANCE`; empty otherwise.

    The reference is a finer mesh of semi-analytical (Fourier) elements, an independent discretisation of the same roll.
    It takes about a second. Bending, ovalling and torsion are compared. Walls of plies or of variable thickness, coils
    with margins and coils whose moduli vary are not checked: Fourier elements do not describe them.

    Parameters
    ----------
    case
        Case on a roll.
    kinds, hertz
        Kind (`wroll_fem.bodies.mode_shapes`) and frequency of the lowest modes of the mesh.
    pairs
        Whether both modes of a degenerate pair are listed.
    """
    if case.coil.model not in COILS or case.mesh.file is not None or not case.suits_fourier:
        return ""
    bonded = isinstance(case, ModalCase) and case.modal.interface == "bonded"
    if case.coil.wrap_interfaces is not None or (case.coil.rubs and not bonded):
        return ""  # Fourier elements have no springs between coil and mandrel
    from wroll_fem.fem.fourier_modes import symmetry_class_modes
    from wroll_fem.fem.fourier_roll import FourierRoll

    roll = FourierRoll(finer(case, _FINE))
    worst, text = TOLERANCE, ""
    for kind in dict.fromkeys(kinds):
        symmetry = _symmetry(kind)
        if symmetry is None:
            continue
        own = np.sort([f for name, f in zip(kinds, hertz, strict=True) if name == kind])
        own = own[::2] if pairs and symmetry.wave_number else own
        modes = symmetry_class_modes(roll, symmetry, len(own) + _RIGID)
        finest = [mode.frequency_hz for mode in modes if mode.kind == kind]
        for number, (f, reference) in enumerate(zip(own, finest, strict=False), start=1):
            if abs(f / reference - 1.0) > worst:
                worst, text = abs(f / reference - 1.0), _described(kind, number, f, reference)
    return text and f"{text}; {_remedy(case)}"


def system_remark(case: OnRoll, system: System) -> str:
    """Warning of `frequency_remark` about the first bending mode of an assembled system; empty if it has interfaces."""
    if case.coil.model not in COILS or case.mesh.file is not None or system.interfaces:
        return ""
    from wroll_fem.fem.eigen import DEFAULT_SHIFT, solve_pairs

    pairs = solve_pairs(system.stiffness, system.mass, _LOWEST, DEFAULT_SHIFT)
    main = np.argmax(np.abs(pairs.vectors.T @ (system.mass @ system.influence)))
    return frequency_remark(case, ["bending"], [float(np.sqrt(pairs.values[main])) / (2 * np.pi)], pairs=False)


def edge_remark(case: OnRoll, system: System) -> str:
    """Warning about contact points at the vertices of a mesh from a file; empty if they are inside the elements.

    Half an element at a free edge is then left to slide (`wroll_fem.mesh.contact_points`).
    """
    if case.mesh.file is None or not system.interfaces:
        return ""
    length = case.geometry.length
    if all(length - float(interface.points[:, 1].max()) > AT_EDGE * length for interface in system.interfaces):
        return ""
    return (
        "the elements of mesh.file form no rows of equal width, so that contact acts at their vertices: half an "
        "element at a free edge is left to slide, and layers that stick are 1 to 2 % low in frequency; use rows, or "
        "elements that are small at the edges"
    )


def fourier_remark(case: OnRoll) -> str:
    """Warning if doubling `mesh.axial` and `mesh.radial` changes the first bending frequency by more than `TOLERANCE`.

    Empty otherwise. Both meshes consist of semi-analytical (Fourier) elements.
    """
    from wroll_fem.fem.fourier_modes import symmetry_class_modes
    from wroll_fem.fem.fourier_roll import BENDING, FourierRoll

    twice = {"axial": 2 * case.mesh.axial, "radial": 2 * case.mesh.radial}
    f, reference = (
        symmetry_class_modes(FourierRoll(roll), BENDING, 1)[0].frequency_hz for roll in (case, finer(case, twice))
    )
    if abs(f / reference - 1.0) <= TOLERANCE:
        return ""
    return f"{_described('bending', 1, f, reference)}; {_remedy(case)}"


def finer(roll: RollSections, least: Mapping[str, float]) -> RollSections:
    """Case sections of a roll; each value in ``least`` is a lower limit for a key of the section `mesh`."""
    mesh = roll.mesh.model_copy(update={key: max(getattr(roll.mesh, key), value) for key, value in least.items()})
    return RollSections(geometry=roll.geometry, mandrel=roll.mandrel, coil=roll.coil, mesh=mesh)


def _symmetry(kind: str) -> SymmetryClass | None:
    from wroll_fem.fem.fourier_roll import TORSION, symmetry_classes

    if kind == "torsion":
        return TORSION
    number = kind.removeprefix("ovalling-")
    wave_number = 1 if kind == "bending" else int(number) if number.isdigit() else 0
    return symmetry_classes(wave_number)[0] if wave_number else None


def _described(kind: str, number: int, f: float, reference: float) -> str:
    return (
        f"the mesh does not resolve the modes: {kind} mode {number} has {f:.4g} Hz, "
        f"{100 * (f / reference - 1):+.1f} % from the {reference:.4g} Hz of finer elements"
    )


def _remedy(case: OnRoll) -> str:
    if case.coil.model in ("nonstructural_mass", "none"):
        return "raise mesh.axial or mesh.circumferential (ovalling)"
    radial = ", mesh.radial or mesh.radial_grading" if case.coil.model == "solid" else ""
    return f"raise mesh.axial or mesh.grading (root of the coil){radial}, or mesh.circumferential (ovalling)"
