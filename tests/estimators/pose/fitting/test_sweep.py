"""Poses all round are sifted by the image, on boxes whose readings are made here and then spoiled."""

import dataclasses

import numpy as np

from tests.estimators.pose.fitting.test_fit import CAMERA, HALF_TURN, SIZE, box, seen
from warehouse_sim.estimators.image import Detection, RgbdImage
from warehouse_sim.estimators.pose.fitting.hypotheses import hypotheses, masked_points
from warehouse_sim.estimators.pose.fitting.sweep import DIRECTIONS, KEPT, anchored, outer_sides, swept
from warehouse_sim.estimators.pose.fitting.verification import DepthView
from warehouse_sim.estimators.pose.icp.surface import build_surface
from warehouse_sim.geometry.pose import make_transform, rotation_angle, rotation_z

YAWS_DEG = (0, 25, 60, 90, 115, 140)


def spoiled(yaw: float, seed: int) -> tuple[RgbdImage, np.ndarray]:
    """Return a box whose left quarter a near post hides, and of whose readings an eighth is off by up to 40 cm."""
    image, gt = seen(make_transform(rotation_z(yaw), np.array([3.0, 0.1, 0.15])), -0.2)
    rng, depth = np.random.default_rng(seed), image.depth.copy()
    mask = image.detections[0].pixels(CAMERA.height, CAMERA.width).copy()
    columns = np.flatnonzero(mask.any(axis=0))
    post = columns[: len(columns) // 4]
    depth[:, post], mask[:, post] = 1.0, False
    off = rng.random(depth.shape) < 0.125
    depth[off] += rng.uniform(-0.4, 0.4, off.sum()).astype(np.float32)
    return dataclasses.replace(image, depth=depth, detections=(Detection(mask, "crate"),)), gt


def error(poses: np.ndarray, gt: np.ndarray) -> float:
    """Return the least error of some poses, 15 cm or 15 degrees being 1."""
    looks = gt @ HALF_TURN.transforms
    away = np.linalg.norm(poses[:, None, :3, 3] - looks[:, :3, 3], axis=2) / 0.15
    turn = np.stack([np.degrees(rotation_angle(poses[:, :3, :3], look[None, :3, :3])) for look in looks], axis=1) / 15
    return float(np.maximum(away, turn).min())


def test_a_hidden_corner_and_readings_between_surfaces_lead_rectangles_astray_but_not_the_sweep() -> None:
    of_rectangle, of_sweep = [], []
    sides = outer_sides(build_surface(box().mesh(), 20_000, np.random.default_rng(0)))
    for yaw_deg in YAWS_DEG:
        image, gt = spoiled(np.deg2rad(yaw_deg), yaw_deg)
        mask = image.detections[0].pixels(CAMERA.height, CAMERA.width)
        points = masked_points(image, mask, np.random.default_rng(0))
        view = DepthView(CAMERA, image.depth, mask, points[:400])
        assert image.gravity is not None
        of_rectangle.append(error(hypotheses(points, SIZE, image.gravity), gt))
        found = swept(points, sides, HALF_TURN, view, image.gravity)
        assert len(found) <= KEPT
        of_sweep.append(error(found, gt))
    assert np.mean(np.array(of_rectangle) < 1.0) <= 0.5
    assert np.max(of_sweep) < 1.0


def test_boxes_begin_and_end_where_the_points_do() -> None:
    rng, yaw, place = np.random.default_rng(3), np.pi / 24 * 5, np.array([4.0, 1.0, 0.2])
    # The right half of the near long side: the box reaches farther to the left than the points.
    seen_part = np.stack([rng.uniform(0, 0.6, 500), np.full(500, -0.4), rng.uniform(-0.15, 0.15, 500)], axis=1)
    found = anchored(seen_part @ rotation_z(yaw).T + place, SIZE, np.pi, quantile=0.0)
    gt = make_transform(rotation_z(yaw), place)
    away = np.linalg.norm(found[:, :3, 3] - gt[:3, 3], axis=1)
    same = rotation_angle(found[:, :3, :3], gt[None, :3, :3]) < 1e-6
    assert same.sum() == 8
    assert away[same].min() < 0.01
    assert len(found) == 8 * DIRECTIONS
