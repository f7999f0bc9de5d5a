"""Forecast of slip before a run, against computed backbones and known random rolls."""

from __future__ import annotations

import numpy as np
import pytest
from support.paths import CONFIGS

from wroll_fem.analyses import run_analysis
from wroll_fem.analyses.forecasts.slip import slip_forecast, slip_warnings
from wroll_fem.case import load_case
from wroll_fem.progress import SilentProgress

BACKBONE = CONFIGS / "lab_backbone.yaml"
SWEEP = CONFIGS / "lab_sweep.yaml"
FINER = ["mesh.axial=8", "harmonic={harmonics: 3, samples: 64}"]


@pytest.mark.parametrize(
    "words",
    [
        [],
        pytest.param(["preload.pressure=2e5", "contact.friction.mu=0.5", *FINER], marks=pytest.mark.slow),
        pytest.param(["coil.layers=3", "coil.base=inner_edge"], marks=pytest.mark.slow),
    ],
)
def test_slip_starts_and_is_gross_about_where_it_is_expected(words):
    coarse = ["mesh={circumferential: 8, axial: 5, grading: 8}", "harmonic={harmonics: 1, samples: 32}"]
    case = load_case(BACKBONE, [*coarse, "backbone.tip_largest=2e-3", *words])
    forecast = slip_forecast(case)
    found = run_analysis(case, progress=SilentProgress())
    tip, share = found["tip_amplitude"].values, found["slipping_fraction"].values
    assert 1 / 3 < forecast.start / tip[int(np.argmax(share > 0.0))] < 3
    assert share[-1] > 0.5 or case.coil.base == "inner_edge"
    if share[-1] > 0.5:
        assert 1 / 3 < forecast.gross / tip[int(np.argmax(share > 0.5))] < 3


def test_forecast_follows_friction_and_pressure():
    """Start with the square root of friction and elastic slip, gross slip with friction."""
    plain = slip_forecast(load_case(SWEEP))
    rough = slip_forecast(load_case(SWEEP, ["contact.friction.mu=1.0"]))  # 4 times
    soft = slip_forecast(load_case(SWEEP, ["contact.friction.elastic_slip=4 um"]))
    assert rough.start / plain.start == pytest.approx(2.0, rel=1e-3)
    assert rough.gross / plain.gross == pytest.approx(4.0)
    assert soft.start / plain.start == pytest.approx(2.0, rel=1e-3)
    assert soft.gross == plain.gross


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ([], ""),
        (
            ["excitation.amplitude=0.01"],
            "the interfaces will hardly slip: at this excitation slip is expected to start",
        ),
        (
            ["excitation.amplitude=300"],
            "expect gross slip: friction holds the layers up to a transmissibility of about",
        ),
        (["excitation.amplitude=0.5"], ""),
        (  # the peak of the damping lies below the start of slip
            ["excitation.amplitude=0.5", "damping.modal=0.05"],
            "the interfaces will hardly slip: at this excitation slip is expected to start",
        ),
        (["coil.base=clamped"], "the layers are clamped at the base"),
        (["coil.base=inner_edge"], "the layers are clamped at the base"),
        (["coil.base=guided", "coil.base_stiffness=1e8", "excitation.amplitude=300"], ""),
        (["coil.model=bonded"], ""),
        (["preload.pressure=0"], ""),
    ],
)
def test_what_is_told_before_a_sweep(words, told):
    texts = slip_warnings(load_case(SWEEP, words))
    assert len(texts) == bool(told)
    assert "".join(texts).startswith(told)


def test_a_backbone_below_the_start_of_slip_is_told():
    [text] = slip_warnings(load_case(BACKBONE, ["backbone.tip_largest=1.2e-5"]))
    assert "slip is expected to start at a tip displacement of about 3.4e-05 m, above backbone.tip_largest" in text
    assert slip_warnings(load_case(BACKBONE)) == []
    loud = load_case(SWEEP, ["excitation.amplitude=300", "backbone={tip_smallest: 1 um, tip_largest: 1 mm}"])
    assert "expect gross slip" in slip_warnings(loud)[0]  # a section that the analysis does not use
