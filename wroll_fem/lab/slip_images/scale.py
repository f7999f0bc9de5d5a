"""Length of a pixel from the known size of the targets, with its error."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from wroll_fem.errors import InputError
from wroll_fem.typing import FloatArray

EDGE = 0.5
"""Uncertainty of a measured diameter, px: where the threshold cuts the blurred edge, the same for all targets."""


class Scale(NamedTuple):
    """Length of a pixel.

    Attributes
    ----------
    value
        m/px.
    error
        Standard error, m/px.
    """

    value: float
    error: float

    @property
    def relative(self) -> float:
        """Error over value."""
        return self.error / self.value


def pixel_length(known: FloatArray, measured: FloatArray, tolerance: float = 0.0) -> Scale:
    """Length of a pixel from targets of known size.

    Parameters
    ----------
    known
        (n,) diameters, m.
    measured
        (n,) diameters in the images, px.
    tolerance
        Standard uncertainty of the known diameters, m, the same for all.

    Notes
    -----
    The value is the sum of the known over the sum of the measured diameters. Its error has three parts: the scatter
    between the targets over sqrt(n), the tolerance of the targets, and the position of the edge (`EDGE`).

    Raises
    ------
    InputError
        If the sizes contradict each other: the scatter exceeds a fifth.
    """
    each = known / measured
    value = float(known.sum() / measured.sum())
    scatter = float(np.std(each, ddof=1)) / value if len(each) > 1 else 0.0
    if scatter > 0.2:
        raise InputError(
            f"the known sizes of the targets contradict the images: {1e3 * each.min():.3g} to {1e3 * each.max():.3g} "
            "mm/px", key="target_diameter", remedy="give each outer diameter in the column diameter_mm of the table",
        )  # fmt: skip
    parts = (scatter / np.sqrt(len(each)), tolerance / float(known.mean()), EDGE / float(measured.mean()))
    return Scale(value, value * float(np.sqrt(np.sum(np.square(parts)))))
