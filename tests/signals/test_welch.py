r"""Averaged spectra: bias and random errors against closed forms and repetitions with known truth."""

from __future__ import annotations

import numpy as np
import pytest

import wroll_fem as wf
from wroll_fem.errors import InputError
from wroll_fem.signals.random.welch import (
    CORRELATED_LINES,
    Spectra,
    averaged_spectra,
    independent_averages,
    peak_bias,
    rms_error,
    wanted_duration,
    wanted_resolution,
)
from wroll_fem.typing import ComplexArray, FloatArray

RATE, DURATION = 1000.0, 60.0
BAND = [20.0, 300.0]


def transfer(frequency: FloatArray, f_n: float, zeta: float) -> ComplexArray:
    """Transmissibility of a mass on a spring and a dashpot."""
    r = frequency / f_n
    return (1.0 + 2j * zeta * r) / (1.0 - r**2 + 2j * zeta * r)


def steady_response(base: FloatArray, f_n: float, zeta: float) -> FloatArray:
    """Absolute acceleration of the mass under a periodic base acceleration; exact."""
    lines = np.fft.rfft(base)
    return np.fft.irfft(lines * transfer(np.fft.rfftfreq(len(base), 1.0 / RATE), f_n, zeta), len(base))


def estimated(f_n: float, zeta: float, resolution: float, seed: int, noise: float = 0.0) -> Spectra:
    base = wf.signals.random_record(BAND, 0.01, DURATION, RATE, seed)
    tip = steady_response(base, f_n, zeta)
    tip += noise * tip.std() * np.random.default_rng(seed).standard_normal(len(tip))
    return averaged_spectra(base, tip, 1.0 / RATE, resolution).within(*BAND)


@pytest.mark.parametrize(("f_n", "zeta"), [(150.0, 0.01), (93.0, 0.031)])
@pytest.mark.parametrize("share", [0.1, 0.2])
def test_the_bias_of_the_peak_is_that_of_the_hann_window(f_n: float, zeta: float, share: float) -> None:
    resolution = share * 2.0 * zeta * f_n
    peaks, corrected = [], []
    for seed in range(6):
        found = estimated(f_n, zeta, resolution, seed)
        k = int(np.argmin(np.abs(found.frequency - f_n)))
        exact = abs(transfer(found.frequency[k], f_n, zeta))
        peaks.append(abs(found.h1[k]) / exact - 1.0)
        corrected.append(abs(found.h1_corrected[k]) / exact - 1.0)
    bias = peak_bias(resolution, f_n, zeta)
    scatter = 3.0 * np.std(peaks, ddof=1) / np.sqrt(6)
    assert np.mean(peaks) == pytest.approx(-bias, abs=0.25 * bias + scatter)  # next order: about 4 share^2
    assert abs(np.mean(corrected)) < 0.3 * bias + 1.4 * scatter


def test_resolution_and_duration_meet_the_errors_that_are_asked_for() -> None:
    resolution = wanted_resolution(150.0, 0.01, bias=0.02)
    assert peak_bias(resolution, 150.0, 0.01) == pytest.approx(0.02, rel=1e-12)
    duration = wanted_duration(resolution, random_error=0.1)
    noise = np.random.default_rng(1).standard_normal(int(duration * RATE) + 1)
    found = averaged_spectra(noise, noise, 1.0 / RATE, resolution)
    assert found.psd_error == pytest.approx(0.1, rel=0.02)


def test_the_error_of_a_psd_is_the_scatter_of_white_noise() -> None:
    random = np.random.default_rng(2)
    records = random.standard_normal((40, 8000))
    found = [averaged_spectra(record, record, 1.0 / RATE, 2.0) for record in records]
    lines = np.array([one.base for one in found])[:, 2:-2]
    scatter = np.sqrt(np.mean(lines.var(axis=0, ddof=1))) / lines.mean()
    assert scatter == pytest.approx(found[0].psd_error, rel=0.03)  # 39 x 245 values, every third independent
    assert found[0].averages == independent_averages(31) < 31


def test_the_error_of_h1_and_the_coherence_are_those_of_noise_in_the_response() -> None:
    random = np.random.default_rng(3)
    base, noise = random.standard_normal((2, 60, 8000))
    found = [averaged_spectra(x, 2.0 * x + 1.5 * n, 1.0 / RATE, 2.0) for x, n in zip(base, noise, strict=True)]
    sizes = np.array([np.abs(one.h1) for one in found])[:, 2:-2]
    stated = np.sqrt(np.mean([one.h1_error[2:-2] ** 2 for one in found]))
    scatter = np.sqrt(np.mean(sizes.var(axis=0, ddof=1))) / 2.0
    assert scatter == pytest.approx(stated, rel=0.05)
    assert np.mean([one.coherence[2:-2] for one in found]) == pytest.approx(4.0 / 6.25, abs=0.02)


def test_h1_ignores_noise_in_the_response_and_hv_shares_it() -> None:
    found = estimated(150.0, 0.02, 1.0, 4, noise=0.5)
    away = np.abs(found.frequency - 150.0) > 40.0
    exact = np.abs(transfer(found.frequency, 150.0, 0.02))
    h1, hv = np.abs(found.h1)[away] / exact[away], np.abs(found.hv)[away] / exact[away]
    np.testing.assert_allclose(np.median(h1), 1.0, atol=0.1)
    assert np.median(hv) > 1.5 * np.median(h1)
    np.testing.assert_allclose(np.abs(found.hv) ** 2, np.abs(found.h1) ** 2 / found.coherence, rtol=1e-9)


def test_the_standard_error_of_zeta_covers_its_scatter() -> None:
    zetas, errors = [], []
    for seed in range(12):
        found = estimated(150.0, 0.02, 0.6, seed, noise=0.3)
        fit = wf.estimators.rational_fraction(found.frequency, found.h1_corrected)
        zetas.append(fit.zeta)
        errors.append(CORRELATED_LINES * fit.zeta_error)
    assert np.mean(zetas) == pytest.approx(0.02, rel=0.02)
    assert 0.5 < np.std(zetas, ddof=1) / np.mean(errors) < 1.5  # 12 repetitions: 20 % each side


def test_the_error_of_an_rms_is_the_scatter_of_gaussian_noise() -> None:
    random = np.random.default_rng(5)
    sizes = random.standard_normal((200, 2000)).std(axis=1)  # white up to 500 Hz, 2 s
    f = np.linspace(0.0, 500.0, 501)
    assert rms_error(f, np.ones(501), 2.0) == pytest.approx(np.std(sizes), rel=0.15)  # 200 values: 5 %


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"response": np.zeros(99)}, "shapes"),
        ({"resolution": 0.5}, "too few to average"),
        ({"dt": 0.0}, "dt = 0 is not a positive number"),
        ({"base": np.full(1000, np.nan)}, "not finite"),
    ],
)
def test_bad_input_is_named(change: dict, words: str) -> None:
    given = {"base": np.ones(1000), "response": np.ones(1000), "dt": 1e-3, "resolution": 10.0}
    with pytest.raises(InputError, match=words):
        averaged_spectra(**(given | change))
