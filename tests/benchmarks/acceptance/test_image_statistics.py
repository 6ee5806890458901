"""Closed forms of what is measured of images."""

import cv2
import numpy as np
import pytest

from benchmarks.acceptance.image_statistics import Numbers, hue_entropy, warehouse_recipes


def test_a_plain_image_is_flat_without_edges_or_hues() -> None:
    numbers = Numbers.of(np.full((64, 128, 3), 119, np.uint8))
    assert (numbers.edges, numbers.flat, numbers.hues.sum()) == (0.0, 1.0, 0.0)
    assert numbers.brightest == pytest.approx(50.0, abs=0.2)  # sRGB 119 is L* 50


def test_a_quarter_of_noise_leaves_three_quarters_flat() -> None:
    image = np.full((64, 64, 3), 90, np.uint8)
    image[:32, :32] += np.random.default_rng(0).integers(0, 60, (32, 32, 1), dtype=np.uint8)
    assert Numbers.of(image).flat == 0.75


def test_even_hues_have_log2_of_the_bins() -> None:
    hue = np.repeat(np.arange(180, dtype=np.uint8), 40).reshape(60, 120)
    hsv = np.dstack([hue, np.full_like(hue, 200), np.full_like(hue, 200)])
    numbers = Numbers.of(cv2.cvtColor(hsv, cv2.COLOR_HSV2RGB))
    assert hue_entropy(numbers.hues) == pytest.approx(np.log2(30), abs=0.05)


def test_thumbnails_of_an_image_and_its_negative_are_opposite() -> None:
    image = np.random.default_rng(1).integers(0, 256, (96, 128, 3), dtype=np.uint8)
    one, other = Numbers.of(image), Numbers.of(255 - image)
    assert (one.small * one.small).mean() == pytest.approx(1.0)
    assert (one.small * other.small).mean() == pytest.approx(-1.0, abs=0.01)


def test_training_sets_and_miniatures_stand_for_no_warehouse() -> None:
    names = warehouse_recipes()
    assert "selective_rack" in names
    assert not {"smoke", "demo", "mixed_more", "industrial_cartons"} & set(names)
