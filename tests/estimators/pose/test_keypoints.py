"""Poses by key points of a face, and on the face that depth measures: openings, an occluder, holes and noise."""

import numpy as np
import pytest

from warehouse_sim.estimators.image import RgbdImage
from warehouse_sim.estimators.pose.keypoints import SeenPoints, moved_onto_face, pose_of_points
from warehouse_sim.estimators.segmenters.segnet.keypoints import face_points, pocket_faces, side_points
from warehouse_sim.estimators.segmenters.segnet.network import KnownFaces
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import level_camera, make_transform, rotation_z, transform_points
from warehouse_sim.schema import Pocket

CAMERA = PinholeCamera.from_focal(1224, 370, 721.5)


def pallet(obj_id: int, length: float, width: float) -> tuple[KnownFaces, np.ndarray, tuple[Pocket, ...]]:
    """Return a pallet of four-way entry with two pockets a side."""
    size = np.array([length, width, 0.144])
    pockets = []
    for face, yaw, deep, across in (("-x", 0.0, length, width), ("+x", np.pi, length, width),
                                    ("-y", np.pi / 2, width, length), ("+y", -np.pi / 2, width, length)):  # fmt: skip
        R = rotation_z(yaw)
        for side in (-0.22, 0.22):
            place = R @ np.array([-deep / 2, side * across, -0.02])
            pockets.append(Pocket(face, make_transform(R, place), np.array([deep, 0.22 * across, 0.1])))
    sides = [side_points(size, pockets, face) for face in pocket_faces(pockets)]
    known = KnownFaces(obj_id, f"p{obj_id}", "pallet", tuple(tuple(p.ravel().tolist()) for p, _ in sides),
                        tuple(tuple(k.tolist()) for _, k in sides))  # fmt: skip
    return known, size, tuple(pockets)


def seen_from(distance: float, yaw: float, noise: float, rng: np.random.Generator, obj: tuple):
    _, size, pockets = obj
    T_world_camera = level_camera(np.array([0.0, -distance, 0.9]), np.pi / 2)
    T = np.linalg.inv(T_world_camera) @ make_transform(rotation_z(yaw), np.array([rng.uniform(-0.5, 0.5), 0.0, 0.08]))
    points, _ = face_points(size, pockets, T)
    uv = CAMERA.project(points) + rng.normal(0, noise, (6, 2))
    return T, SeenPoints(uv, np.full(6, 0.9)), -T_world_camera[2, :3], float(points[:4, 2].mean())


def errors(T: np.ndarray, found: np.ndarray) -> tuple[float, float]:
    turns = [found, found @ make_transform(rotation_z(np.pi), np.zeros(3))]
    angle = min(float(np.arccos(np.clip((np.trace(T[:3, :3].T @ one[:3, :3]) - 1) / 2, -1, 1))) for one in turns)
    return float(np.linalg.norm(T[:3, 3] - found[:3, 3])), angle


@pytest.mark.parametrize("yaw", [-0.5, 0.0, 0.3, 1.4, 2.6])
def test_exact_points_give_the_exact_pose(yaw: float) -> None:
    obj = pallet(1, 1.2, 0.8)
    rng = np.random.default_rng(0)
    T, seen, gravity, distance = seen_from(3.0, yaw, 0.0, rng, obj)
    found = pose_of_points(seen, [obj[0]], CAMERA, gravity, distance)
    assert found is not None
    shift, angle = errors(T, found.T_camera_object)
    assert shift < 1e-3
    assert angle < 1e-3


def test_noise_of_half_a_pixel_costs_centimetres_at_three_metres() -> None:
    obj, rng, shifts, angles = pallet(1, 1.2, 0.8), np.random.default_rng(1), [], []
    for _ in range(60):
        T, seen, gravity, distance = seen_from(3.0, rng.uniform(-0.6, 0.6), 0.5, rng, obj)
        found = pose_of_points(seen, [obj[0]], CAMERA, gravity, distance)
        shift, angle = errors(T, found.T_camera_object)
        shifts.append(shift)
        angles.append(np.rad2deg(angle))
    assert np.median(shifts) < 0.04
    assert np.median(angles) < 4.0


def test_depth_tells_a_near_small_pallet_from_a_far_large_one() -> None:
    """Points of a pallet and of one half as large at half the distance are the same."""
    large = pallet(1, 1.2, 0.8)
    halved = tuple(tuple(0.5 * value for value in side) for side in large[0].points)
    small = KnownFaces(2, "p2", "pallet", halved, large[0].known)
    _, seen, gravity, distance = seen_from(4.0, 0.2, 0.0, np.random.default_rng(2), large)
    assert pose_of_points(seen, [large[0], small], CAMERA, gravity, distance).obj_id == 1
    assert pose_of_points(seen, [large[0], small], CAMERA, gravity, distance / 2).obj_id == 2


def test_unsure_points_are_left_out_and_too_few_give_no_pose() -> None:
    obj = pallet(1, 1.2, 0.8)
    T, seen, gravity, distance = seen_from(3.0, 0.2, 0.0, np.random.default_rng(3), obj)
    seen.uv[4] += 80
    seen.chance[4] = 0.05
    found = pose_of_points(seen, [obj[0]], CAMERA, gravity, distance)
    assert errors(T, found.T_camera_object)[0] < 1e-3
    seen.chance[1:] = 0.01
    assert pose_of_points(seen, [obj[0]], CAMERA, gravity, distance) is None


def measured(T: np.ndarray, obj: tuple, rng: np.random.Generator) -> np.ndarray:
    """Return a depth image of the face's plane, two openings of which show what is 0.6 m behind, before a wall."""
    _, size, pockets = obj
    corners = face_points(size, pockets, T)[0][:4]
    across, down = corners[1] - corners[0], corners[3] - corners[0]
    normal = np.cross(across, down)
    rays = CAMERA.rays()
    depth = (corners[0] @ normal) / (rays @ normal)
    on_plane = rays * depth[..., None] - corners[0]
    x, y = on_plane @ across / (across @ across), on_plane @ down / (down @ down)
    inside = (x >= 0) & (x <= 1) & (y >= 0) & (y <= 1) & (depth > 0)
    opening = ((np.abs(x - 0.28) < 0.12) | (np.abs(x - 0.72) < 0.12)) & (y > 0.15) & (y < 0.85)
    depth = np.where(inside, depth + 0.6 * opening, 9.0)
    depth[inside & (x < 0.15)] = 1.2  # a post before it
    depth *= rng.normal(1.0, 0.002, depth.shape)
    depth[rng.random(depth.shape) < 0.2] = 0.0
    return depth.astype(np.float32)


@pytest.mark.parametrize("known_gravity", [True, False])
def test_depth_says_how_far_the_front_is_and_how_it_is_turned(known_gravity: bool) -> None:
    obj, rng, before, after = pallet(1, 1.2, 0.8), np.random.default_rng(3), [], []
    for _ in range(20):
        T, seen, gravity, distance = seen_from(rng.uniform(2.5, 5.0), rng.uniform(-0.6, 0.6), 1.5, rng, obj)
        gravity = gravity if known_gravity else None
        pose = pose_of_points(seen, [obj[0]], CAMERA, gravity, distance)
        image = RgbdImage(CAMERA, measured(T, obj, rng), (), gravity=gravity)
        before.append(errors(T, pose.T_camera_object))
        moved = moved_onto_face(pose, image)
        after.append(errors(T, moved.T_camera_object))
        assert np.linalg.det(moved.T_camera_object[:3, :3]) == pytest.approx(1.0)
        middle = [transform_points(item.T_camera_object, item.face).mean(axis=0) for item in (pose, moved)]
        assert np.cross(*middle) == pytest.approx(np.zeros(3), abs=1e-9)
    (shift, angle), (shift_after, angle_after) = np.median(before, axis=0), np.median(after, axis=0)
    assert shift > 0.06  # what key points alone say
    assert shift_after < (0.02 if known_gravity else 0.03)
    assert angle > np.radians(5)
    assert angle_after < np.radians(1.0 if known_gravity else 4.0)


def test_the_pose_stays_where_depth_says_nothing_of_the_front() -> None:
    obj, rng = pallet(1, 1.2, 0.8), np.random.default_rng(4)
    _, seen, gravity, distance = seen_from(3.0, 0.2, 1.0, rng, obj)
    pose = pose_of_points(seen, [obj[0]], CAMERA, gravity, distance)
    empty = np.zeros((CAMERA.height, CAMERA.width), dtype=np.float32)
    strewn = rng.uniform(1.6, 5.8, empty.shape).astype(np.float32)
    for depth in (empty, strewn):
        assert moved_onto_face(pose, RgbdImage(CAMERA, depth, (), gravity=gravity)) is pose


def test_a_front_along_the_line_of_sight_is_not_thrown_behind_the_camera() -> None:
    obj, rng = pallet(1, 1.2, 0.8), np.random.default_rng(5)
    for yaw in np.linspace(1.2, 1.56, 8):
        T, seen, gravity, distance = seen_from(3.0, -yaw, 2.0, rng, obj)
        pose = pose_of_points(seen, [obj[0]], CAMERA, gravity, distance)
        if pose is not None:
            moved = moved_onto_face(pose, RgbdImage(CAMERA, measured(T, obj, rng), (), gravity=gravity))
            assert 1.0 < moved.T_camera_object[2, 3] < 7.0
