"""Slip (eqs 3.2, 3.3), amplitudes by least squares, noise floor and its propagation, length of a pixel."""

from __future__ import annotations

import numpy as np
import pytest

from wroll_fem.errors import InputError
from wroll_fem.lab.slip_images.scale import EDGE, pixel_length
from wroll_fem.lab.slip_images.slip import layer_slip, mandrel_slip
from wroll_fem.lab.slip_images.spectrum import (
    band_lines,
    better_frequency,
    harmonics,
    noise_at_rest,
    noise_beside_line,
)
from wroll_fem.lab.slip_images.table import Member

RATE, FREQUENCY = 2000.0, 140.0
MEMBERS = tuple(Member(5 * (g - 1) + n, g, j) for g in (1, 2) for n, j in enumerate((0, 1, 6, 11, 16)))


def wave(amplitude: np.ndarray, frequency: float, count: int) -> np.ndarray:
    turn = np.exp(2j * np.pi * frequency / RATE * np.arange(count))
    return np.real(amplitude * turn.reshape(-1, *[1] * np.ndim(amplitude)))


def test_slip_is_mandrel_minus_layer_and_between_layers_the_difference() -> None:
    position = np.random.default_rng(1).normal(size=(20, 10, 2))
    slip = mandrel_slip(position, MEMBERS)
    assert np.array_equal(slip.group, [1, 1, 1, 1, 2, 2, 2, 2])
    assert np.array_equal(slip.layer[:, 0], [1, 6, 11, 16] * 2)
    assert np.array_equal(slip.value[:, 1], position[:, 0] - position[:, 2])  # eq. 3.2, group 1, layer 6
    assert np.array_equal(slip.value[:, 7], position[:, 5] - position[:, 9])
    between = layer_slip(slip)
    assert np.array_equal(between.layer[:3], [[6, 1], [11, 6], [16, 11]])
    assert np.allclose(between.value[:, 0], position[:, 1] - position[:, 2])  # eq. 3.3: the mandrel cancels
    fig_3_22 = layer_slip(slip, relative_to=6)
    assert np.array_equal(fig_3_22.layer, [[11, 6], [16, 6]] * 2)
    assert np.allclose(fig_3_22.value[:, 3], position[:, 7] - position[:, 9])
    with pytest.raises(InputError, match="no target on layer 5; use one of the layers 1, 6, 11, 16"):
        layer_slip(slip, relative_to=5)


def test_amplitude_and_phase_are_exact_with_drift_and_gaps() -> None:
    rng = np.random.default_rng(2)
    true = rng.normal(size=(3, 2)) + 1j * rng.normal(size=(3, 2))
    frequency, count = 137.3, 777  # no whole number of cycles
    values = wave(true, frequency, count) + 5.0 + 0.01 * np.arange(count)[:, None, None]
    values[rng.random(count) < 0.3, 1] = np.nan
    values[100:150, 2, 0] = np.nan
    assert harmonics(values, RATE, np.array([frequency]))[0] == pytest.approx(true, abs=1e-10)
    values[: count // 2 + 5, 0] = np.nan  # more than half
    assert np.isnan(harmonics(values, RATE, np.array([frequency]))[0, 0]).all()


def test_noise_of_an_amplitude_falls_with_the_square_root_of_the_frames() -> None:
    rng = np.random.default_rng(3)
    for count in (400, 1600):
        lines = band_lines(count, RATE, FREQUENCY, 100.0)
        found = np.abs(harmonics(rng.normal(0.0, 0.05, (count, 200)), RATE, lines))
        # white noise: |X|^2 has the mean 4 sigma^2/N; 200 channels and more than 20 lines give it to 3 %
        assert np.mean(found**2) == pytest.approx(4.0 * 0.05**2 / count, rel=0.06)


def test_the_noise_floor_of_a_slip_is_sqrt_2_of_a_position() -> None:
    """C56, for independent noise, and for slip between layers too: the mandrel cancels there."""
    rng = np.random.default_rng(4)
    count, channels = 500, 600
    rest = rng.normal(0.0, 0.07, (count, channels, 2))
    lines = band_lines(count, RATE, FREQUENCY, 40.0)
    noise = noise_at_rest(rest, RATE, lines, count)
    assert noise.slip_floor == np.sqrt(2.0) * noise.floor
    assert noise.floor == noise.spectrum.max()
    assert noise.deviation == pytest.approx(0.07, rel=0.15)
    rms = np.sqrt(np.mean(np.abs(harmonics(rest, RATE, lines)) ** 2))
    slip = rest[:, ::2] - rest[:, 1::2]
    between = slip[:, ::2] - (rest[:, ::4] - rest[:, 2::4])  # (r - a) - (r - b)
    for value in (slip, between):
        assert np.sqrt(np.mean(np.abs(harmonics(value, RATE, lines)) ** 2)) == pytest.approx(np.sqrt(2) * rms, rel=0.02)


def test_a_longer_recording_at_rest_is_divided_into_parts_as_long_as_the_motion() -> None:
    rng = np.random.default_rng(5)
    rest = rng.normal(0.0, 0.05, (4000, 15, 2))
    lines = band_lines(1000, RATE, FREQUENCY, 10.0)
    noise = noise_at_rest(rest, RATE, lines, 1000)
    assert noise.parts == 4
    parts = [noise_at_rest(rest[k : k + 1000], RATE, lines, 1000).floor for k in range(0, 4000, 1000)]
    assert noise.floor == max(parts)
    assert noise_at_rest(rest, RATE, lines, 4000).floor < 0.8 * noise.floor


def test_without_rest_the_noise_is_that_beside_the_excitation() -> None:
    rng = np.random.default_rng(6)
    count = 1003
    noise = rng.normal(0.0, 0.05, (count, 15, 2))
    lines = band_lines(count, RATE, FREQUENCY, 30.0)
    motion = wave(np.full((15, 2), 2.0 + 1.0j), FREQUENCY, count)
    found = noise_beside_line(noise + motion, RATE, lines, FREQUENCY)
    assert found.floor == pytest.approx(noise_at_rest(noise, RATE, lines, count).floor, rel=0.1)


def test_a_wrong_frequency_is_noticed() -> None:
    count = 2000  # lines of 1 Hz
    values = wave(np.full((4, 2), 1.0 + 0j), 140.4, count)
    best, ratio = better_frequency(values, RATE, 140.0)
    assert best == pytest.approx(140.4, abs=0.03)
    assert ratio == pytest.approx(1.0 / np.sinc(0.4), rel=0.01)  # the amplitude that a wrong frequency loses
    assert better_frequency(values, RATE, 140.4)[1] < 1.001


def test_too_few_or_too_slow_frames_are_one_line() -> None:
    assert band_lines(400, RATE, FREQUENCY, 40.0) == pytest.approx(FREQUENCY + 5.0 * np.arange(-8, 9))
    for count, rate, band, message in (
        (400, 300.0, 10.0, r"2\.14 per cycle of 140 Hz \(at least 2\.5\); record faster"),
        (30, 2000.0, 10.0, r"30 frames are 2\.1 cycles of 140 Hz .* at least 43 frames"),
        (400, 2000.0, 10.0, r"too coarse for a band of \+-10 Hz around 140 Hz; record longer or widen the band"),
    ):
        with pytest.raises(InputError, match=message):
            band_lines(count, rate, FREQUENCY, band)


def test_the_length_of_a_pixel_lies_within_its_error() -> None:
    """95 % of the repetitions within two errors: 90 to 99 of 100, as the errors of targets are random."""
    rng = np.random.default_rng(7)
    true, size = 1e-4, 5e-3
    inside = 0
    for _ in range(300):
        bias = rng.normal(0.0, EDGE)  # of the threshold, the same for all
        common = rng.normal(0.0, 5e-5)
        measured = (size + common + rng.normal(0.0, 5e-5, 15)) / true + bias
        scale = pixel_length(np.full(15, size), measured, 5e-5)
        inside += abs(scale.value - true) < 1.96 * scale.error
    assert 0.90 <= inside / 300 <= 0.99
    exact = pixel_length(np.array([2e-3, 4e-3]), np.array([20.0, 40.0]))
    assert exact.value == pytest.approx(1e-4)
    assert exact.relative == pytest.approx(EDGE / 30.0)
    with pytest.raises(InputError, match=r"contradict the images: 0\.1 to 0\.2 mm/px"):
        pixel_length(np.full(3, 2e-3), np.array([20.0, 10.0, 20.0]))
