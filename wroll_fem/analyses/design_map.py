"""Design map of mandrels: bending frequency with the stiffest coil minus that with the softest (thesis, Fig. 2.16)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from wroll_fem.analyses.forecasts.computing_time import SECONDS_PER_FOURIER_DOF, fourier_dofs
from wroll_fem.analyses.registry import Analysis
from wroll_fem.analyses.shared.figures import figure
from wroll_fem.analyses.shared.resolution import fourier_remark
from wroll_fem.case.coil import Coil
from wroll_fem.case.geometry import Geometry
from wroll_fem.case.roll import RollSections
from wroll_fem.results.dataset import annotate

if TYPE_CHECKING:
    from wroll_fem.case import DesignMapCase
    from wroll_fem.fem.fourier import FourierModel
    from wroll_fem.progress import Progress

_NUMBERS = ("frequency_tightest", "frequency_loosest", "frequency_mandrel", "loosest_shear_modulus")


@dataclass(frozen=True)
class Design:
    """Bending frequencies of a mandrel with stiffest and softest coil, Hz; nan if bending is not the fundamental mode.

    Attributes
    ----------
    frequency_tightest, frequency_loosest, frequency_mandrel
        Bending frequency with the stiffest coil (that of the case), with the softest coil, and without coil.
    loosest_shear_modulus
        Shear modulus between wraps of the softest coil, Pa.
    limit_kind
        Kind of the mode that lies below bending if the coil is made softer. If a frequency is nan: kind of the
        fundamental mode. "" if the case sets the softest coil, or if bending is always the lowest mode.
    """

    frequency_tightest: float
    frequency_loosest: float
    frequency_mandrel: float
    loosest_shear_modulus: float
    limit_kind: str


class _Models:
    """Finite-element models with and without coil, reused so that their variational forms are compiled only once."""

    def __init__(self) -> None:
        self._with: FourierModel | None = None
        self._without: FourierModel | None = None

    def design(self, case: DesignMapCase, geometry: Geometry) -> Design:
        """Bending frequencies of a mandrel with the coil of the case, and without coil."""
        from wroll_fem.coiled_stiff.frequency_bounds import fundamental, softest_coil, with_shear_modulus
        from wroll_fem.fem.fourier_modes import symmetry_class_modes
        from wroll_fem.fem.fourier_roll import BENDING, FourierRoll

        mandrel, mesh = case.mandrel, case.mesh
        without = RollSections(geometry=geometry, mandrel=mandrel, coil=Coil(model="none"), mesh=mesh)
        bare = FourierRoll(without, self._without)
        roll = FourierRoll(RollSections(geometry=geometry, mandrel=mandrel, coil=case.coil, mesh=mesh), self._with)
        self._without, self._with = bare.model, roll.model
        alone = symmetry_class_modes(bare, BENDING, 1)[0].frequency_hz
        material = case.coil.solid()
        modulus = case.design_map.softest
        if isinstance(modulus, str):
            found = softest_coil(roll, material)
            if found is None:
                roll.set_coil(material)
                return Design(np.nan, np.nan, alone, np.nan, fundamental(roll).kind)
            low, high = found.bending.frequency_hz, found.stiffest.frequency_hz
            return Design(high, low, alone, found.shear_modulus, found.competing_kind)
        tight = fundamental(roll)
        roll.set_coil(with_shear_modulus(material, modulus))
        loose = fundamental(roll)
        high, low = (mode.frequency_hz if mode.symmetry == BENDING else np.nan for mode in (tight, loose))
        kinds = [mode.kind for mode in (tight, loose) if mode.symmetry != BENDING]
        return Design(high, low, alone, modulus, kinds[0] if kinds else "")


def run_design_map(case: DesignMapCase, *, progress: Progress) -> xr.Dataset:
    """Compute the frequency disparity between stiffest and softest coil for the mandrels of the map and of the case.

    Returns
    -------
    xr.Dataset
        `frequency_tightest`, `frequency_loosest`, `frequency_disparity`, `frequency_mandrel`, `loosest_shear_modulus`,
        `limit_kind` over (mandrel_radius, mandrel_thickness); the mandrel of the case in the attributes `own_*`.
    """
    radii, walls = case.design_map.mandrel_radius, case.design_map.mandrel_thickness
    models = _Models()
    designs: list[Design] = []
    with progress.stage("designs", len(radii) * len(walls) + 1) as stage:
        own = models.design(case, case.geometry)
        for radius in radii:
            for wall in walls:
                stage.update(len(designs) + 1)
                geometry = Geometry(
                    length=case.geometry.length, mandrel_outer_diameter=2 * radius, mandrel_thickness=wall
                )
                designs.append(models.design(case, geometry))
        stage.update(len(designs) + 1, f"{len(designs)} mandrels")
    if remark := fourier_remark(case):
        progress.warning(remark)
    shape, dims = (len(radii), len(walls)), ("mandrel_radius", "mandrel_thickness")
    fields: dict[str, Any] = {
        name: (dims, np.array([getattr(design, name) for design in designs]).reshape(shape)) for name in _NUMBERS
    }
    fields["frequency_disparity"] = (dims, fields["frequency_tightest"][1] - fields["frequency_loosest"][1])
    fields["limit_kind"] = (dims, np.array([design.limit_kind for design in designs]).reshape(shape))
    dataset = xr.Dataset(fields, coords={"mandrel_radius": radii, "mandrel_thickness": walls})
    dataset.attrs |= {f"own_{name}": getattr(own, name) for name in (*_NUMBERS, "limit_kind")}
    dataset.attrs |= {
        "own_mandrel_radius": 0.5 * case.geometry.mandrel_outer_diameter,
        "own_mandrel_thickness": case.geometry.mandrel_thickness,
    }
    return annotate(dataset)


def summarise_design_map(dataset: xr.Dataset) -> dict[str, Any]:
    """Flat summary: mandrel of the case, and the mandrels with the largest and smallest disparity."""
    own = {name: dataset.attrs[f"own_{name}"] for name in _NUMBERS}
    disparity = dataset["frequency_disparity"]
    summary: dict[str, Any] = {
        "disparity_hz": own["frequency_tightest"] - own["frequency_loosest"],
        "f_tightest_hz": own["frequency_tightest"],
        "f_loosest_hz": own["frequency_loosest"],
        "f_mandrel_hz": own["frequency_mandrel"],
        "loosest_shear_modulus_pa": own["loosest_shear_modulus"],
        "designs": int(disparity.size),
        "designs_without_disparity": int(disparity.isnull().sum()),
    }
    summary = {key: None if isinstance(value, float) and np.isnan(value) else value for key, value in summary.items()}
    if disparity.notnull().any():
        for name, at in (("largest", disparity.argmax(...)), ("smallest", disparity.argmin(...))):
            there = disparity.isel(at)  # type: ignore[arg-type]
            summary[f"disparity_{name}_hz"] = float(there)
            summary[f"disparity_{name}_mandrel_radius_m"] = float(there["mandrel_radius"])
            summary[f"disparity_{name}_mandrel_thickness_m"] = float(there["mandrel_thickness"])
    return summary


def estimate_design_map(case: DesignMapCase) -> dict[str, Any]:
    """Number of DOFs per circumferential wave number, number of mandrels, and approximate computing time."""
    dofs = fourier_dofs(case)
    designs = len(case.design_map.mandrel_radius) * len(case.design_map.mandrel_thickness) + 1
    seconds = 2.0 + 26 * SECONDS_PER_FOURIER_DOF * dofs * designs
    return {"dofs": dofs, "designs": designs, "estimated_seconds": seconds}


ANALYSIS = Analysis(
    name="design_map",
    sentence="Bending frequencies with the softest and stiffest coil versus mandrel radius and wall.",
    sections=("geometry", "mandrel", "coil", "design_map", "mesh"),
    run=run_design_map,
    summary=(summarise_design_map,),
    figures=(figure("design_map", "design_map"),),
    variables={
        "mandrel_radius, mandrel_thickness": (
            "frequency_tightest", "frequency_loosest", "frequency_disparity", "frequency_mandrel", "limit_kind",
        ),
    },
    plots=("design_map",),
    estimate=estimate_design_map,
)  # fmt: skip
