"""Compiled: contact points follow a known motion, with the slip, opening and work of a time integration."""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from wroll_fem.contact import kernels
from wroll_fem.contact.kernels import trial_traction
from wroll_fem.dynamics.time_stepping import reduced_kernel
from wroll_fem.dynamics.time_stepping.reduced_kernel import Trial, commit_contact
from wroll_fem.dynamics.time_stepping.state import Accumulated, ContactMemory
from wroll_fem.dynamics.trigonometric import slip_path
from wroll_fem.dynamics.trigonometric.slip_path import add_work_of_path, slide_to_turning_points
from wroll_fem.numerics.numba_cache import drop_stale_cache
from wroll_fem.typing import FloatArray

drop_stale_cache(__file__, kernels.__file__, reduced_kernel.__file__, slip_path.__file__)


class Followers(NamedTuple):
    """State of n contact points that follow a motion.

    Attributes
    ----------
    contact, accumulated : their contact state, and their work, slip and opening
    moved, sliding : see `TrigonometricState`
    time_step : (1,) size of the last step, s
    """

    contact: ContactMemory
    accumulated: Accumulated
    moved: FloatArray
    sliding: FloatArray
    time_step: FloatArray


@numba.njit(cache=True)
def follow(jumps, reference, laws, dt, to_turning_points, followers, shares):
    """Let contact points follow k steps of a motion.

    Parameters
    ----------
    jumps : (k, 3 n) relative displacement at the end of each step, relative to the preload state, m
    reference, laws : `Reference`, `PointLaws`
    dt : size of the steps, s
    to_turning_points : whether points slide to their turning points within steps (trigonometric integration)
    followers : `Followers`, updated
    shares : (k, 2) output: fractions of open and of slipping points at the ends of the steps
    """
    contact, accumulated, moved = followers.contact, followers.accumulated, followers.moved
    n = laws.area.shape[0]
    trial = Trial(np.empty(3 * n), np.empty(3 * n), np.empty(2 * n), np.empty(n, np.int64), np.zeros(3 * n))
    beyond, limits, committed = np.zeros(2 * n), np.zeros(n), np.empty(3 * n)
    if followers.time_step[0] != dt:
        moved[:] = 0.0  # a turning point is found from steps of one size
        followers.time_step[0] = dt
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
        shares[number, 0] = opened / max(n, 1)
        shares[number, 1] = slipping / max(n, 1)
