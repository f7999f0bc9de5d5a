"""Spectra of a nonlinear mode: exact for linear modes; against time integration of a Jenkins oscillator."""

import numpy as np
import pytest
from scipy.signal import csd, welch
from support.jenkins import backbone, integrate, random_records

from wroll_fem.signals.averaging.amplitude_process import NonlinearMode, amplitude_density
from wroll_fem.signals.averaging.averaged_spectrum import LinearModes, frequency_axis, response_spectra
from wroll_fem.signals.averaging.averaging_limits import averaging_doubts, drift, quality, variation
from wroll_fem.signals.damping import half_power

W0 = 2.0 * np.pi
DT, STEPS, SKIP = 1.0 / 64.0, 2**16, 8000
"""64 steps per cycle: the period error of central differences is 4e-4."""


def table(band, power=0.0, level=1.0):
    """PSD level f^power inside a band, zero outside."""
    return lambda f: np.where((f >= band[0]) & (f <= band[1]), level * np.maximum(f, 1e-9) ** power, 0.0)


def jenkins_mode(share, zeta, largest=5e3):
    """Backbone of the oscillator of `support.jenkins` with slip at 1 m."""
    a = np.geomspace(0.05, largest, 400)
    return NonlinearMode.of_oscillator(a, *backbone(a, W0, share, 1.0, zeta))


def respond(mode, psd, band, others=None):
    """Density and spectra."""
    law = amplitude_density(mode, psd)
    axis = frequency_axis(law, band, np.array(band), others)
    return law, response_spectra(law, psd, axis, others)


def test_spectra_of_linear_modes_are_exact():
    """Displacement, absolute acceleration and H1 of three modes against their closed form, also far off resonance."""
    rng = np.random.default_rng(155)
    for _ in range(4):
        w, zeta = 2.0 * np.pi * rng.uniform(20.0, 200.0), 10.0 ** rng.uniform(-3, -1)
        mass, gamma = rng.uniform(0.1, 3.0), rng.uniform(0.5, 1.6)
        others = LinearModes(w * rng.uniform(2.0, 8.0, 2), rng.uniform(0.005, 0.05, 2), rng.uniform(-0.5, 0.5, 2))
        mode = NonlinearMode.of_oscillator([1e-6, 1e-4], [w, w], [zeta, zeta], mass=mass, participation=gamma)
        band = (5.0, 3000.0)
        psd = table(band, rng.uniform(-1.0, 1.0), 0.3)
        _, found = respond(mode, psd, band, others)
        omega = 2.0 * np.pi * found.frequency
        main = -gamma / (w**2 - omega**2 + 2j * zeta * w * omega)
        whole = main - sum(
            c / (v**2 - omega**2 + 2j * z * v * omega)
            for v, z, c in zip(others.frequency, others.damping, others.participation, strict=True)
        )
        T = 1.0 - omega**2 * whole
        np.testing.assert_allclose(found.transmissibility, T, rtol=1e-8, atol=1e-8 * np.abs(T).max())
        scale = found.acceleration.max()
        np.testing.assert_allclose(found.acceleration, found.base * np.abs(T) ** 2, rtol=1e-6, atol=1e-9 * scale)
        np.testing.assert_allclose(found.displacement, found.base * np.abs(whole) ** 2, rtol=1e-6)


def test_the_rms_of_a_linear_mode_in_white_noise_is_that_of_its_density():
    """Integral of the spectrum against sigma^2 = W / (8 zeta w^3): 1e-3, the band to 20 times the frequency."""
    for zeta in (0.001, 0.01, 0.1):
        band = (1.0, 3000.0)
        law, found = respond(NonlinearMode.of_oscillator([1e-3], [2 * np.pi * 150], [zeta]), table(band), band)
        assert found.rms("mode_displacement") == pytest.approx(law.tip_rms, rel=1e-3)


@pytest.mark.parametrize("share", [0.1, 0.3, 0.5])
def test_jenkins_oscillator_is_linear_far_below_and_far_above_slip(share):
    """Both limits in closed form: stuck, and sliding with the spring alone, in which friction loses its part."""
    zeta = 0.005
    for level, w, tolerance in ((1e-6, W0, 1e-4), (1e14, W0 * np.sqrt(1.0 - share), 1e-3)):
        law = amplitude_density(jenkins_mode(share, zeta, 1e9), table((0.01, 100.0), level=level))
        ratio = zeta * W0 / w  # of the same dashpot
        assert law.tip_rms == pytest.approx(np.sqrt(level / (8.0 * ratio * w**3)), rel=tolerance)


def compare(share, zeta, psd, band, records, seed):
    """Averaged and integrated response, and the standard error of the latter."""
    law, spectra = respond(jenkins_mode(share, zeta), psd, band)
    base = random_records(psd, DT, STEPS, records, np.random.default_rng(seed))
    return law, spectra, integrate(base, DT, W0, share, 1.0, zeta, SKIP), base


LEVELS = 0.06 * 10.0 ** np.linspace(0.0, 2.0, 3)


@pytest.mark.parametrize("power", [0.0, 2.0], ids=["broadband", "rising"])
def test_jenkins_oscillator_agrees_with_time_integration_over_two_decades(power):
    """Rms 5 %, input power of white noise, crossings; statistical error below 1.5 %."""
    share, zeta = 0.3, 0.01
    band = (0.02, 6.0) if power == 0.0 else (0.3, 3.0)
    for k, level in enumerate(LEVELS):
        psd = table(band, power, level**2 * 0.16 * W0**3)
        law, spectra, found, _ = compare(share, zeta, psd, band, 40, 156 + k)
        assert found.error < 0.015
        assert law.tip_rms == pytest.approx(found.displacement, rel=0.05)
        assert spectra.rms("displacement") == pytest.approx(found.displacement, rel=0.05)
        assert spectra.rms("acceleration") == pytest.approx(found.acceleration, rel=0.05 if power == 0.0 else 0.08)
        assert found.dissipated_power == pytest.approx(found.input_power, rel=0.02)
        if power == 0.0:
            assert float(law.mean(law.power)) == pytest.approx(found.input_power, rel=0.05)
            assert law.mean_frequency == pytest.approx(found.crossings, rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.1, 0.3, 0.5])
def test_jenkins_oscillator_agrees_at_eleven_levels(share):
    """Rms 5 % at every level over two decades of level, from sticking to gross slip."""
    for k, level in enumerate(0.06 * 10.0 ** np.linspace(0.0, 2.3, 11)):
        psd = table((0.02, 6.0), 0.0, level**2 * 0.16 * W0**3)
        law, _, found, _ = compare(share, 0.005, psd, (0.02, 6.0), 120, 200 + k)
        assert found.error < 0.015
        assert law.tip_rms == pytest.approx(found.displacement, rel=0.05)


def test_h1_of_the_averaged_process_is_that_of_long_records():
    """Frequency 0.5 %, peak 6 % and damping ratio 12 % by half power, against Welch's H1 at 10 to 20 lines a width."""
    band, lines = (0.02, 6.0), 2**13
    for level, seed in ((1.08, 161), (2.3, 162)):
        psd = table(band, 0.0, level**2 * 0.16 * W0**3)
        _, spectra, found, base = compare(0.3, 0.01, psd, band, 60, seed)
        f, cross = csd(base[:, SKIP:], found.motion[:, SKIP:], 1.0 / DT, nperseg=lines)
        _, given = welch(base[:, SKIP:], 1.0 / DT, nperseg=lines)
        T = np.abs(1.0 - (2.0 * np.pi * f) ** 2 * cross.mean(axis=0) / given.mean(axis=0))
        inside = (f > 0.3) & (f < 2.0)
        measured = half_power(f[inside], T[inside])
        near = (spectra.frequency > 0.3) & (spectra.frequency < 2.0)
        predicted = half_power(spectra.frequency[near], np.abs(spectra.transmissibility)[near])
        assert predicted.f_n == pytest.approx(measured.f_n, rel=5e-3)
        assert predicted.zeta == pytest.approx(measured.zeta, rel=0.12)
        assert np.abs(spectra.transmissibility).max() == pytest.approx(T[inside].max(), rel=0.06)
        # the PSD itself, outside the narrow peak where Welch averages
        _, square = welch(found.motion[:, SKIP:], 1.0 / DT, nperseg=2048)
        coarse = np.fft.rfftfreq(2048, DT)
        for low, high in ((0.4, 0.7), (0.7, 0.9), (0.9, 1.1), (1.1, 1.5)):
            part = (coarse >= low) & (coarse < high)
            grid = np.linspace(coarse[part][0], coarse[part][-1], 400)
            model = np.interp(grid, spectra.frequency, spectra.displacement).mean()
            assert model == pytest.approx(square.mean(axis=0)[part].mean(), rel=0.15)


def doubts_of(mode, psd, band, others=None):
    """Texts and quality of the doubts."""
    law, spectra = respond(mode, psd, band, others)
    found = averaging_doubts(law, psd, band, spectra, others or LinearModes.none())
    return quality(found), "; ".join(doubt.text for doubt in found)


def test_a_response_within_the_limits_has_no_doubt():
    """A Jenkins oscillator with a third of its stiffness in the element, at all levels."""
    for level in LEVELS:
        found = doubts_of(jenkins_mode(0.3, 0.01), table((0.02, 6.0), 0.0, level**2 * 0.16 * W0**3), (0.02, 6.0))
        assert found == ("ok", "")


def test_slow_drift_is_told_where_the_rms_is_wrong():
    """Seven tenths of the stiffness in the element: the rms is too low by more than 5 %, and the doubt says so."""
    band = (0.02, 6.0)
    psd = table(band, 0.0, 1.08**2 * 0.16 * W0**3)
    law, _, found, _ = compare(0.7, 0.005, psd, band, 30, 163)
    lost = 1.0 - law.tip_rms / found.displacement
    assert 0.05 < lost < 0.09
    assert 0.5 * lost < 2.0 * drift(law, psd, band) < 3.0 * lost
    grade, text = doubts_of(jenkins_mode(0.7, 0.005), psd, band)
    assert grade == "doubtful"
    assert "drift" in text
    # a base without slow components does not move the element's centre
    assert drift(law, table((0.6, 6.0)), (0.6, 6.0)) == 0.0


def test_every_limit_is_told():
    """Broad damping, end and start of the backbone, steep PSD, other modes, resonance outside the band."""
    w, band = 2.0 * np.pi * 100.0, (20.0, 300.0)
    a = np.geomspace(1e-6, 1e-4, 30)
    linear = lambda zeta: NonlinearMode.of_oscillator(a, np.full(30, w), np.full(30, zeta))  # noqa: E731
    small = table(band, 0.0, 1e-4)
    assert doubts_of(linear(0.02), small, band) == ("ok", "")
    grade, text = doubts_of(linear(0.12), small, band)
    assert grade == "doubtful"
    assert "effective damping ratio is 0.12" in text
    assert doubts_of(linear(0.2), small, band)[0] == "invalid"
    grade, text = doubts_of(linear(0.02), table(band, 0.0, 1.0), band)
    assert grade == "invalid"
    assert "beyond the end of the backbone" in text
    rising = NonlinearMode.of_oscillator(a, np.full(30, w), 0.02 * (a / a[0]) ** 0.5)
    grade, text = doubts_of(rising, table(band, 0.0, 1e-6), band)
    assert grade == "doubtful"
    assert "below the start of the backbone" in text
    notched = lambda f: small(f) * np.where(np.abs(f - 100.0) < 1.0, 0.05, 1.0)  # noqa: E731
    grade, text = doubts_of(linear(0.02), notched, band)
    assert "not white there" in text
    assert variation(amplitude_density(linear(0.02), small), small) < 0.05
    second = LinearModes(np.array([1.7 * w]), np.array([0.01]), np.array([0.5]))
    grade, text = doubts_of(linear(0.02), small, band, second)
    assert grade == "doubtful"
    assert "modes beside the main one" in text
    loose = LinearModes(np.array([1.7 * w]), np.array([0.0]), np.array([0.5]))
    grade, text = doubts_of(linear(0.02), small, band, loose)
    assert grade == "invalid"
    assert "no material damping" in text
    _, spectra = respond(linear(0.02), small, band, loose)
    assert np.isfinite(spectra.acceleration).all()  # left out, also at its own frequency
    falling = NonlinearMode.of_oscillator(a, w * np.geomspace(1.0, 0.3, 30), np.full(30, 0.02))
    grade, text = doubts_of(falling, table((80.0, 300.0), 0.0, 1e-1), (80.0, 300.0))
    assert "outside the band of the PSD" in text
