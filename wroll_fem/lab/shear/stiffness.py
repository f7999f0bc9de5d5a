r"""Shear stiffness and modulus of a record, without the compliance of the fixture.

Two stacks act in parallel (claim C121 of the thesis):

.. math:: K = \frac{2 G A}{t}, \qquad G = \frac{K t}{2 A}

Equations E.2 and E.3 of the thesis omit the factor of two, which its equation E.5 has: they give 2 G.
"""

from __future__ import annotations

import numpy as np

from wroll_fem.lab.shear.events import rises_between
from wroll_fem.lab.shear.fixture import Fixture
from wroll_fem.lab.shear.record import ShearRecord
from wroll_fem.numerics.inference import Estimate, linear_fit
from wroll_fem.tribology.shear_test import modulus_of

WINDOW = (0.1, 0.8)
"""Fractions of the capacity between which the stiffness is fitted; below, the fixture settles."""


def stiffness(
    record: ShearRecord, top: float, stop: int, *, window: tuple[float, float] = WINDOW, fixture: Fixture | None = None
) -> tuple[Estimate, bool]:
    """Shear stiffness K of both stacks, N/m, and whether the record departs from a straight line.

    Parameters
    ----------
    record
        Record, with the displacement as measured.
    top
        Force to which the window refers, N: the capacity.
    stop
        Samples before this index are used.
    window
        Lower and upper end of the window, relative to ``top``.
    fixture
        Compliance of the fixture, subtracted with its error.

    Notes
    -----
    The slope is fitted with the time as instrument, so that noise of the displacement does not lower it.

    Raises
    ------
    InputError
        If fewer than ten samples lie in the window, or the fixture alone is softer than the whole.
    """
    start, end = rises_between(record, window[0] * top, window[1] * top, stop)
    own = record.part(start, end)
    ones = np.ones(len(own.time))
    time = own.time - own.time[0]
    found = linear_fit({"offset": ones, "slope": own.displacement - own.displacement[0]}, own.force,
                       instruments={"offset": ones, "time": time})  # fmt: skip
    slope = found["slope"]
    value = slope if fixture is None else fixture.removed(slope, own)
    return value, found.correlated


def moduli(stiffness: Estimate, area: float, thickness: float) -> tuple[Estimate, Estimate]:
    """Shear modulus G = K t/(2 A) of a stack, Pa, and the value K t/A of equations E.2 and E.3, twice as large.

    Parameters
    ----------
    stiffness
        Stiffness of both stacks, N/m.
    area, thickness
        Contact area of a stack, m^2; its thickness, m.
    """
    right = stiffness.scaled(modulus_of(1.0, area, thickness))
    return right, right.scaled(2.0)
