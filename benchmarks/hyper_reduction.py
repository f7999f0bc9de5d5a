"""Errors and CPU time of the lab roll's response curve on weighted subsets of its contact points.

Usage: python benchmarks/hyper_reduction.py [--training] [KEY=VALUE ...]; the overrides change the case, for example
mesh.circumferential=60 mesh.axial=30.

The basis and the motions for which the subsets are chosen are those of the finished curve (twelve of its points). The
curve is then followed on each subset alone, without the other points, and compared with the curve on all points in the
same basis. With `--training` the whole computation after set-up (basis, curve, checks) is timed too, with and without
subsets.
"""

from __future__ import annotations

import argparse
import os
import time
from pathlib import Path

os.environ["OMP_NUM_THREADS"] = "1"

import wroll_fem  # noqa: F401  isort: skip  (before numpy: it selects the kernels of OpenBLAS)
import numpy as np

from wroll_fem import load_case
from wroll_fem.analyses.harmonic import condensed_structure
from wroll_fem.analyses.shared.preparation import prepare
from wroll_fem.blas import one_thread
from wroll_fem.dynamics.aft.harmonic_contact import HarmonicContact
from wroll_fem.dynamics.aft.sampling import Sampling
from wroll_fem.dynamics.periodic.point_sample import Motions, sampled
from wroll_fem.dynamics.periodic.reading_points import with_reading_points
from wroll_fem.dynamics.periodic.response import HarmonicCurve, response_curve
from wroll_fem.dynamics.training.enrichment import trained_response
from wroll_fem.dynamics.training.structure import Structure
from wroll_fem.numerics.continuation import StepControl
from wroll_fem.progress import SilentProgress

CASE = Path(__file__).parents[1] / "configs" / "lab_harmonic.yaml"
TOLERANCES = ((2e-2, np.inf), (1e-2, np.inf), (5e-3, np.inf), (2e-3, np.inf), (5e-3, 2e-3), (5e-3, 1e-3), (5e-3, 5e-4))
"""Tolerance of the fit, and of the work of each motion."""


def readings(curve: HarmonicCurve) -> tuple[float, float]:
    """Peak transmissibility and friction work per cycle there, J."""
    top = int(np.argmax(np.abs(curve.transmissibility)))
    work = curve.balance.cycle_work(curve.coefficients[top], curve.frequencies[top])
    return float(np.abs(curve.transmissibility[top])), work.friction


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("overrides", nargs="*", metavar="KEY=VALUE", help="changes of the case")
    parser.add_argument("--training", action="store_true", help="time the whole computation with and without subsets")
    chosen = parser.parse_args()
    case, silent = load_case(CASE, chosen.overrides), SilentProgress()
    system, state = prepare(case, silent)
    condensation, settings = condensed_structure(case, system, state, silent), case.harmonic
    shaken = {"amplitude": case.excitation.amplitude, "frequencies": (case.excitation.f_start, case.excitation.f_end)}
    sampling = Sampling(settings.harmonics, settings.samples)
    structure = Structure.of(condensation, state, system.laws, sampling, settings.max_periods)

    def trained(*, subsets: bool) -> HarmonicCurve:
        started = time.process_time()
        found = trained_response(
            condensation, state, system.laws, **shaken, harmonics=settings.harmonics, samples=settings.samples,
            max_periods=settings.max_periods, tolerance=settings.reduction_tolerance, hyper_reduction=subsets,
        )  # fmt: skip
        peak, work = readings(found.curve)
        print(
            f"subsets {subsets}: {time.process_time() - started:.1f} CPU s, {found.rounds} curves, peak {peak:.4f}, "
            f"friction work {work:.5e} J, {found.sample}",
            flush=True,
        )
        return found.curve

    def followed(contact: HarmonicContact) -> tuple[float, float, float]:
        started = time.process_time()
        curve = response_curve(contact, **shaken)
        seconds = time.process_time() - started
        return seconds, *readings(with_reading_points(curve, StepControl()))

    with one_thread():
        curve = trained(subsets=True)
        if chosen.training:
            for wanted in (False, True):
                trained(subsets=wanted)
        model = curve.balance.model
        whole = structure.contact(model)
        picked = np.linspace(0, len(curve.frequencies) - 1, 12).astype(int)
        motions = Motions(curve.coefficients[picked], curve.frequencies[picked], model.vectors)
        seconds, peak, work = followed(whole)
        print(f"all points: {system.laws.n}, evaluated {whole.n}, curve {seconds:.2f} CPU s")
        print("| fit | works | points | share of all | peak | friction work | curve, CPU s |\n" + 7 * "|---" + "|")
        for tolerance, of_work in TOLERANCES:
            sample = sampled(whole, motions, tolerance, of_work)
            assert sample is not None
            took, high, lost = followed(structure.contact(model, sample=sample))
            count = len(sample.points)
            print(
                f"| {tolerance:g} | {of_work:g} | {count} | 1/{system.laws.n / count:.1f} "
                f"| {100 * (high / peak - 1):+.2f} % | {100 * (lost / work - 1):+.2f} % | {took:.2f} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
