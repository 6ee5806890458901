"""Gravity out of what stands and lies in sight, against that of images made in closed form."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from tests.estimators.pose.faces.made_face import MadePallet, seen
from warehouse_sim.estimators.image import RgbdImage
from warehouse_sim.estimators.pose.faces.level import Leveling, find_down

LOADED = MadePallet(load=0.9)


def bent(image: RgbdImage, seed: int) -> RgbdImage:
    """Return an image whose surfaces are wavy by 10 mm, over some 20 px, as time-of-flight cameras read them."""
    waves = gaussian_filter(np.random.default_rng(seed).normal(size=image.depth.shape), 8.0)
    depth = np.where(image.depth > 0, image.depth + 0.010 * waves / waves.std(), 0.0)
    return replace(image, depth=depth.astype(np.float32), gravity=None)


def off_deg(level: Leveling, image: RgbdImage) -> float:
    assert image.gravity is not None
    return float(np.rad2deg(np.arccos(np.clip(level.down @ image.gravity, -1.0, 1.0))))


@pytest.mark.parametrize("pitch", [-0.06, 0.0, 0.06])
@pytest.mark.parametrize("yaw", [0.0, 0.4])
def test_without_a_floor_a_load_says_what_is_upright(pitch: float, yaw: float) -> None:
    image, _ = seen(LOADED, (1.8, 0.0, yaw), camera_height=0.5, pitch=pitch, floor=False)
    level = find_down(bent(image, 1), np.random.default_rng(0))
    assert off_deg(level, image) < 1.5


@pytest.mark.parametrize("nearer", [1.0, 0.6])
def test_a_floor_is_level_even_where_it_reads_too_near(nearer: float) -> None:
    image, _ = seen(MadePallet(), camera_height=0.5, pitch=-0.1)
    below = seen(MadePallet(), camera_height=0.5, pitch=-0.1, noise=0.0)[0].depth
    v = np.arange(len(below))[:, None] / len(below)
    depth = np.where((v > 0.75) & (below < 2.0), image.depth * nearer, image.depth).astype(np.float32)
    level = find_down(bent(replace(image, depth=depth), 2), np.random.default_rng(0))
    assert off_deg(level, image) < 2.0


def test_the_stated_error_is_the_true_one() -> None:
    off, stated = [], []
    for seed in range(12):
        rng = np.random.default_rng(seed)
        place = (rng.uniform(1.4, 2.2), 0.0, rng.uniform(-0.3, 0.3))
        image, _ = seen(LOADED, place, 0.4, rng.normal(0.0, 0.05), floor=bool(seed % 2), seed=seed)
        level = find_down(bent(image, seed), rng)
        assert image.gravity is not None
        off.append(level.down[2] / level.down[1] - image.gravity[2] / image.gravity[1])
        stated.append(level.pitch)
    assert 0.2 < np.sqrt(np.mean((np.array(off) / stated) ** 2)) < 2.0


def test_gravity_that_is_given_is_taken_and_nothing_seen_leaves_a_level_camera() -> None:
    image, _ = seen(LOADED)
    given = find_down(image, np.random.default_rng(0))
    assert np.array_equal(given.down, image.gravity)
    blind = find_down(replace(image, depth=np.zeros_like(image.depth), gravity=None), np.random.default_rng(0))
    assert np.array_equal(blind.down, [0.0, 1.0, 0.0])
    assert given.pitch < 0.01 < blind.pitch
