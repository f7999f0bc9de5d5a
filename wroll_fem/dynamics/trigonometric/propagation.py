r"""Exact propagation of damped modes over a step, under a base motion of degree 4 and forces that vary linearly.

With the displacement d of the modes, :math:`\ddot d + C \dot d + \Lambda d = f(t)`, the state y = (d, v) follows
:math:`y' = A y + (0, f)`. For :math:`f = \sum_j f_j \tau^j / j!` and the time :math:`\tau` in units of the step

.. math:: y(\tau) = \varphi_0(\tau A)\, y(0) + \sum_j \tau^{j+1} \varphi_{j+1}(\tau A)\, (0, f_j), \qquad
          \int_0^1 y\, d\tau = \varphi_1(A)\, y(0) + \sum_j \varphi_{j+2}(A)\, (0, f_j),

:math:`\varphi_0 = \exp`, :math:`\varphi_{k+1}(A) = A^{-1} (\varphi_k(A) - I / k!)`. These functions are Taylor series
of a small part of A, doubled. They hold for any damping (light, critical, coupled) and for modes without stiffness.

References
----------
Hochbruck, Ostermann (2010), Acta Numerica 19, 209, doi:10.1017/S0962492910000048 (exponential integrators).
Al-Mohy, Higham (2011), SIAM J. Sci. Comput. 33, 488, doi:10.1137/100788860 (phi functions).
"""

from __future__ import annotations

from collections.abc import Sequence
from math import factorial
from typing import NamedTuple

import numpy as np

from wroll_fem.typing import FloatArray, IntArray

NODES = np.array([0.0, 0.5 - np.sqrt(3.0 / 28.0), 0.5, 0.5 + np.sqrt(3.0 / 28.0), 1.0])
"""Places within a step at which the base acceleration is sampled, and the powers of base and dashpots: Lobatto's."""

WEIGHTS = np.array([0.05, 49.0 / 180.0, 16.0 / 45.0, 49.0 / 180.0, 0.05])
"""Weights of Lobatto's quadrature with `NODES`, exact to degree 7."""

INSIDE = len(NODES) - 2
"""Number of nodes within a step."""

OUTPUTS = 3 + INSIDE
"""Results of a step for each mode: d and v at its end, mean of d, then v at the nodes within the step."""

RESOLVED = 1.0
"""Angle of a mode in a step, rad, below which forces drive it exactly; 2 pi is one cycle per step."""

IMPLICIT = 0.55
"""Weight of the end of a step in the answer of the other modes to forces: 0.5 is the implicit midpoint rule without
numerical damping, and 0.55 takes 18 % of the fastest motion in a step."""

SMALL = 0.5
"""Norm of a part of A whose functions are Taylor series of `TERMS` terms; the error is below rounding."""

TERMS = 15


class Propagation(NamedTuple):
    """Coefficients of a step, block after block of coordinates.

    Attributes
    ----------
    starts : (n_blocks + 1,) index of the first coordinate of each block, then m
    state : flat array of the (OUTPUTS n_b, 4 n_b) matrices that act on d, v and the forces at both ends of a step
    base : (OUTPUTS, m, len(NODES)) results per unit base acceleration at each node
    resolved : (m,) bool, modes whose angle in a step is below `RESOLVED`, which forces drive exactly
    gain, shift : (m,) filter of the forces on these modes: factor on the force that drives d, dimensionless (0 for the
        other modes), and displacement q - d per force, s^2
    eigenvalues, rates : (m,) rad^2/s^2, and damping of each mode alone, 1/s
    mobility : (m,) 1 / (1 + w h rate + (w h)^2 eigenvalue) with the weight w = `IMPLICIT` and the step h, dimensionless
    dt : size of the step, s
    """

    starts: IntArray
    state: FloatArray
    base: FloatArray
    resolved: np.ndarray
    gain: FloatArray
    shift: FloatArray
    eigenvalues: FloatArray
    rates: FloatArray
    mobility: FloatArray
    dt: float


def phi_functions(matrix: FloatArray, count: int) -> list[FloatArray]:
    """Functions phi_0, ..., phi_count of each ``matrix`` (b, n, n), each of this shape.

    A doubling doubles the relative rounding error. A matrix is therefore halved and doubled as often as its own norm
    asks for, not as often as the largest one of the b.
    """
    norm = np.abs(matrix).sum(axis=-1).max(axis=-1, initial=0.0)
    doublings = np.ceil(np.log2(np.maximum(norm, SMALL) / SMALL)).astype(np.int64)
    part, unit = matrix / 2.0 ** doublings[:, None, None], np.broadcast_to(np.eye(matrix.shape[-1]), matrix.shape)
    found = []
    for k in range(count + 1):
        total = unit / float(factorial(k + TERMS))
        for j in range(TERMS - 1, -1, -1):
            total = part @ total + unit / float(factorial(k + j))
        found.append(total)
    for done in range(doublings.max(initial=0)):
        here = doublings > done
        half = [phi[here] for phi in found]
        for k, phi in enumerate(half):
            found[k][here] = (
                half[0] @ phi + sum((half[j] / factorial(k - j) for j in range(1, k + 1)), np.zeros(1))
            ) / 2.0**k
    return found


def propagation(eigenvalues: FloatArray, damping: Sequence[FloatArray], base: FloatArray, dt: float) -> Propagation:
    """Coefficients of steps of ``dt`` (s).

    Parameters
    ----------
    eigenvalues
        (m,) rad^2/s^2 of coordinates with unit mass.
    damping
        Viscous damping of each block of coordinates, 1/s: (m_b,), or (m_b, m_b) if it couples them; empty without.
    base
        (m,) load per unit base acceleration, with the opposite sign.
    """
    m = len(eigenvalues)
    angles = dt * np.sqrt(np.maximum(eigenvalues, 0.0))
    resolved = angles < RESOLVED
    gain, shift = _filter(angles, resolved, dt)
    alone = [np.diag(part).copy() if part.ndim == 2 else part for part in damping]
    rates = np.concatenate([*alone, np.zeros(0 if damping else m)])
    mobility = 1.0 / (1.0 + IMPLICIT * dt * rates + (IMPLICIT * dt) ** 2 * eigenvalues)
    coupled = any(part.ndim == 2 for part in damping)
    if coupled:
        starts = np.concatenate([[0], np.cumsum([len(part) for part in damping])]).astype(np.int64)
        blocks = [part if part.ndim == 2 else np.diag(part) for part in damping]
    else:
        starts, blocks = np.arange(m + 1), list(rates)
    state, answers = [], np.zeros((OUTPUTS, m, len(NODES)))
    sizes = np.diff(starts)
    if not coupled:  # all blocks have one coordinate: together
        matrices, responses = _coefficients(eigenvalues[:, None], np.array(blocks).reshape(m, 1, 1), dt)
        matrices[..., 2:] *= gain[:, None, None]
        state.append(matrices.ravel())
        answers[:] = -np.einsum("boej,b->obj", responses.reshape(m, OUTPUTS, 1, len(NODES)), base)
    else:
        for first, size, block in zip(starts[:-1], sizes, blocks, strict=True):
            here = slice(first, first + size)
            matrices, responses = _coefficients(eigenvalues[None, here], block[None], dt)
            matrices[0][:, 2 * size :] *= np.tile(gain[here], 2)
            state.append(matrices.ravel())
            by_mode = responses.reshape(OUTPUTS, size, size, len(NODES))
            answers[:, here] = -np.einsum("oicj,c->oij", by_mode, base[here])
    return Propagation(starts, np.concatenate(state), answers, resolved, gain, shift, eigenvalues, rates, mobility, dt)


def _filter(angles: FloatArray, resolved: np.ndarray, dt: float) -> tuple[FloatArray, FloatArray]:
    """Gain (m,) and shift (m,), s^2, of the forces on modes with the ``angles`` (m,) in a step of ``dt``, s.

    Without damping d = q - shift F with the force gain F, linear in time, gives Gautschi's filter: the implicit part of
    the step is (1 - sinc^2(angle / 2)) / omega^2 = dt^2 / 12 for slow modes.
    """
    cardinal = np.sinc(angles / np.pi)
    half = np.sinc(0.5 * angles / np.pi) ** 2
    gain = np.where(resolved, half / np.where(resolved, cardinal, 1.0), 0.0)
    slow = angles < 1e-2  # series, where 1 - gain cancels
    shift = np.where(slow, -1.0 / 12.0, (1.0 - gain) / np.where(slow, 1.0, angles) ** 2)
    return gain, np.where(resolved, dt**2 * shift, 0.0)


def _coefficients(eigenvalues: FloatArray, damping: FloatArray, dt: float) -> tuple[FloatArray, FloatArray]:
    """Coefficients of b blocks of n coordinates: on the state (b, OUTPUTS n, 4 n), and on forces at the nodes.

    The latter have the shape (b, OUTPUTS n, n, len(NODES)). ``eigenvalues`` is (b, n), ``damping`` (b, n, n).
    """
    b, n = eigenvalues.shape
    scale = np.maximum(dt * np.sqrt(np.abs(eigenvalues)), 1.0)  # of d, so that A has entries of the size of an angle
    matrix = np.zeros((b, 2 * n, 2 * n))
    at = np.arange(n)
    matrix[:, at, n + at] = scale
    matrix[:, n + at, at] = -(dt**2) * eigenvalues / scale
    matrix[:, n:, n:] = -dt * damping
    # d = scaled part / scale, v = scaled part / dt, and the reverse
    out = np.concatenate([1.0 / scale, np.full((b, n), 1.0 / dt)], axis=1)[:, :, None]
    into = np.concatenate([scale, np.full((b, n), dt)], axis=1)[:, None, :]
    degree = len(NODES) - 1
    powers = np.linalg.inv(np.vander(NODES, increasing=True)) * [[factorial(j)] for j in range(degree + 1)]

    def results(phi: list[FloatArray], part: float, rows: slice, shift: int) -> tuple[FloatArray, FloatArray]:
        free = (out * phi[shift] * into)[:, rows]
        forced = [part ** (j + 1) * dt**2 * (out * phi[j + 1 + shift][:, :, n:])[:, rows] for j in range(degree + 1)]
        ends = np.concatenate([forced[0] - forced[1], forced[1]], axis=2)
        return np.concatenate([free, ends], axis=2), np.einsum("jbrc,jk->brck", np.array(forced), powers)

    whole = phi_functions(matrix, degree + 2)
    parts = [results(whole, 1.0, slice(0, 2 * n), 0), results(whole, 1.0, slice(0, n), 1)]
    for node in NODES[1:-1]:
        parts.append(results(phi_functions(node * matrix, degree + 1), node, slice(n, 2 * n), 0))
    return tuple(np.concatenate(kind, axis=1) for kind in zip(*parts, strict=True))


def force_answer(steps: Propagation) -> list[FloatArray]:
    """Displacement after a step per unit force at its end, s^2, of each block (m_b, m_b): the implicit part."""
    found, at = [], 0
    answer = np.where(steps.resolved, steps.shift, (IMPLICIT * steps.dt) ** 2 * steps.mobility)
    for first, size in zip(steps.starts[:-1], np.diff(steps.starts), strict=True):
        block = steps.state[at : at + OUTPUTS * size * 4 * size].reshape(OUTPUTS * size, 4 * size)
        found.append(block[:size, 3 * size :] + np.diag(answer[first : first + size]))
        at += block.size
    return found
