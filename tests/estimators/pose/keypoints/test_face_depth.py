"""Poses on the face that depth measures, against true ones, with openings, an occluder, holes and noise."""

import numpy as np
import pytest

from tests.estimators.pose.keypoints.test_pnp import CAMERA, errors, pallet, seen_from
from warehouse_sim.estimators.image import RgbdImage
from warehouse_sim.estimators.pose.keypoints import moved_onto_face, pose_of_points
from warehouse_sim.estimators.segmenters.segnet.keypoints import face_points
from warehouse_sim.geometry.pose import transform_points


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
    for _ in range(40):
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
    for yaw in np.linspace(1.2, 1.56, 20):
        T, seen, gravity, distance = seen_from(3.0, -yaw, 2.0, rng, obj)
        pose = pose_of_points(seen, [obj[0]], CAMERA, gravity, distance)
        if pose is not None:
            moved = moved_onto_face(pose, RgbdImage(CAMERA, measured(T, obj, rng), (), gravity=gravity))
            assert 1.0 < moved.T_camera_object[2, 3] < 7.0
