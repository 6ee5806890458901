"""Edges of colour where depth jumps: seen through a sensor's own faults, missed in images of another place."""

import cv2
import numpy as np
import pytest

from warehouse_sim.dataset.checks.colour import LEAST_RANK, edge_rank

HEIGHT, WIDTH = 360, 400


def boxes(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return colour and depth of boxes of many colours and distances before a striped wall."""
    rng = np.random.default_rng(seed)
    rgb = np.full((HEIGHT, WIDTH, 3), 120, np.uint8)
    rgb[:, ::16] = 90
    depth = np.full((HEIGHT, WIDTH), 9.0, np.float32)
    for near in np.linspace(7.0, 2.0, 12):
        left, top = int(rng.integers(WIDTH - 90)), int(rng.integers(HEIGHT - 90))
        part = np.s_[top : top + int(rng.integers(40, 90)), left : left + int(rng.integers(40, 90))]
        rgb[part], depth[part] = rng.integers(40, 220, 3), near
    return cv2.add(rgb, rng.integers(0, 12, rgb.shape, dtype=np.uint8)), depth


@pytest.mark.parametrize("seed", range(5))
def test_colour_and_depth_of_one_place_agree_and_of_two_places_do_not(seed: int) -> None:
    rgb, depth = boxes(seed)
    right, wrong = edge_rank(rgb, depth), edge_rank(rgb, boxes(seed + 100)[1])
    assert right is not None
    assert wrong is not None
    assert right > 0.8
    assert wrong < LEAST_RANK


@pytest.mark.parametrize("seed", range(5))
def test_what_swells_by_two_pixels_still_agrees(seed: int) -> None:
    rgb, depth = boxes(seed)
    rank = edge_rank(rgb, cv2.erode(depth, np.ones((5, 5), np.uint8)))
    assert rank is not None
    assert rank > 0.7


def test_where_readings_begin_to_fail_there_is_no_edge() -> None:
    rng = np.random.default_rng(3)
    rgb = rng.integers(60, 80, (HEIGHT, WIDTH, 3), dtype=np.uint8)
    depth = rng.uniform(6.0, 12.0, (HEIGHT // 8, WIDTH // 8)).repeat(8, 0).repeat(8, 1).astype(np.float32)
    depth[(rng.random((HEIGHT // 8, WIDTH // 8)) < 0.8).repeat(8, 0).repeat(8, 1)] = 0.0
    assert edge_rank(rgb, depth) is None


def test_an_image_of_one_colour_says_nothing_for_or_against() -> None:
    rank = edge_rank(np.full((HEIGHT, WIDTH, 3), 128, np.uint8), boxes(0)[1])
    assert rank == pytest.approx(0.5)
