"""Crates that stand parallel tell each other's heading; what stands askew, and shows it, stays so."""

from dataclasses import replace

import numpy as np
import pytest

from tests.estimators.pose.fitting.test_fit import CAMERA, HALF_TURN, SIZE, box, seen
from warehouse_sim.estimators.image import RgbdImage
from warehouse_sim.estimators.pose.fitting.alignment import agreeing, expected_heading
from warehouse_sim.estimators.pose.fitting.fit import PoseFit, rectangle_fit
from warehouse_sim.geometry.pose import make_transform, rotation_angle, rotation_z

PLACES = ((3.0, 0.9), (3.0, -0.9), (5.2, 1.3), (5.6, -0.4))
"""Of four crates on the floor (m); the last one is far, between the others."""


def hall(yaws: tuple[float, ...], seed: int | None = None) -> tuple[RgbdImage, list[np.ndarray]]:
    """Return an image of crates with these headings, and their poses.

    With a seed, a board covers most of the last one, and its readings are off by two decimetres.
    """
    placed = [
        make_transform(rotation_z(yaw), np.array([*place, SIZE[2] / 2]))
        for yaw, place in zip(yaws, PLACES, strict=True)
    ]
    images, gts = zip(*(seen(T, -0.2) for T in placed), strict=True)
    depths = np.stack([image.depth for image in images])
    nearest = depths.argmin(axis=0)
    masks = [image.detections[0].mask & (nearest == number) for number, image in enumerate(images)]
    depth = depths.min(axis=0)
    if seed is not None:
        last = masks[-1]
        columns = np.flatnonzero(last.any(axis=0))
        board = (np.arange(CAMERA.width) > np.quantile(columns, 0.3)) & (np.arange(CAMERA.width) <= columns.max())
        depth[last & board] = 1.5
        masks[-1] = last & ~board
        depth[masks[-1]] += np.random.default_rng(seed).normal(0.0, 0.2, int(masks[-1].sum()))
    detections = tuple(replace(images[0].detections[0], mask=mask, number=i) for i, mask in enumerate(masks))
    return replace(images[0], depth=depth, detections=detections), list(gts)


def turned_deg(image: RgbdImage, gts: list[np.ndarray]) -> np.ndarray:
    """Return how far the pose of each detection is turned (deg)."""
    estimator = PoseFit()
    estimator.onboard({3: box()})
    errors = []
    for item in estimator.estimate(image):
        looks = gts[item.detection] @ HALF_TURN.transforms
        errors.append(np.degrees(rotation_angle(looks[:, :3, :3], item.T_camera_object[None, :3, :3]).min()))
    return np.array(errors)


def test_one_that_hardly_shows_is_put_in_line_with_the_neighbours() -> None:
    alone, among = [], []
    for seed in range(6):
        image, gts = hall((0.5, 0.5, 0.5, 0.5), seed)
        among.append(turned_deg(image, gts)[-1])
        alone.append(turned_deg(replace(image, detections=image.detections[-1:]), gts)[-1])
    assert np.min(alone) > 8.0
    assert np.median(among) < 3.0


@pytest.mark.parametrize("askew", [0.2, 0.4, 0.7])
def test_what_stands_askew_and_shows_it_stays_so(askew: float) -> None:
    errors = turned_deg(*hall((0.5, 0.5, 0.5, 0.5 + askew)))
    assert errors.max() < 1.5


def test_a_rectangle_without_icp_knows_no_neighbours() -> None:
    estimator = rectangle_fit()
    estimator.onboard({3: box()})
    for seed in range(6):
        image, _ = hall((0.5, 0.5, 0.5, 0.5), seed)
        together = estimator.estimate(image)
        for item, detection in zip(together, image.detections, strict=True):
            (alone,) = estimator.estimate(replace(image, detections=(detection,)))
            np.testing.assert_array_equal(item.T_camera_object, alone.T_camera_object)


def test_crates_across_each_other_agree() -> None:
    headings = 0.3 + np.pi / 2 * np.array([0, 1, 2, -1])
    np.testing.assert_allclose(agreeing(headings, headings, np.full(4, 10.0)), 40.0 / 40.5)
    heading, part = expected_heading(headings + np.array([0.0, 0.02, -0.02, 0.0]), np.full(4, 10.0))
    assert (heading - 0.3 + 0.1) % (np.pi / 2) == pytest.approx(0.1, abs=1e-9)
    assert part > 0.9


def test_headings_all_round_agree_on_little() -> None:
    headings = np.linspace(0.0, np.pi / 2, 12, endpoint=False)
    assert expected_heading(headings, np.ones(12))[1] < 0.15


def test_who_has_no_weight_says_nothing() -> None:
    heading, part = expected_heading(np.array([0.1, 0.9, 0.11]), np.array([1.0, 0.0, 1.0]))
    assert heading == pytest.approx(0.105, abs=1e-3)
    assert part == pytest.approx(2.0 / 2.5, abs=0.02)
