"""Regions of a frame: labels, outlines, centroids; threshold of Otsu; light."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import ndimage
from support.target_frames import uneven_light

from wroll_fem.errors import InputError
from wroll_fem.lab.slip_images.frames.rendering import Disc, add_disc, render
from wroll_fem.lab.slip_images.regions.light import estimate_light
from wroll_fem.lab.slip_images.regions.regions import RegionFinder, Regions
from wroll_fem.lab.slip_images.regions.threshold import otsu, threshold_level


def found(image: np.ndarray, level: float = 0.5, **more: int) -> Regions:
    finder = RegionFinder(image.shape, **{"least_area": 1, "smoothing": 0, **more})
    return finder.find(image.astype(np.float32), np.full(image.shape, level, np.float32))


@pytest.mark.parametrize("seed", range(8))
def test_regions_equal_those_of_scipy_in_random_images(seed: int) -> None:
    rng = np.random.default_rng(seed)
    shape = tuple(rng.integers(5, 70, 2))
    image = ndimage.gaussian_filter(rng.normal(size=shape), rng.uniform(0.0, 2.0))
    image = (image > np.quantile(image, rng.uniform(0.4, 0.9))).astype(float)
    labels, count = ndimage.label(image, np.ones((3, 3)))
    index = np.arange(1, count + 1)
    area = ndimage.sum_labels(image, labels, index)
    centre = np.array(ndimage.center_of_mass(image, labels, index))[:, ::-1]
    filled = [ndimage.binary_fill_holes(labels == k).sum() for k in index]  # 4-connected ground, as the outline
    ours = found(image, margin=0)
    where = {tuple(np.round(c, 6)): k for k, c in enumerate(ours.centroid)}
    order = [where[tuple(np.round(c, 6))] for c in centre]
    assert len(ours) == count
    assert np.array_equal(ours.area[order], area)
    assert np.array_equal(ours.filled_area[order], filled)


def test_circularity_is_1_for_discs_and_rings_and_less_for_other_shapes() -> None:
    for radius in (5.0, 10.3, 40.7):
        for hole in (0.0, 0.6):
            image = np.zeros((100, 100), np.float32)
            add_disc(image, 50.2, 49.6, 2.0 * radius, 1.0)
            if hole:
                add_disc(image, 50.2, 49.6, 2.0 * hole * radius, -1.0)
            ring = found(image)
            assert ring.circularity[0] == pytest.approx(1.0, abs=0.06)  # outlines of whole pixels
            assert ring.diameter[0] == pytest.approx(2.0 * radius, abs=0.3)
    square, bar = np.zeros((2, 60, 60))
    square[10:41, 10:41] = 1.0
    bar[10:14, 5:55] = 1.0
    turned = ndimage.rotate(square, 45.0, order=1)
    # the length of an outline is exact on average over the directions, and 5 % small along 0 and 45 degrees
    for quadrangle in (square, turned):
        assert found(quadrangle).circularity[0] == pytest.approx(np.pi / 4.0 * 1.0548**2, rel=0.03)
    assert found(bar).circularity[0] < 0.35


def test_centroids_of_discs_are_exact_at_any_place_within_a_pixel() -> None:
    """Up to the sampling of a sharp edge by pixels, some 5e-3 px for the smallest discs."""
    rng = np.random.default_rng(3)
    for _ in range(60):
        x, y, diameter = rng.uniform(29.5, 30.5), rng.uniform(29.5, 30.5), rng.uniform(5.0, 45.0)
        image = np.zeros((60, 60), np.float32)
        add_disc(image, x, y, diameter, 1.0)
        assert found(image).centroid[0] == pytest.approx([x, y], abs=8e-3)
        blurred = ndimage.gaussian_filter(image, 0.8)
        assert found(blurred, margin=4).centroid[0] == pytest.approx([x, y], abs=8e-3)


def test_the_margin_removes_the_bias_of_thresholded_weights() -> None:
    """Without surroundings, the light beyond the threshold is missing on one side more than on the other."""
    errors = {0: [], 2: []}
    for x in np.linspace(20.0, 21.0, 11):
        image = np.zeros((41, 41), np.float32)
        add_disc(image, x, 20.3, 7.0, 1.0)
        for margin, own in errors.items():
            own.append(found(image, margin=margin).centroid[0, 0] - x)
    assert np.ptp(errors[0]) > 0.05
    assert np.ptp(errors[2]) < 0.01


def test_close_rings_do_not_share_pixels() -> None:
    image = np.zeros((120, 120), np.float32)
    for outer, x in ((14.0, 59.7), (32.0, 60.4), (50.0, 60.0)):
        add_disc(image, x, 60.2, outer, 1.0)
        if outer > 14.0:
            add_disc(image, x, 60.2, outer - 10.0, -1.0)
    three = found(image)
    order = np.argsort(three.diameter)
    assert three.centroid[order] == pytest.approx(np.array([[59.7, 60.2], [60.4, 60.2], [60.0, 60.2]]), abs=2e-3)


def test_a_pixel_as_near_to_two_regions_counts_for_neither() -> None:
    """The centroids of two blurred discs beside each other then lie mirrored, whichever is labelled first."""
    image = np.zeros((41, 61), np.float32)
    for x in (20.5, 39.5):
        add_disc(image, x, 20.0, 14.0, 1.0)
    two = found(ndimage.gaussian_filter(image, 1.2), margin=3)
    assert len(two) == 2
    assert two.centroid[:, 0].sum() == pytest.approx(60.0, abs=1e-5)  # single precision
    assert two.centroid[:, 1] == pytest.approx(20.0, abs=1e-5)


def test_otsu_maximises_the_variance_between_classes() -> None:
    rng = np.random.default_rng(5)
    for share in (0.05, 0.3, 0.6):
        values = np.concatenate([rng.normal(0, 3, 4000), rng.normal(40, 5, int(4000 * share))])
        best = max(np.unique(values)[:-1], key=lambda t: _between(values, t))
        low, high = values[values <= best].mean(), values[values > best].mean()
        assert otsu(values) == pytest.approx(0.5 * (low + high), abs=0.1)  # 512 intervals of 0.15


def _between(values: np.ndarray, t: float) -> float:
    low, high = values[values <= t], values[values > t]
    return len(low) * len(high) * (low.mean() - high.mean()) ** 2


def test_the_threshold_of_few_targets_in_noise_is_half_of_their_contrast() -> None:
    rng = np.random.default_rng(6)
    image = render((200, 200), (Disc(60.0, 70.0, 16.0),), np.zeros((1, 2)), light=30.0, ground=0.0)
    noisy = (image + rng.normal(0.0, 5.0, image.shape)).astype(np.float32)
    assert otsu(noisy) < 15.0  # splits the noise
    assert threshold_level(noisy, 5.0, "otsu")[0, 0] >= 20.0
    calm = (image + rng.normal(0.0, 1.5, image.shape)).astype(np.float32)
    assert threshold_level(calm, 1.5, "otsu")[0, 0] == pytest.approx(15.0, abs=1.5)
    assert threshold_level(calm, 1.5, 7.0)[3, 5] == 7.0


@pytest.mark.parametrize("brightness", [1.0, -0.35])
@pytest.mark.parametrize("background", ["surface", "median"])
def test_the_ground_is_found_below_bright_and_dark_targets(brightness: float, background: str) -> None:
    rng = np.random.default_rng(7)
    shape, light = (256, 256), uneven_light((256, 256))
    discs = tuple(Disc(*rng.uniform(30, 226, 2), rng.uniform(8, 30), brightness=brightness) for _ in range(12))
    image = render(shape, discs, np.zeros((12, 2)), light=light, ground=0.5)
    image = (image + rng.normal(0.0, 4.0, shape)).astype(np.float32)
    one = estimate_light(image, background=background, window=96)
    error = np.abs(one.ground - 0.5 * light)
    assert error.mean() < (0.5 if background == "surface" else 2.0)  # of 50; noise 4
    assert np.sign(one.factor.mean()) == np.sign(brightness)
    assert one.noise == pytest.approx(4.0, rel=0.15)


def test_a_lamp_that_flickers_changes_no_signal_in_the_ground() -> None:
    rng = np.random.default_rng(8)
    image = render((128, 128), (Disc(60.0, 60.0, 30.0),), np.zeros((1, 2)), light=uneven_light((128, 128)), ground=0.5)
    first = (image + rng.normal(0.0, 2.0, image.shape)).astype(np.float32)
    for divide, bound in ((False, 3.0), (True, 0.4)):  # an offset follows uneven light only on average
        light = estimate_light(first, divide=divide)
        change = light.signal((1.1 * image).astype(np.float32)) - light.signal(image)
        assert np.abs(change[:20]).max() < bound


def test_a_uniform_or_dark_frame_is_refused() -> None:
    with pytest.raises(InputError, match="uniform"):
        estimate_light(np.full((40, 40), 7.0, np.float32))
    dark = render((80, 80), (Disc(40.0, 40.0, 20.0),), np.zeros((1, 2)), ground=0.0)
    with pytest.raises(InputError, match="too dark to divide by it"):
        estimate_light(dark, divide=True)


def test_a_threshold_in_the_noise_is_refused() -> None:
    noise = np.random.default_rng(9).normal(size=(300, 300)).astype(np.float32)
    with pytest.raises(InputError, match="the threshold lies in the noise"):
        found(noise, 1.0)
