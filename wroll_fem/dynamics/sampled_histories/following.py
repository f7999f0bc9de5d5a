"""Compiled: contact points follow a known motion, with the slip, opening and friction work of a time integration.

Most points stick through many steps. They follow in one pass (`_follow_sticking`); the steps of the others are
computed one by one.
"""

from __future__ import annotations

import math
from typing import NamedTuple, Self

import numba
import numpy as np

from wroll_fem.contact import kernels, point
from wroll_fem.contact.kernels import trial_traction
from wroll_fem.contact.laws import slip_update
from wroll_fem.contact.point import axial, dofs_of, hoop, is_closed, normal, penalty_traction, pressure, stick_stiffness
from wroll_fem.dynamics.reduction.evaluated_points import EvaluatedPoints
from wroll_fem.dynamics.statics.contact_state import ContactState
from wroll_fem.dynamics.time_stepping import reduced_kernel
from wroll_fem.dynamics.time_stepping.reduced_kernel import Trial, commit_contact
from wroll_fem.dynamics.time_stepping.state import Accumulated, ContactMemory, OpeningRecord, SlipRecord
from wroll_fem.dynamics.trigonometric import slip_path
from wroll_fem.dynamics.trigonometric.slip_path import NEAR, add_work_of_path, slide_to_turning_points
from wroll_fem.numerics.numba_cache import drop_stale_cache
from wroll_fem.typing import FloatArray, IntArray

drop_stale_cache(__file__, kernels.__file__, point.__file__, reduced_kernel.__file__, slip_path.__file__)


class Followers(NamedTuple):
    """State of n contact points that follow a motion.

    Attributes
    ----------
    contact, accumulated : their contact state, and their slip, opening and friction work (the other entries of
        ``work`` leave out points that stick)
    moved, sliding : see `TrigonometricState`
    time_step : (1,) size of the last step, s
    """

    contact: ContactMemory
    accumulated: Accumulated
    moved: FloatArray
    sliding: FloatArray
    time_step: FloatArray

    @classmethod
    def of(cls, preload: ContactState) -> Self:
        """Points at rest in the ``preload`` state."""
        memory = ContactMemory.of(preload)
        n = len(memory.traction) // 3
        return cls(memory, Accumulated.zeros(n), np.zeros(2 * n), np.zeros(n), np.zeros(1))


def follow(
    jumps: FloatArray, points: EvaluatedPoints, dt: float, followers: Followers, *, to_turning_points: bool
) -> FloatArray:
    """Let contact points follow k steps of a motion; returns the shares (k, 2) that are open, and that slip.

    Parameters
    ----------
    jumps
        (3 n, k) relative displacement at the end of each step, relative to the preload state, m.
    points
        Their laws and preload state.
    dt
        Size of the steps, s.
    followers
        Their state, updated.
    to_turning_points
        Whether points slide to their turning points within steps (trigonometric integration).
    """
    n, steps = points.n, jumps.shape[1]
    if followers.time_step[0] != dt:
        followers.moved[:] = 0.0  # a turning point is found from steps of one size
        followers.time_step[0] = dt
    sticking, shares = np.zeros(n, bool), np.zeros((steps, 2))
    if steps == 0:
        return shares
    _follow_sticking(jumps, points.reference, points.laws, dt, followers, sticking)
    moving = np.flatnonzero(~sticking)
    if len(moving):
        some, dofs = points.take(moving), dofs_of(moving, n)
        part = _taken(followers, moving, dofs)
        moves = np.ascontiguousarray(jumps[dofs].T)
        _follow_stepwise(moves, some.reference, some.laws, dt, to_turning_points, part, shares)
        _put(part, followers, moving, dofs)
        shares /= n
    return shares


def _taken(followers: Followers, points: IntArray, dofs: IntArray) -> Followers:
    """State of some of the ``points`` with the contact degrees of freedom ``dofs``; the work is shared."""
    contact, (work, flows, slip, opening), moved, sliding, time_step = followers
    tangential = dofs[: 2 * len(points)]
    memory = ContactMemory(contact.jump[dofs], contact.elastic_slip[tangential], contact.traction[dofs])
    record = SlipRecord(slip.path[points], slip.peak[points], slip.peak_vector[tangential])
    accumulated = Accumulated(work, flows, record, OpeningRecord(*(array[points] for array in opening)))
    return Followers(memory, accumulated, moved[tangential], sliding[points], time_step)


def _put(part: Followers, followers: Followers, points: IntArray, dofs: IntArray) -> None:
    """Write the state of some of the ``points`` (`_taken`) back."""
    contact, accumulated = followers.contact, followers.accumulated
    tangential = dofs[: 2 * len(points)]
    contact.jump[dofs], contact.traction[dofs] = part.contact.jump, part.contact.traction
    contact.elastic_slip[tangential] = part.contact.elastic_slip
    slip, taken = accumulated.slip, part.accumulated.slip
    slip.path[points], slip.peak[points], slip.peak_vector[tangential] = taken
    accumulated.opening.gap[points], accumulated.opening.open_time[points] = part.accumulated.opening
    followers.moved[tangential], followers.sliding[points] = part.moved, part.sliding


@numba.njit(cache=True)
def _record_peak(hoops, axials, k, slip):
    """Update the largest tangential displacement of the point ``k`` with those of its steps, (k,) each."""
    # a function of its own: in a loop with an inlined law numba has lost the maximum
    squares = hoops * hoops + axials * axials
    at = np.argmax(squares)
    if math.sqrt(squares[at]) > slip.peak[k]:
        slip.peak[k] = math.sqrt(squares[at])
        slip.peak_vector[hoop(k)], slip.peak_vector[axial(k)] = hoops[at], axials[at]


@numba.njit(cache=True)
def _follow_sticking(jumps, reference, laws, dt, followers, sticking):
    """Let the points that stick in all steps, below `NEAR` of their limit, follow a motion.

    Parameters
    ----------
    jumps : (3 n, k) see `follow`
    reference, laws, dt : `Reference`, `PointLaws`, size of the steps (s)
    followers : `Followers`, updated at these points
    sticking : (n,) bool, output: whether this is such a point
    """
    contact, moved, sliding, slip = followers.contact, followers.moved, followers.sliding, followers.accumulated.slip
    gap = followers.accumulated.opening.gap
    jump, elastic_slip, traction, g_0 = contact.jump, contact.elastic_slip, contact.traction, reference.jump
    kn, separation, mu, stores, elastic = laws.kn, laws.separation, laws.mu, laws.stores_slip, laws.elastic
    n, last = sticking.shape[0], jumps.shape[1] - 1
    for k in range(n):
        h, z, r = hoop(k), axial(k), normal(k, n)
        sticks = stores[k] and not elastic[k] and jump[r] <= 0.0
        sticks = sticks and moved[h] == 0.0 and moved[z] == 0.0 and sliding[k] == 0.0
        e_h, e_z, g_h, g_z = elastic_slip[h], elastic_slip[z], jump[h], jump[z]
        stiffness, tn, step = 0.0, 0.0, 0
        while sticks and step <= last:
            gn = jumps[r, step] + g_0[r]
            dg_h, dg_z = jumps[h, step] + g_0[h] - g_h, jumps[z, step] + g_0[z] - g_z
            tn = penalty_traction(gn, kn[k], separation[k])
            p = pressure(tn)
            e_h, e_z, slides = slip_update(k, e_h + dg_h, e_z + dg_z, dg_h, dg_z, p, laws, dt)
            stiffness = stick_stiffness(k, p, laws)
            near, tangential = NEAR * mu[k] * p, stiffness * stiffness * (e_h * e_h + e_z * e_z)
            sticks = is_closed(gn, separation[k]) and not slides and tangential <= near * near
            g_h, g_z = jumps[h, step] + g_0[h], jumps[z, step] + g_0[z]
            step += 1
        sticking[k] = sticks
        if not sticks:
            continue
        jump[h], jump[z], jump[r] = g_h, g_z, jumps[r, last] + g_0[r]
        elastic_slip[h], elastic_slip[z] = e_h, e_z
        traction[h], traction[z], traction[r] = stiffness * e_h, stiffness * e_z, tn
        gap[k] = max(gap[k], jumps[r].max() + g_0[r])
        _record_peak(jumps[h], jumps[z], k, slip)


@numba.njit(cache=True)
def _follow_stepwise(jumps, reference, laws, dt, to_turning_points, followers, counts):
    """Let contact points follow a motion step by step.

    Parameters
    ----------
    jumps : (k, 3 n) relative displacement at the end of each step, relative to the preload state, m
    reference, laws : `Reference`, `PointLaws`
    dt, to_turning_points : see `follow`
    followers : `Followers`, updated
    counts : (k, 2) output: numbers of open and of slipping points at the ends of the steps
    """
    contact, accumulated, moved = followers.contact, followers.accumulated, followers.moved
    n = laws.area.shape[0]
    trial = Trial(np.empty(3 * n), np.empty(3 * n), np.empty(2 * n), np.empty(n, np.int64), np.zeros(3 * n))
    beyond, limits, committed = np.zeros(2 * n), np.zeros(n), np.empty(3 * n)
    for number in range(jumps.shape[0]):
        trial.g[:] = jumps[number] + reference.jump
        committed[:] = contact.jump
        if to_turning_points:
            slide_to_turning_points(trial.g, contact, moved, laws, dt, beyond, limits)
        trial_traction(trial.g, contact.jump, contact.elastic_slip, laws, dt, trial.t, trial.e, trial.status)
        contact.jump[:] = committed
        if to_turning_points:
            add_work_of_path(
                contact, trial, beyond, limits, moved, followers.sliding, laws, accumulated.work, accumulated.slip.path
            )
        commit_contact(trial, contact, reference, laws, dt, accumulated)
        opened, slipping = 0, 0
        for k in range(n):
            opened += trial.status[k] == kernels.OPEN
            slipping += trial.status[k] == kernels.SLIP
        counts[number, 0] = opened
        counts[number, 1] = slipping
