"""Random coils whose wraps slide, by `slip_damping`: does each end with a response, how long does it take?

Usage: python benchmarks/random_coils.py [--count N] [--seed S] [--interfaces] [--shaken]

Drawn are mandrel, coil thickness, shear modulus between the wraps, tension, friction, base, tip, damping, direction and
levels, on a coarse mesh; with --interfaces also the elastic slip of the wraps, from which G and E_r follow. Each row
gives the frequency without slip, the largest damping ratio, the size of the basis, the number of amplitudes, the error,
CPU seconds, and the tip motion at three levels relative to that without slip. With --shaken each coil is also shaken at
its middle level, by `harmonic` with three harmonics; the row gives frequency and tip motion at the peak relative to
`slip_damping`, what the motion lacks in its modes, and CPU seconds.
"""

from __future__ import annotations

import argparse
import logging
import os
import time
import warnings
from pathlib import Path

os.environ["OMP_NUM_THREADS"] = "1"

import wroll_fem as wf  # isort: skip  (before numpy: it selects the kernels of OpenBLAS)
import numpy as np
import xarray as xr

from wroll_fem.errors import WrollError

CONFIGS = Path(__file__).parents[1] / "configs"
CASE, SHAKEN = CONFIGS / "slipping_coil.yaml", CONFIGS / "slipping_harmonic.yaml"
MESH = "mesh={circumferential: 8, axial: 8, grading: 20, radial: 2}"


def drawn(rng: np.random.Generator, *, interfaces: bool = False) -> list[str]:
    """Overrides of the shipped case."""
    mandrel = {
        "length": rng.uniform(0.15, 0.5), "mandrel_outer_diameter": 2.0 * rng.uniform(0.008, 0.03),
        "mandrel_thickness": rng.uniform(0.6e-3, 2.5e-3),
    }  # fmt: skip
    wraps = int(rng.integers(60, 500))
    keys = {
        "geometry": f"{{{', '.join(f'{key}: {value}' for key, value in mandrel.items())}}}",
        "coil.thickness": wraps * 5e-5, "winding.wraps": wraps,
        "winding.tension_stress": rng.uniform(5e6, 6e7), "winding.mu": rng.uniform(0.1, 0.6),
        "coil.material.G_r_theta": 10.0 ** rng.uniform(6.5, 9.2),
        "coil.base": rng.choice(["free", "clamped", "inner_edge"]), "damping_ratio": 10.0 ** rng.uniform(-3.0, -1.3),
        "mandrel.tip_mass": rng.choice([0.0, 0.1, 1.0]), "mandrel.tip": rng.choice(["rigid", "free"]),
        "excitation.amplitude_g": sorted((10.0 ** rng.uniform(-1.0, 2.0, 3)).tolist()),
        "excitation.direction": rng.choice(["x", "y"]),
    }  # fmt: skip
    if interfaces:
        keys["coil.wrap_interfaces"] = f"{{elastic_slip: {10.0 ** rng.uniform(-8.0, -5.0)}, radial_modulus: winding}}"
    return [MESH, *(f"{key}={value}" for key, value in keys.items())]


def shaken(overrides: list[str], found: xr.Dataset) -> str:
    """Cells of a row on the same coil, shaken at its middle level."""
    level = found.isel(amplitude_g=1)
    frequency, damping = float(level["frequency_at_level"]), float(level["damping_at_level"])
    if not np.isfinite(frequency):
        return "beyond the path |"
    own = ("damping_ratio=", "excitation.amplitude_g=")
    reach = max(6.0 * damping, 0.03)
    changes = [
        *(change for change in overrides if not change.startswith(own)),
        f"damping.modal={next(c for c in overrides if c.startswith(own[0])).partition('=')[2]}",
        f"excitation.amplitude_g={float(level['amplitude_g'])}", f"excitation.f_start={frequency / (1.0 + reach)}",
        f"excitation.f_end={frequency * (1.0 + reach)}", "harmonic.harmonics=3",
    ]  # fmt: skip
    started = time.process_time()
    try:
        curve = wf.run(wf.load_case(SHAKEN, changes), progress=False)
    except WrollError as error:
        return f"{type(error).__name__}: {error} |"
    tips = curve["tip_amplitude"].values
    peak = int(tips.argmax())
    return (
        f"{float(curve['frequency'][peak]) / frequency:.4f}, {tips[peak] / float(level['tip_at_level']):.4f} | "
        f"{curve.attrs['span_error_estimate']:.1e} | {time.process_time() - started:.1f} |"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--count", type=int, default=24)
    parser.add_argument("--seed", type=int, default=11)
    parser.add_argument("--interfaces", action="store_true")
    parser.add_argument("--shaken", action="store_true")
    chosen = parser.parse_args()
    logging.disable(logging.CRITICAL)
    warnings.simplefilter("ignore")
    rng, ended = np.random.default_rng(chosen.seed), 0
    more = (" f, tip over slip_damping | lacking | CPU s |", "---|---|---|") if chosen.shaken else ("", "")
    print("| coil | f, Hz | zeta, % | basis | amplitudes | error | CPU s | tip over that without slip |" + more[0])
    print("|---|---|---|---|---|---|---|---|" + more[1])
    for number in range(chosen.count):
        overrides, started = drawn(rng, interfaces=chosen.interfaces), time.process_time()
        try:
            found = wf.run(wf.load_case(CASE, overrides), progress=False)
        except WrollError as error:
            print(f"| {number} | {type(error).__name__}: {error} |", flush=True)
            continue
        ended += 1
        share = (found["tip_at_level"] / found["tip_at_level_without_slip"]).values
        print(
            f"| {number} | {found.attrs['f_stuck_hz']:.1f} | {100 * found.attrs['zeta_max']:.2f} | "
            f"{found.attrs['reduced_coordinates']} | {found.sizes['tip_amplitude']} | "
            f"{found.attrs['reduction_error_estimate']:.0e} | {time.process_time() - started:.1f} | "
            f"{', '.join(f'{value:.3f}' for value in share)} |" + (shaken(overrides, found) if chosen.shaken else ""),
            flush=True,
        )
    print(f"{ended} of {chosen.count} end with a response")


if __name__ == "__main__":
    main()
