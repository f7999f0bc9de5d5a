"""Classification of modes (bending, torsion, axial, breathing, ovalling-n) and effective masses.

On each ring of nodes, the displacement in cylindrical components is expanded in a Fourier series over theta. The
contribution of wave number n is the sum over rings and components of |c_n|^2, weighted by the tributary height of the
ring and by the mass per height of the body. A solid coil is treated as a stack of cylinders of nodes. For wave
number 1 the axis is displaced (bending); for n >= 2 it stays in place (ovalling).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from wroll_fem.bodies.body import Body
from wroll_fem.bodies.levels import levels
from wroll_fem.typing import FloatArray

_HIGHEST = 12
_NO_STRAIN = 1.0  # (rad/s)^2: modes with a smaller Rayleigh quotient are rigid-body motions
_AXISYMMETRIC = ("torsion", "axial", "breathing")  # dominant component of n = 0: hoop, axial, radial


@dataclass(frozen=True)
class ModeKind:
    """Kind of a mode, its dominant circumferential wave number, and the fraction of the motion with this wave number.

    Attributes
    ----------
    kind
        "bending", "torsion", "axial", "breathing", "ovalling-n" or, for motions without strain, "rigid".
    wave_number
        Dominant circumferential wave number n.
    share
        Fraction of the mean square displacement with this wave number, 0 to 1.
    """

    kind: str
    wave_number: int
    share: float


def circumferential_content(body: Body, vector: FloatArray, highest: int = _HIGHEST) -> FloatArray:
    """Mean square displacement of a mode, split by circumferential wave number and component.

    Parameters
    ----------
    body
        Body whose nodes lie on concentric rings; its solid coil is included.
    vector
        (n_dofs,) amplitudes of the unknowns of the body.
    highest
        Largest wave number; rings with fewer than 2 n + 1 nodes do not contribute to wave number n.

    Returns
    -------
    (highest + 1, 3) mean square displacement of (hoop, axial, radial) times the mass of the body, kg m^2.
    """
    content, solid = np.zeros((highest + 1, 3)), body.solid
    if len(body.nodes):
        u = (body.expand @ vector).reshape(-1, 6)[:, :3]
        content += _ring_content(body.nodes, u, highest) * (body.mass_total - (solid.mass if solid else 0.0))
    if solid is None:
        return content
    layers = solid.layers
    nodes, shape = solid.nodes.reshape(layers, -1, 3), (solid.expand @ vector).reshape(layers, -1, 3)
    radius = np.hypot(nodes[:, 0, 0], nodes[:, 0, 1])
    step = np.diff(radius)
    share = radius * (np.append(step, 0.0) + np.append(0.0, step))  # mass fraction of each layer of nodes
    for k, part in enumerate(share / share.sum()):
        content += _ring_content(nodes[k], shape[k], highest) * part * solid.mass
    return content


def _ring_content(nodes: FloatArray, u: FloatArray, highest: int) -> FloatArray:
    """Mean square displacement of the nodes of one cylinder, for wave numbers 0 to highest (rows) and three components.

    ``nodes`` and ``u`` are the positions and displacements (n, 3) of the nodes. The result (highest + 1, 3) has the
    columns hoop, axial, radial.
    """
    x, y, z = nodes.T
    theta = np.arctan2(y, x)
    cos, sin = np.cos(theta), np.sin(theta)
    local = np.column_stack([-sin * u[:, 0] + cos * u[:, 1], u[:, 2], cos * u[:, 0] + sin * u[:, 1]])
    height, ring_of = levels(z)
    step = np.diff(height)
    weight = 0.5 * (np.append(step, 0.0) + np.append(0.0, step)) if step.size else np.ones(1)
    content = np.zeros((highest + 1, 3))
    for k in range(len(height)):
        ring = np.flatnonzero(ring_of == k)
        ring = ring[np.argsort(theta[ring])]
        arc = np.diff(theta[ring], append=theta[ring[0]] + 2 * np.pi)
        share = 0.5 * (arc + np.roll(arc, 1)) / (2 * np.pi)
        waves = np.arange(min(highest, (len(ring) - 1) // 2) + 1)
        c = np.exp(-1j * np.outer(waves, theta[ring])) @ (share[:, None] * local[ring])
        content[waves] += weight[k] * np.where(waves == 0, 1.0, 2.0)[:, None] * np.abs(c) ** 2
    return content / weight.sum()


def classify_mode(bodies: Sequence[Body], vector: FloatArray, highest: int = _HIGHEST) -> ModeKind:
    """Classify a mode of one or more bodies.

    Parameters
    ----------
    bodies
        Bodies whose unknowns are concatenated in `vector`.
    vector
        (sum of n_dofs,) mode.
    highest
        Largest circumferential wave number considered.

    Raises
    ------
    ValueError
        If the length of `vector` is not the total number of unknowns.
    """
    ends = np.cumsum([body.n_dofs for body in bodies])
    if ends[-1] != len(vector):
        raise ValueError(f"the mode has {len(vector)} unknowns but the bodies have {ends[-1]}")
    parts = np.split(vector, ends[:-1])
    content = sum(circumferential_content(body, part, highest) for body, part in zip(bodies, parts, strict=True))
    per_wave = np.asarray(content).sum(axis=1)
    n = int(per_wave.argmax())
    strain = sum(float(part @ (body.stiffness @ part)) for body, part in zip(bodies, parts, strict=True))
    inertia = sum(float(part @ (body.mass @ part)) for body, part in zip(bodies, parts, strict=True))
    if strain < _NO_STRAIN * inertia:
        kind = "rigid"
    elif n == 0:
        kind = _AXISYMMETRIC[int(np.asarray(content)[0].argmax())]
    else:
        kind = "bending" if n == 1 else f"ovalling-{n}"
    return ModeKind(kind, n, float(per_wave[n] / max(per_wave.sum(), 1e-300)))


def main_bending(kinds: Sequence[str], fractions: FloatArray) -> int | None:
    """Index of the bending mode with the largest effective mass, or None if there is no bending mode.

    Parameters
    ----------
    kinds
        (n_modes,) kinds of the modes, as in `ModeKind.kind`.
    fractions
        (n_modes,) or (n_modes, 3) effective mass fractions; with three components the largest one is used.
    """
    share = np.asarray(fractions, float).reshape(len(kinds), -1).max(axis=1)
    bending = [k for k, kind in enumerate(kinds) if str(kind) == "bending"]
    return max(bending, key=lambda k: (round(float(share[k]), 6), -k)) if bending else None


def effective_mass_fractions(
    mass: sp.spmatrix, influence: FloatArray, vectors: FloatArray, mass_total: float
) -> FloatArray:
    """Effective mass fractions of modes along x, y and z.

    Parameters
    ----------
    mass
        (n, n) mass matrix, kg.
    influence
        (n, 3) displacement of the unknowns under unit translations of the base along x, y and z.
    vectors
        (n, n_modes) modes, M-normalised.
    mass_total
        Mass to which the effective masses are referred, kg.

    Returns
    -------
    (n_modes, 3) effective mass divided by `mass_total`.
    """
    return (vectors.T @ (mass @ influence)) ** 2 / mass_total


_DEGENERATE = 1e-5
"""Largest relative frequency difference of two modes that count as a degenerate pair."""


def are_degenerate(frequencies_hz: FloatArray, k: int) -> bool:
    """Whether modes k and k + 1 are a degenerate pair (equal frequencies)."""
    low, high = frequencies_hz[k : k + 2]
    return bool(abs(high - low) <= _DEGENERATE * max(high, 1e-6))


def align_pairs(
    frequencies_hz: FloatArray, vectors: FloatArray, mass: sp.spmatrix, influence: FloatArray
) -> FloatArray:
    """Rotate the modes of each degenerate pair so that a base motion along x excites only the first mode of the pair.

    The bending modes of an axisymmetric roll form pairs whose directions are arbitrary; after the rotation the first
    bends along x and the second along y. Pairs without effective mass are not changed. A single mode of a pair at the
    end of the list keeps its arbitrary direction, so compute one mode more than needed.

    Parameters
    ----------
    frequencies_hz
        (n_modes,) natural frequencies, Hz, ascending.
    vectors
        (n, n_modes) modes, M-normalised.
    mass
        (n, n) mass matrix, kg.
    influence
        (n, 3) displacement of the unknowns under unit translations of the base.

    Returns
    -------
    (n, n_modes) rotated modes.
    """
    aligned, k = vectors.copy(), 0
    along_x = mass @ influence[:, 0]
    while k + 1 < len(frequencies_hz):
        if not are_degenerate(frequencies_hz, k):
            k += 1
            continue
        a, b = aligned[:, k : k + 2].T @ along_x
        size = float(np.hypot(a, b))
        if size > 1e-8 * np.sqrt(max(float(influence[:, 0] @ along_x), 1e-300)):
            turn = np.array([[a, -b], [b, a]]) / size
            aligned[:, k : k + 2] = aligned[:, k : k + 2] @ turn
        k += 2
    return aligned
