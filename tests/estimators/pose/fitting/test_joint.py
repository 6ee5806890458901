"""Crates that touch and share one mask are each found once, whoever comes first, and one crate seen twice stays one."""

from dataclasses import replace

import numpy as np
import pytest

from tests.estimators.pose.fitting.test_fit import HALF_TURN, SIZE, box, seen
from warehouse_sim.estimators.image import Detection, RgbdImage
from warehouse_sim.estimators.pose.fitting.fit import PoseFit
from warehouse_sim.geometry.pose import make_transform, rotation_angle, rotation_z

YAW = 0.6


def merged(apart: np.ndarray) -> tuple[RgbdImage, list[np.ndarray]]:
    """Return an image of two crates, ``apart`` in their own frame, both detections with the mask of both."""
    first = make_transform(rotation_z(YAW), np.array([3.4, 0.2, SIZE[2] / 2.0]))
    images, gts = zip(*(seen(first @ make_transform(None, move), -0.2) for move in (np.zeros(3), apart)), strict=True)
    depth = np.minimum(images[0].depth, images[1].depth)
    mask = images[0].detections[0].mask | images[1].detections[0].mask
    detections = Detection(mask, "crate", number=4), Detection(mask.copy(), "crate", number=2)
    return replace(images[0], depth=depth, detections=detections), list(gts)


@pytest.mark.parametrize(
    "apart",
    [np.array([0.0, 0.92, 0.0]), np.array([1.21, 0.0, 0.0]), np.array([0.5, -0.85, 0.0]), np.array([0.0, 0.0, 0.3])],
    ids=["left", "behind", "aside", "above"],
)
def test_two_crates_in_one_mask_are_both_found(apart: np.ndarray) -> None:
    image, gts = merged(apart)
    estimator = PoseFit()
    estimator.onboard({3: box()})
    found = estimator.estimate(image)
    assert [item.detection for item in found] == [4, 2]
    poses = [item.T_camera_object for item in found]
    away = np.array([[np.linalg.norm(pose[:3, 3] - gt[:3, 3]) for gt in gts] for pose in poses])
    assert sorted(away.argmin(axis=1)) == [0, 1]
    # Nothing marks the height at which one plain crate ends and the next begins.
    assert away.min(axis=1).max() < 0.06
    for pose, nearest in zip(poses, away.argmin(axis=1), strict=True):
        looks = gts[nearest] @ HALF_TURN.transforms
        assert np.degrees(rotation_angle(looks[:, :3, :3], pose[None, :3, :3])).min() < 2.0


def test_a_crate_that_is_detected_twice_is_not_pushed_aside() -> None:
    image, gt = seen(make_transform(rotation_z(0.6), np.array([3.0, 0.2, 0.15])), -0.2)
    twice = replace(image, detections=tuple(replace(image.detections[0], number=i) for i in (0, 1)))
    estimator = PoseFit()
    estimator.onboard({3: box()})
    for item in estimator.estimate(twice):
        assert np.linalg.norm(item.T_camera_object[:3, 3] - gt[:3, 3]) < 0.02
