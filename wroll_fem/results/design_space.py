"""Stiffness of the secondary mass that tunes it to the primary mass (two-mass model)."""

from __future__ import annotations

import numpy as np
import xarray as xr

from wroll_fem.typing import FloatArray


def tuned_stiffness(dataset: xr.Dataset) -> tuple[float, FloatArray] | None:
    """Stiffness k_2 of the secondary spring at which both uncoupled masses have the same natural frequency.

    Equations 5.6 and 5.7 of the thesis give the masses and stiffness at a friction capacity: k_2'/m_2' = k_1/m_1'.

    Parameters
    ----------
    dataset
        Result of the analysis two_dof with a design space.

    Returns
    -------
    (float, (n,) array) or None
        Friction capacity that is optimal for most designs, N, and k_2 for each m_2 of the design space, N/m. None if
        the secondary mass is not supported by the base, or no design has a damping estimate.
    """
    attrs, best = dataset.attrs, dataset["capacity_at_zeta_max"].values
    known, count = np.unique(best[np.isfinite(best)], return_counts=True)
    if attrs.get("arrangement") != "both_on_base" or known.size == 0:
        return None
    capacity = float(known[count.argmax()])
    share = np.tanh(0.5 * capacity) if attrs["preload_dependent"] else 1.0
    m2 = dataset["m2"].values
    return capacity, m2 * attrs["primary_stiffness_n_m"] / (attrs["primary_mass_kg"] + m2 * (1.0 - share))
