"""Patches of images that differ by their grain are told apart, and patches of the same kind are not."""

import numpy as np
import pytest

from docs.figures import patches
from docs.figures.patches import scores


def places(rng: np.random.Generator, grain: float, count: int = 12) -> list[list[np.ndarray]]:
    """Return blurred noise, an image a place, with grain of so many codes."""
    coarse = rng.uniform(60.0, 190.0, (count, 15, 20, 3)).repeat(12, axis=1).repeat(12, axis=2)
    noisy = coarse + grain * rng.standard_normal(coarse.shape)
    return [[np.clip(image, 0, 255).astype(np.uint8)] for image in noisy]


def test_grain_tells_images_apart_and_images_of_one_kind_are_not_told_apart(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(patches, "_PATCHES", 240)
    monkeypatch.setattr(patches, "_EDGE", 32)
    monkeypatch.setattr(patches, "_EPOCHS", 4)
    rng = np.random.default_rng(0)
    grainy, clean, again = (places(rng, grain) for grain in (12.0, 0.0, 0.0))
    assert np.mean(scores(clean, grainy)) > 0.95
    assert 0.2 < np.mean(scores(clean, again)) < 0.8
