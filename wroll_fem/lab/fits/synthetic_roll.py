r"""Synthetic roll with friction: an oscillator with a Jenkins element, its backbones and its measured resonances.

A spring k_0 with dashpot holds a mass on the base; beside it a Jenkins element of stiffness k_t slides at the
displacement :math:`\gamma`. With one harmonic (amplitude a, :math:`\cos\theta = 1 - 2\gamma/a`),

.. math:: k(a) = \frac{k_t}{\pi}\Big(\theta - \tfrac12 \sin 2\theta\Big), \qquad
          h(a) = \frac{4 k_t \gamma}{\pi a} \Big(1 - \frac{\gamma}{a}\Big), \qquad a > \gamma,

and at resonance :math:`m \omega^2 = k_0 + k(a)`, :math:`m b = (2 \zeta m \omega_0 \omega + h) a` with the base
acceleration b. The element scales like a roll: its stiffness is proportional to :math:`\mu p / \gamma`.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr
import yaml

from wroll_fem.results.dataset import save_dataset
from wroll_fem.typing import FloatArray

F_0, ZETA_0, SHARE = 135.0, 0.004, 1.0e-11
"""Frequency (Hz) and damping ratio without friction; k_t / k_0 per stick stiffness, m/Pa."""

MU, SLIP = 0.25, 1.0e-6
"""Coefficient of friction and elastic slip (m) of the grid."""

PRESSURES = (2.0e4, 4.0e4, 8.0e4, 1.6e5, 3.2e5)
"""Pressures of the grid, Pa."""

TRUTH = {20.0: 1.2e4, 60.0: 4.0e4}
"""Tension (N) -> mu p of the measured roll, Pa."""

TRUE_SLIP = 1.6e-6
"""Elastic slip of the measured roll, m."""

LEVELS = (0.02, 0.05, 0.1, 0.2, 0.4, 0.8)
"""Base accelerations of the measurement, m/s^2 (0-peak)."""


def jenkins_backbone(amplitude: FloatArray, friction: float, slip: float) -> tuple[FloatArray, FloatArray]:
    """Resonance frequency (Hz) and base acceleration (m/s^2) at amplitudes (n,), m, for mu p (Pa) and gamma* (m)."""
    ratio = np.minimum(1.0, slip / amplitude)
    theta = np.arccos(1.0 - 2.0 * ratio)
    share = SHARE * friction / slip  # k_t / k_0
    stiff = share / np.pi * (theta - 0.5 * np.sin(2.0 * theta))
    loss = 4.0 * share / np.pi * ratio * (1.0 - ratio)
    omega_0 = 2.0 * np.pi * F_0
    omega = omega_0 * np.sqrt(1.0 + stiff)
    return omega / (2.0 * np.pi), (2.0 * ZETA_0 * omega_0 * omega + omega_0**2 * loss) * amplitude


def write_backbones(folder: Path) -> None:
    """Write the grid of backbones as run folders of a batch would hold it."""
    amplitude = np.geomspace(1e-8, 1e-3, 160)
    for pressure in PRESSURES:
        f, base = jenkins_backbone(amplitude, MU * pressure, SLIP)
        data = xr.Dataset(
            {
                "resonance_frequency": ("tip_amplitude", f),
                "resonant_base_acceleration": ("tip_amplitude", base),
                "pressure": ("point", np.array([pressure])),
            },
            coords={"tip_amplitude": amplitude},
        )
        case = {"contact": {"friction": {"law": "penalty_coulomb", "mu": MU, "elastic_slip": SLIP}}}
        save_dataset(data.assign_attrs(case_yaml=yaml.safe_dump(case)), folder / f"{pressure:g}" / "results.nc")


def measured_family(seed: int = 1, *, frequency: float = 0.001, level: float = 0.02) -> xr.Dataset:
    """Family of sweeps of the roll, with relative errors of frequencies and levels, as `transmissibility` writes it."""
    rng = np.random.default_rng(seed)
    rows = []
    fine = np.geomspace(1e-8, 1e-3, 4000)
    for tension, friction in TRUTH.items():
        all_base = jenkins_backbone(fine, friction, TRUE_SLIP)[1]
        for wanted in LEVELS:
            amplitude = float(np.interp(np.log(wanted), np.log(all_base), np.log(fine)))
            f, base = jenkins_backbone(np.exp(np.array([amplitude])), friction, TRUE_SLIP)
            f_n = float(f[0]) * (1.0 + frequency * rng.standard_normal())
            seen = float(base[0]) * np.exp(level * rng.standard_normal())
            tip = np.exp(amplitude + level * rng.standard_normal())
            peak = float(np.sqrt(1.0 + (tip * (2.0 * np.pi * f_n) ** 2 / seen) ** 2))
            rows.append((tension, seen, f_n, 1.96 * frequency * f_n, peak))
    tension, base, f_n, interval, peak = np.array(rows).T
    grid = np.linspace(100.0, 200.0, 401)
    r = grid / f_n[:, None]
    zeta = 0.5 / np.sqrt(peak**2 - 1.0)
    curves = (1.0 + 2j * zeta[:, None] * r) / (1.0 - r**2 + 2j * zeta[:, None] * r)
    names = [f"{t:g} N at {b:.2g} m/s²" for t, b in zip(tension, base, strict=True)]
    columns = {
        "condition_name": np.array(names), "tension": tension, "base_level": base, "condition_f_n": f_n,
        "condition_f_n_interval": interval, "condition_zeta": zeta, "condition_peak": peak,
    }  # fmt: skip
    data = {name: ("condition", values) for name, values in columns.items()}
    axes = ("condition", "frequency")
    curve_data = {"family_real": (axes, curves.real.copy()), "family_imag": (axes, curves.imag.copy())}
    return xr.Dataset(data | curve_data, coords={"frequency": grid}, attrs={"method": "sweep"})


def roll_example(folder: Path) -> list[Path]:
    """Write measured resonances of a roll with friction, and a grid of backbones; `truth.yaml` has mu p and gamma*."""
    write_backbones(folder / "backbones")
    path = save_dataset(measured_family(), folder / "measured" / "results.nc")
    settings = {"model": {"kind": "backbones", "grid": "backbones"}}
    (folder / "settings.yaml").write_text(yaml.safe_dump(settings), encoding="utf-8")
    truth = {"mu_p_pa": {f"{tension:g} N": value for tension, value in TRUTH.items()}, "elastic_slip_m": TRUE_SLIP}
    (folder / "truth.yaml").write_text(yaml.safe_dump(truth), encoding="utf-8")
    return [path.parent]
