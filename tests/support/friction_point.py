"""One interface point under a friction law, moved by hand."""

import numpy as np

from wroll_fem.contact import kernels
from wroll_fem.contact.laws import stack_laws

MU, GAMMA, KN, PRESSURE, AREA, V0 = 0.25, 2.0e-6, 1.0e12, 1.0e5, 2.0e-4, 2.0e-3
CLOSED = -PRESSURE / KN


class Point:
    """One interface point with its committed state: hoop, axial and normal displacement, m."""

    def __init__(self, law, start=(0.0, 0.0, CLOSED)):
        self.law = stack_laws([np.array([AREA])], [law], [KN], [True])
        self.g, self.e, self.work = np.array(start, float), np.zeros(2), np.zeros(5)
        self.path, self.peak, self.vector, self.start = np.zeros(1), np.zeros(1), np.zeros(2), self.g.copy()
        self.t = self.trial(self.g, np.inf)[0]

    def trial(self, g, dt):
        t, e, status = np.zeros(3), np.zeros(2), np.zeros(1, np.int64)
        kernels.trial_traction(np.asarray(g, float), self.g, self.e, self.law, dt, t, e, status)
        return t, e, status

    def tangent(self, g, dt):
        d = np.full((1, 3, 3), np.nan)
        kernels.consistent_tangent(np.asarray(g, float), self.g, self.e, self.law, dt, d)
        return d[0]

    def move(self, g, dt):
        g = np.asarray(g, float)
        t, e, status = self.trial(g, dt)
        kernels.interface_work(self.g, self.e, self.t, g, e, t, self.law, self.work)
        kernels.record_slip(self.g, self.e, g, e, self.start, status, self.path, self.peak, self.vector)
        self.g, self.e, self.t = g, e, t
        return t, status[0]
