"""Sharpness that noise does not raise, and noise that sharpness does not raise."""

import numpy as np
import pytest

from benchmarks.acceptance.photoreal_sharpness import SHADE, measure

WINDOW = (120, 160, 3)


def noisy(image: np.ndarray, sigma: float, seed: int) -> np.ndarray:
    return image + np.random.default_rng(seed).normal(0.0, sigma, image.shape)


@pytest.fixture
def stripes() -> np.ndarray:
    columns = 30.0 + 10.0 * np.sin(np.arange(WINDOW[1]) * 2.0 * np.pi / 8.0)
    return np.broadcast_to(columns[None, :, None], WINDOW)


@pytest.mark.parametrize("contrast", [1.0, 0.7])
def test_noise_of_the_reference_is_not_taken_for_sharpness(stripes: np.ndarray, contrast: float) -> None:
    """The fraction of the gradients that is kept is the fraction of the contrast, whatever noise lies over either."""
    flatter = 30.0 + contrast * (stripes - 30.0)
    found = measure((noisy(flatter, 1.5, 0), noisy(flatter, 1.5, 1)), (noisy(stripes, 6.0, 2), noisy(stripes, 6.0, 3)))
    assert found["gradient energy kept, over the reference's"] == pytest.approx(contrast, abs=0.02)
    # Of the squares of gradients, twice the variance of the noise is the noise's.
    energy = np.mean(np.concatenate([np.diff(stripes, axis=axis).ravel() ** 2 for axis in (0, 1)]))
    own = contrast**2 + 2 * 1.5**2 / energy
    assert found["own gradient energy, over the reference's"] == pytest.approx(own, rel=0.02)


def test_noise_is_counted_in_shade_alone(stripes: np.ndarray) -> None:
    bright = stripes.copy()
    bright[:, 80:] += 150.0
    few = [noisy(bright, 1.0, seed) for seed in (0, 1)]
    for image in few:
        image[:, 80:] = noisy(image[:, 80:], 20.0, int(image[0, 0, 0] * 1000))
    found = measure((few[0], few[1]), (bright, bright))
    assert bright[:, :80].max() < SHADE < bright[:, 80:].min()
    assert found["share in shade"] == 0.5
    assert found["noise in shade (codes, rms)"] == pytest.approx(1.0, abs=0.03)
