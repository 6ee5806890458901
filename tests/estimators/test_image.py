from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from tests.errors import one_line
from warehouse_sim.errors import InputError
from warehouse_sim.estimators.gravity import down_from_floor, down_of_camera, upright_frame
from warehouse_sim.estimators.image import Detection, RgbdImage
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.lens import Distortion, Fisheye
from warehouse_sim.geometry.pose import level_camera

K = np.array([[50.0, 0.0, 31.5], [0.0, 50.0, 23.5], [0.0, 0.0, 1.0]])
DEPTH = np.full((48, 64), 2.0)


def image(**changes: Any) -> RgbdImage:
    return RgbdImage.from_arrays(**({"depth": DEPTH, "K": K} | changes))


def test_an_image_is_made_of_plain_lists_and_arrays() -> None:
    made = image(K=K.tolist(), detections=[Detection(box_xyxy=[10, 5, 30, 20])], gravity=(0, 1, 0))
    assert (made.camera.width, made.camera.height, made.camera.fx) == (64, 48, 50.0)
    assert made.depth.dtype == np.float32
    assert made.detections[0].pixels(48, 64).sum() == 21 * 16
    assert isinstance(image(distortion=[0.1, 0, 0, 0, 0]).camera.distortion, Distortion)
    assert isinstance(image(distortion=np.array([0.1, 0, 0, 0])).camera.distortion, Fisheye)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: RgbdImage.from_arrays(), "from_arrays: missing a required argument: 'depth'"),
        (lambda: RgbdImage.from_arrays(DEPTH, K, rbg=DEPTH), "did you mean 'rgb'?"),
        (lambda: RgbdImage("x", DEPTH, ()), "camera must be a PinholeCamera, found 'x'"),
        (lambda: image(depth="x"), "depth must be an array of numbers, found 'x'"),
        (lambda: image(depth=1000 * DEPTH), "depth must be in metres"),
        (lambda: image(depth=DEPTH[0]), "depth must be (height, width)"),
        (lambda: image(K="x"), "K must be an array of numbers"),
        (lambda: image(K=np.eye(4)), "K 3x3, found (48, 64) and (4, 4)"),
        (lambda: image(detections=None), "detections must be a list of Detection, found None"),
        (lambda: image(detections=[3]), "detection 0 must be a Detection, found 3"),
        (lambda: image(rgb=np.ones((48, 64, 3))), "rgb must be uint8"),
        (lambda: image(gravity="x"), "gravity must be an array of numbers, found 'x'"),
        (lambda: image(gravity=(0, 0, 9.81)), "gravity must be a unit vector"),
        (lambda: image(distortion="x"), "distortion must be an array of numbers"),
        (lambda: image(distortion=[0.1]), "k1 to k4 of a fisheye, found [0.1]"),
        (lambda: Detection(), "neither a mask nor a box_xyxy"),
        (lambda: Detection(mask="x"), "must be True or False at (height, width)"),
        (lambda: Detection(box_xyxy=(1, 2, 3)), "(left, top, right, bottom) in pixels"),
        (lambda: Detection(box_xyxy=(1, 2, 3, 4), score="high"), "score of a detection must be a number"),
        (lambda: Detection(box_xyxy=(1, 2, 3, 4), number="first"), "must be a whole number from 0, found 'first'"),
        (lambda: Detection(box_xyxy=(1, 2, 3, 4), number=-1), "must be a whole number from 0, found -1"),
        (lambda: Detection(box_xyxy=(1, 2, 3, 4), may_be="epal1"), "a list of names, found '' and 'epal1'"),
        (lambda: Detection(box_xyxy=(1, 2, 3, 4), model=1.5), "a name or an obj_id, found 1.5"),
    ],
)
def test_what_does_not_fit_is_said_in_one_line(call: Callable[[], Any], words: str) -> None:
    with one_line(InputError, words):
        call()


# Gravity in closed form: a camera that is turned by known angles, a floor that is drawn by hand.


@pytest.mark.parametrize(("pitch", "roll"), [(0.0, 0.0), (-0.3, 0.0), (0.2, 0.1)])
def test_down_is_what_a_plumb_line_shows_and_the_upright_frame_is_a_turn_to_it(pitch: float, roll: float) -> None:
    T_world_camera = level_camera(np.array([1.0, 2.0, 1.5]), 0.7, pitch, roll)
    down = down_of_camera(T_world_camera)
    np.testing.assert_allclose(T_world_camera[:3, :3] @ down, [0.0, 0.0, -1.0], atol=1e-12)
    R = upright_frame(down)
    np.testing.assert_allclose(R.T @ R, np.eye(3), atol=1e-12)
    assert np.linalg.det(R) > 0.99
    np.testing.assert_allclose(R.T @ -down, [0.0, 0.0, 1.0], atol=1e-12)
    assert (R.T @ [0.0, 0.0, 1.0])[1] == pytest.approx(0.0, abs=1e-12)  # the camera looks along x, up or down


@pytest.mark.parametrize("pitch", [-0.5, -0.2, 0.0])
def test_a_floor_in_sight_tells_gravity_and_a_wall_does_not(pitch: float) -> None:
    camera = PinholeCamera(160, 120, 120.0, 120.0, 79.5, 59.5)
    T_world_camera = level_camera(np.array([0.0, 0.0, 1.2]), 0.0, pitch, 0.05)
    v, u = np.mgrid[:120, :160].reshape(2, -1)
    rays = camera.rays_at(u, v)
    world = rays @ T_world_camera[:3, :3].T
    rng = np.random.default_rng(3)
    floor = np.where(world[:, 2] < -1e-3, -1.2 / np.minimum(world[:, 2], -1e-3), 100.0)
    wall = 4.0 / np.maximum(world[:, 0], 0.1)
    depth = np.minimum(floor, wall) + rng.normal(0.0, 0.003, len(u))
    found = down_from_floor(camera, depth.reshape(120, 160).astype(np.float32), rng)
    assert found is not None
    assert np.degrees(np.arccos(found @ down_of_camera(T_world_camera))) < 0.3
    assert down_from_floor(camera, wall.reshape(120, 160).astype(np.float32), rng) is None
