"""Slip of layers relative to the mandrel and between layers, from the paths of their targets (thesis, eqs 3.2, 3.3)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from wroll_fem.errors import InputError
from wroll_fem.lab.slip_images.table import MANDREL, Member
from wroll_fem.typing import FloatArray


class Slip(NamedTuple):
    """Slip between the targets of one group.

    Attributes
    ----------
    group
        (n,) group of each pair.
    layer
        (n, 2) layers j1 and j2; j2 is 0 for the mandrel.
    value
        (frames, n, 2) slip along x and y, px; nan where one of the targets is lost.
    """

    group: np.ndarray
    layer: np.ndarray
    value: FloatArray


def mandrel_slip(position: FloatArray, members: Sequence[Member]) -> Slip:
    """Slip of each layer relative to the mandrel.

    Parameters
    ----------
    position
        (frames, targets, 2), px.
    members
        Table of the targets.

    Notes
    -----
    Thesis, eq. 3.2: s_i^j = r_i - x_i^j, the position of the mandrel's target of group i minus that of layer j. The
    distance at rest is part of it; amplitudes at the excitation frequency do not depend on it.
    """
    reference = {m.group: m.target for m in members if m.layer == MANDREL}
    layers = [m for m in members if m.layer != MANDREL]
    if not layers:
        raise InputError("the table has no target on a layer", key="table", remedy="fill in the column layer")
    value = np.stack([position[:, reference[m.group]] - position[:, m.target] for m in layers], axis=1)
    groups, numbers = (np.array([getattr(m, name) for m in layers]) for name in ("group", "layer"))
    return Slip(groups, np.stack([numbers, np.full_like(numbers, MANDREL)], axis=1), value)


def layer_slip(slip: Slip, relative_to: int | None = None) -> Slip:
    """Slip between two layers of one group.

    Parameters
    ----------
    slip
        Slip relative to the mandrel.
    relative_to
        Layer j2 of all pairs with a layer outside it, as in Fig. 3.22 of the thesis; None: each layer relative to the
        next one inside that has a target.

    Notes
    -----
    Thesis, eq. 3.3: s_i^(j1 - j2) = s_i^j1 - s_i^j2.
    """
    layers = slip.layer[:, 0]
    if relative_to is not None and relative_to not in layers:
        known = ", ".join(str(n) for n in sorted(set(layers.tolist())))
        raise InputError(
            f"no target on layer {relative_to}", key="relative_to", remedy=f"use one of the layers {known}"
        )
    pairs = []
    for outer, (group, layer) in enumerate(zip(slip.group, layers, strict=True)):
        inside = np.flatnonzero((slip.group == group) & (layers < layer))
        if relative_to is not None:
            inside = inside[layers[inside] == relative_to]
        if inside.size:
            pairs.append((outer, int(inside[np.argmax(layers[inside])])))
    if not pairs:
        return Slip(np.zeros(0, int), np.zeros((0, 2), int), np.zeros((len(slip.value), 0, 2)))
    outer, inner = np.array(pairs).T
    return Slip(
        slip.group[outer], np.stack([layers[outer], layers[inner]], axis=1), slip.value[:, outer] - slip.value[:, inner]
    )
