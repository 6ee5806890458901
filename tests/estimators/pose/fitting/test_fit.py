"""Poses without a network, on a pallet-like box whose readings are made here by ray and box in closed form."""

import dataclasses
from dataclasses import replace

import numpy as np
import pytest

from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.estimators.gravity import down_of_camera
from warehouse_sim.estimators.image import Detection, RgbdImage
from warehouse_sim.estimators.pose.fitting import search, verification
from warehouse_sim.estimators.pose.fitting.fit import PoseFit, rectangle_fit
from warehouse_sim.estimators.pose.fitting.hypotheses import (
    distinct,
    hypotheses,
    masked_points,
    quantiles,
    upright_boxes,
)
from warehouse_sim.estimators.pose.fitting.sweep import DIRECTIONS, KEPT, anchored, outer_sides, swept
from warehouse_sim.estimators.pose.fitting.verification import DepthView, VerificationConfig, judge
from warehouse_sim.estimators.pose.icp.surface import build_surface
from warehouse_sim.geometry.boxes import box_corners
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.mesh import TriangleMesh, unit_box
from warehouse_sim.geometry.pose import invert, level_camera, make_transform, rotation_angle, rotation_z
from warehouse_sim.geometry.symmetry import SymmetryGroup

SIZE = np.array([1.2, 0.8, 0.3])
CAMERA = PinholeCamera(240, 160, 220.0, 220.0, 119.5, 79.5)
HALF_TURN = SymmetryGroup(np.stack([np.eye(4), make_transform(rotation_z(np.pi), np.zeros(3))]))


def box() -> ObjectInfo:
    mesh = TriangleMesh(box_corners(SIZE), unit_box().faces)
    return ObjectInfo(
        3, "crate", "pallet", SIZE, float(np.linalg.norm(SIZE)), HALF_TURN, (), None, lambda _, even: mesh
    )


def seen(T_world_object: np.ndarray, pitch: float, wall: float = 9.0) -> tuple[RgbdImage, np.ndarray]:
    """Return an image of the box on a floor before a wall, by the slab method, and the box's true pose."""
    T_world_camera = level_camera(np.array([0.0, 0.0, 1.1]), 0.0, pitch)
    T_camera_object = invert(T_world_camera) @ T_world_object
    v, u = np.mgrid[: CAMERA.height, : CAMERA.width].reshape(2, -1)
    rays = CAMERA.rays_at(u, v)
    inverse = invert(T_camera_object)
    with np.errstate(divide="ignore"):
        a, b = ((sign * SIZE / 2.0 - inverse[:3, 3]) / (rays @ inverse[:3, :3].T) for sign in (-1.0, 1.0))
    enter, leave = np.minimum(a, b).max(axis=1), np.maximum(a, b).min(axis=1)
    hit = (enter < leave) & (enter > 0)
    world = rays @ T_world_camera[:3, :3].T
    ground = np.where(world[:, 2] < -1e-3, -1.1 / np.minimum(world[:, 2], -1e-3), np.inf)
    behind = np.minimum(ground, wall / np.maximum(world[:, 0], 1e-3))
    depth = np.where(hit, enter, behind) + np.random.default_rng(0).normal(0.0, 0.002, len(u))
    shape = CAMERA.height, CAMERA.width
    detection = Detection(hit.reshape(shape), "crate")
    down = down_of_camera(T_world_camera)
    image = RgbdImage(CAMERA, depth.reshape(shape).astype(np.float32), (detection,), gravity=down)
    return image, T_camera_object


@pytest.mark.parametrize("yaw_deg", [5, 40, 80, 130])
@pytest.mark.parametrize("pitch", [0.0, -0.25])
def test_the_box_is_found_whatever_its_direction_and_the_camera_s_pitch(yaw_deg: int, pitch: float) -> None:
    T_world_object = make_transform(rotation_z(np.deg2rad(yaw_deg)), np.array([3.0, 0.3, 0.15]))
    image, gt = seen(T_world_object, pitch)
    for made, shift, turn in ((rectangle_fit(), 0.06, 3.0), (PoseFit(), 0.01, 0.5)):
        made.onboard({3: box()})
        (found,) = made.estimate(image)
        looks = gt @ HALF_TURN.transforms
        turns = np.degrees(rotation_angle(looks[:, :3, :3], found.T_camera_object[None, :3, :3]))
        assert np.linalg.norm(found.T_camera_object[:3, 3] - gt[:3, 3]) < shift
        assert turns.min() < turn
        assert found.score > 0.5


def test_one_of_four_rectangles_is_the_box_when_its_points_are_exact() -> None:
    yaw, place = 0.4, np.array([2.5, -0.4, 0.0])
    rng = np.random.default_rng(1)
    face = np.stack([np.full(400, -0.6), rng.uniform(-0.4, 0.4, 400), rng.uniform(-0.15, 0.15, 400)], axis=1)
    side = np.stack([rng.uniform(-0.6, 0.6, 400), np.full(400, 0.4), rng.uniform(-0.15, 0.15, 400)], axis=1)
    points = np.concatenate([face, side]) @ rotation_z(yaw).T + place
    found = upright_boxes(points, SIZE)
    away = np.linalg.norm(found[:, :3, 3] - place, axis=1)
    turns = np.degrees(rotation_angle(found[:, :3, :3], rotation_z(yaw)[None]))
    best = np.argmin(away + turns)
    assert away[best] < 0.05
    assert turns[best] < 2.0
    # Two ways round, and one more where the 1.2 m are longer than the width: an end each.
    assert len(distinct(found, HALF_TURN)) == 3


def test_the_image_speaks_for_the_ground_truth_and_against_what_it_looks_through(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    T_world_object = make_transform(rotation_z(0.3), np.array([3.0, 0.0, 0.15]))
    image, gt = seen(T_world_object, -0.1)
    surface = build_surface(box().mesh(), 20_000, np.random.default_rng(0))
    mask = image.detections[0].pixels(CAMERA.height, CAMERA.width)
    view = DepthView(CAMERA, image.depth, mask, np.zeros((0, 3)))
    monkeypatch.setattr(verification, "_UNEXPLAINED", 0.0)
    config = VerificationConfig(1500)
    at_gt = judge(gt, surface, view, config)
    assert at_gt.supported > 0.9
    nearer, aside, turned = gt.copy(), gt.copy(), gt @ make_transform(rotation_z(np.pi / 2), np.zeros(3))
    nearer[2, 3] -= 0.3
    aside[0, 3] += 0.5
    assert judge(nearer, surface, view, config).through > 0.8
    for other in (nearer, aside, turned):
        assert judge(other, surface, view, config).score < at_gt.score - 0.1
    hidden = view.depth.copy()
    hidden[:, :120] = 1.0
    covered = judge(gt, surface, DepthView(CAMERA, hidden, mask & (np.arange(240) >= 120), view.points), config)
    assert covered.before < 0.02 < covered.covered


def test_a_neighbour_s_surface_beside_the_mask_is_no_support() -> None:
    """Crates of one height stand side by side and are seen from above: which way one lies, only its mask can say."""
    depth = np.full((CAMERA.height, CAMERA.width), 2.0, dtype=np.float32)
    v, u = np.mgrid[: CAMERA.height, : CAMERA.width]
    x, y = (u - CAMERA.cx) / CAMERA.fx * 2.0, (v - CAMERA.cy) / CAMERA.fy * 2.0
    mask = (np.abs(x) <= SIZE[0] / 2.0) & (np.abs(y) <= SIZE[1] / 2.0)
    points = np.stack([x[mask], y[mask], np.full(mask.sum(), 2.0)], axis=1)[::37]
    view = DepthView(CAMERA, depth, mask, points)
    surface = build_surface(box().mesh(), 20_000, np.random.default_rng(0))
    down = np.diag([1.0, -1.0, -1.0])
    place = np.array([0.0, 0.0, 2.0 + SIZE[2] / 2.0])
    right, turned = (
        judge(make_transform(rotation_z(yaw) @ down, place), surface, view, VerificationConfig(1500))
        for yaw in (0.0, np.pi / 2)
    )
    assert right.supported > 0.9
    assert right.beside < 0.05
    # Two thirds of the turned crate's top lie on its own.
    assert turned.supported == pytest.approx(2.0 / 3.0, abs=0.05)
    assert turned.beside == pytest.approx(1.0 / 3.0, abs=0.05)
    assert turned.score < right.score - 0.4


def test_a_fine_fit_that_goes_astray_is_not_followed(monkeypatch: pytest.MonkeyPatch) -> None:
    image, gt = seen(make_transform(rotation_z(0.6), np.array([3.0, 0.2, 0.15])), -0.2)
    estimator = PoseFit()
    estimator.onboard({3: box()})
    astray = make_transform(rotation_z(0.5), np.array([0.4, 0.3, 0.0]))
    monkeypatch.setattr(search, "fit_finely", lambda sought, starts, config: [poses @ astray for poses in starts])
    (estimate,) = estimator.estimate(image)
    looks = gt @ HALF_TURN.transforms
    turns = rotation_angle(looks[:, :3, :3], estimate.T_camera_object[None, :3, :3])
    assert np.linalg.norm(estimate.T_camera_object[:3, 3] - gt[:3, 3]) < 0.05
    assert np.degrees(turns).min() < 5.0


@pytest.mark.parametrize("count", [1, 2, 3, 50, 401])
@pytest.mark.parametrize("fraction", [0.0, 0.02, 0.3, 0.5])
def test_quantiles_of_rows_are_those_of_numpy(count: int, fraction: float) -> None:
    values = np.random.default_rng(count).normal(size=(3, 2, count))
    np.testing.assert_allclose(
        quantiles(values, fraction), np.quantile(values, (fraction, 1.0 - fraction), axis=-1), atol=1e-12
    )


# Crates that touch and share one mask are each found once, whoever comes first, and one crate seen twice stays one.


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


def test_the_likeliest_of_kinds_that_look_alike_is_fitted_to_the_end() -> None:
    """Of three, two are: without what the detection says, those that come first."""
    image, _ = seen(make_transform(rotation_z(0.6), np.array([3.0, 0.2, 0.15])), -0.2)
    kinds = {number: replace(box(), obj_id=number, name=name) for number, name in ((3, "a"), (4, "b"), (5, "c"))}
    unsure = replace(image.detections[0], model=None, kind_likelihood={"a": 0.3, "b": 0.4, "c": 0.9})
    found = {}
    for given, detection in ((kinds, unsure), ({5: kinds[5]}, replace(unsure, kind_likelihood={}))):
        estimator = PoseFit()
        estimator.onboard(given)
        (found[len(given)],) = estimator.estimate(replace(image, detections=(detection,)))
    assert found[3].obj_id == 5
    np.testing.assert_array_equal(found[3].T_camera_object, found[1].T_camera_object)


def test_a_crate_that_is_detected_twice_is_not_pushed_aside() -> None:
    image, gt = seen(make_transform(rotation_z(0.6), np.array([3.0, 0.2, 0.15])), -0.2)
    twice = replace(image, detections=tuple(replace(image.detections[0], number=i) for i in (0, 1)))
    estimator = PoseFit()
    estimator.onboard({3: box()})
    for item in estimator.estimate(twice):
        assert np.linalg.norm(item.T_camera_object[:3, 3] - gt[:3, 3]) < 0.02


def test_who_is_surest_keeps_its_pose_whatever_others_claim() -> None:
    image, _ = seen(make_transform(rotation_z(0.6), np.array([3.0, 0.2, 0.15])), -0.2)
    first = image.detections[0]
    whole = first.pixels(CAMERA.height, CAMERA.width)
    columns = np.flatnonzero(whole.any(axis=0))
    estimator = PoseFit()
    estimator.onboard({3: box()})
    (alone,) = estimator.estimate(image)
    for part in (columns[: len(columns) // 2], columns[len(columns) // 3 :]):
        mask = np.zeros_like(whole)
        mask[:, part] = whole[:, part]
        found = estimator.estimate(replace(image, detections=(first, replace(first, mask=mask, number=1))))
        assert len(found) == 2
        np.testing.assert_array_equal(found[0].T_camera_object, alone.T_camera_object)


# Poses all round are sifted by the image, on boxes whose readings are made here and then spoiled.


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
