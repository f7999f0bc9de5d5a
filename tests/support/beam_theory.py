"""Closed forms of a Timoshenko cantilever with the cross-section of a thin tube."""

import numpy as np
import scipy.linalg as la
import scipy.optimize


def timoshenko(section, radius):
    """EI, kappa G A, rho A, rho I of a thin ring (Cowper 1966, doi:10.1115/1.3625046: shear factor)."""
    area = 2 * np.pi * radius * section.thickness
    inertia = np.pi * radius * section.thickness * (radius**2 + section.thickness**2 / 4)
    kappa = 2 * (1 + section.nu) / (4 + 3 * section.nu)
    G = section.E / (2 * (1 + section.nu))
    return section.E * inertia, kappa * G * area, section.rho * area, section.rho * inertia


def beam_tip_deflection(section, radius, length):
    EI, GA, _, _ = timoshenko(section, radius)
    return length**3 / (3 * EI) + length / GA


def beam_frequency(section, radius, length, tip_mass, tension=0.0):
    """First frequency, Hz, of a clamped Timoshenko beam with a tip mass, by its transfer matrix.

    The tension, N, pulls the tip along the undeformed axis: the transverse force is V = Q + tension w'.
    """
    EI, GA, rho_A, rho_I = timoshenko(section, radius)

    def determinant(frequency):
        w2 = (2 * np.pi * frequency) ** 2  # state [w, psi, M, V]: w' = psi + Q/GA, psi' = M/EI, M' = -Q - w2 rho_I psi
        slope = np.array([0, GA, 0, 1]) / (GA + tension)
        shear = np.array([0, 0, 0, 1]) - tension * slope
        A = np.array([slope, [0, 0, 1 / EI, 0], [0, -w2 * rho_I, 0, 0] - shear, [-w2 * rho_A, 0, 0, 0]])
        T = la.expm(A * length)
        end = np.array([[0, 0, 1, 0], [-w2 * tip_mass, 0, 0, 1]])  # M = 0, V = w2 m w
        return np.linalg.det((end @ T)[:, 2:])

    bending = 3 * EI / length**3 + 1.2 * tension / length
    bernoulli = np.sqrt(bending / (tip_mass + 0.2427 * rho_A * length)) / (2 * np.pi)
    return scipy.optimize.brentq(determinant, 0.5 * bernoulli, 1.1 * bernoulli)
