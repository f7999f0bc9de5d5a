"""Base acceleration at which slip starts in a coil whose wraps slide: first point, and average over a length."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.constants import g as GRAVITY

from wroll_fem.coiled_stiff.shear_points import ShearPoints
from wroll_fem.coiled_stiff.slip_start import averaged_start, start_at_points
from wroll_fem.contact.point import tangentials
from wroll_fem.dynamics.statics.load_path import LoadPath
from wroll_fem.mesh.point_grid import coil_grid
from wroll_fem.typing import FloatArray

if TYPE_CHECKING:
    from wroll_fem.case import SlipDampingCase


def slip_onset(path: LoadPath, points: ShearPoints, mode: FloatArray, case: SlipDampingCase) -> dict[str, Any]:
    """Attributes of a Dataset: onset of slip in g, its place, and the onset averaged over the wall of the mandrel.

    The averaged onset is left out where the points form no grid, or the length holds less than one point.
    """
    system, start = path.system, path.start
    square = float(mode @ (path.stiffness @ mode))
    to_g = 2.0 * case.damping_ratio * square / abs(float(mode @ (system.mass @ system.influence))) / GRAVITY
    shear = tangentials(path.springs * (system.jump @ mode))
    mu, change = system.laws.mu, np.zeros(len(shear))
    if path.stress is not None:
        change = mu * (path.stress @ mode)
    limit = mu * start.pressure
    factor = start_at_points(shear, limit, change)
    first = int(np.argmin(factor))
    theta, z, r = (float(value) for value in points.points[first])
    found = {
        "slip_onset_g": float(factor[first]) * to_g, "slip_onset_theta_rad": theta, "slip_onset_height_m": z,
        "slip_onset_radius_m": r,
    }  # fmt: skip
    geometry, grid = case.geometry, coil_grid(points.points)
    inner = 0.5 * geometry.mandrel_outer_diameter
    place = f"{1e3 * z:.3g} mm above the base and {1e3 * (r - inner):.3g} mm from the mandrel"
    text = (
        f"the first point slips at {found['slip_onset_g']:.3g} g, {place}; the stress is singular at edges of the "
        "coil: finer elements give a lower value there"
    )
    length, coil = geometry.mandrel_thickness, case.coil.total_thickness
    if grid is None:
        return found | {"slip_onset_statement": text}
    if length < 2.0 * max(float(grid.z[0]), float(grid.r[0]) - inner):
        return found | {"slip_onset_statement": f"{text}; elements are too large for a mean over {1e3 * length:.3g} mm"}
    averaged = to_g * averaged_start(
        grid, points.volumes, shear, limit, length, r=(inner, inner + coil), height=geometry.length, change=change
    )
    return found | {
        "slip_onset_averaged_g": averaged, "slip_onset_length_m": length,
        "slip_onset_statement": f"{text}; averaged over {1e3 * length:.3g} mm slip starts at {averaged:.3g} g",
    }  # fmt: skip
