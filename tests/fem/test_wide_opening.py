"""Periodic motions of a solid coil that opens widely or slides as a whole: shapes from a chirp in time."""

from __future__ import annotations

import numpy as np
import pytest
from support.rubbing_roll import roll

from wroll_fem.analyses import harmonic, run_analysis, summarise
from wroll_fem.case import Case
from wroll_fem.dynamics.periodic import causes
from wroll_fem.dynamics.reduction import snapshots
from wroll_fem.dynamics.reduction.snapshots import WholeSlip
from wroll_fem.dynamics.training import checked_curve, course
from wroll_fem.errors import ConvergenceError
from wroll_fem.progress import SilentProgress


@pytest.mark.filterwarnings("ignore::wroll_fem.api.CaseWarning")
def test_a_curve_of_accepted_accuracy_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    """A basis that may not grow ends the training; a chirp for shapes would start it anew, and might find nothing."""
    monkeypatch.setattr(course, "LARGEST_BASIS", 45)
    monkeypatch.setattr(harmonic, "snapshots_of_chirp", lambda *words, **options: pytest.fail("a new training"))
    coarse = {"circumferential": 8, "axial": 4, "radial": 1, "grading": 4}
    found = run_analysis(roll(harmonic={"reduction_tolerance": 1e-9}, mesh=coarse), progress=SilentProgress())
    assert 1e-9 < found.attrs["reduction_error_estimate"] < checked_curve.DOUBTFUL


@pytest.mark.filterwarnings("ignore::wroll_fem.api.CaseWarning")
@pytest.mark.slow
def test_shapes_of_a_chirp_in_time_lead_to_the_same_curve(monkeypatch: pytest.MonkeyPatch) -> None:
    """A third of the interface opens; the usual training gets through, and so does the one for wide opening."""
    coarse = {"circumferential": 8, "axial": 4, "radial": 1, "grading": 4}
    case = roll(preload={"pressure": 5e3}, excitation={"f_start": 80, "f_end": 180}, mesh=coarse)
    monkeypatch.setattr(causes, "LOST", np.inf)
    usual = run_analysis(case, progress=SilentProgress())
    seen: list[str] = []

    class Told(SilentProgress):
        def info(self, text: str) -> None:
            seen.append(text)

    monkeypatch.setattr(causes, "LOST", 0.1)
    found = run_analysis(case, progress=Told())
    assert "interfaces open widely: a chirp in time gives shapes for the basis" in seen
    assert summarise(found, case)["open_area_fraction"][0] > 0.2
    assert found.attrs["reduction_error_estimate"] < 5e-3
    for name, error in (("f_n_hz", 2e-3), ("peak_transmissibility", 0.01)):
        assert found.attrs[name] == pytest.approx(usual.attrs[name], rel=error)

    def fails(*words: object, **options: object) -> None:
        raise ConvergenceError(
            "a step does not converge", time_s=0.1, iterations=20, residual_history=(1.0,), advice="none"
        )

    monkeypatch.setattr(harmonic, "snapshots_of_chirp", fails)
    without = run_analysis(case, progress=Told())
    assert "the chirp does not converge; the basis goes without its shapes" in seen
    assert without.attrs["f_n_hz"] == usual.attrs["f_n_hz"]
    assert without.attrs["reduction_error_estimate"] < 1e-3


def sliding() -> Case:
    """Solid coil that friction does not hold."""
    coarse = {"circumferential": 8, "axial": 4, "radial": 1, "grading": 4}
    return roll(preload={"pressure": 1e4}, contact={"friction": {"mu": 0.05, "elastic_slip": 1e-6}},
                excitation={"f_start": 80, "f_end": 180, "amplitude": 20.0}, mesh=coarse)  # fmt: skip


def test_a_coil_that_slides_as_a_whole_is_told_before_its_resonance() -> None:
    """No point holds the coil, so that no basis has a periodic motion: the training fails too, but later."""
    with pytest.raises(WholeSlip, match=r"slides as a whole .* mean displacement is undetermined") as told:
        run_analysis(sliding(), progress=SilentProgress())
    stopped = float(str(told.value).split(" Hz")[0].split()[-1])
    assert 80 < stopped < 110  # the main mode with stuck interfaces has 115 Hz


@pytest.mark.slow
def test_the_training_of_a_coil_that_slides_as_a_whole_fails_too(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(snapshots, "FREE_CYCLES", 10**6)
    with pytest.raises(ConvergenceError):
        run_analysis(sliding(), progress=SilentProgress())
