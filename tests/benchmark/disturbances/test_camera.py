"""Errors of calibration, registration and pitch are what their names say; labels and the image's own numbers stay."""

from dataclasses import replace

import numpy as np
import pytest

from warehouse_sim.benchmark.disturbances import DISTURBANCES, disturbance
from warehouse_sim.errors import UnknownNameError
from warehouse_sim.estimators.gravity import down_of_camera
from warehouse_sim.estimators.image import Detection, RgbdImage
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import level_camera

T_WORLD_CAMERA = level_camera(np.array([0.0, 0.0, 1.5]), 0.3)


@pytest.fixture
def image() -> RgbdImage:
    mask = np.zeros((40, 60), dtype=bool)
    mask[10:20, 15:40] = True
    rgb = np.random.default_rng(0).integers(0, 255, (40, 60, 3)).astype(np.uint8)
    detections = (Detection(mask, 1, number=0), Detection(None, 2, number=1, box_xyxy=(3.0, 4.0, 9.0, 8.0)))
    camera = PinholeCamera.from_focal(60, 40, 50.0)
    depth = np.full((40, 60), 2.0, np.float32)
    return RgbdImage(camera, depth, detections, rgb, 3, 4, T_WORLD_CAMERA, down_of_camera(T_WORLD_CAMERA))


def changed(image: RgbdImage, name: str) -> RgbdImage:
    return disturbance(name)(image, np.random.default_rng(1))


@pytest.mark.parametrize(("name", "factor"), [("focal length +0.5 %", 1.005), ("focal length +2 %", 1.02)])
def test_a_longer_focal_length_makes_things_seem_narrower(image: RgbdImage, name: str, factor: float) -> None:
    after = changed(image, name)
    assert (after.camera.fx, after.camera.fy) == pytest.approx((50.0 * factor, 50.0 * factor))
    assert after.camera == replace(image.camera, fx=after.camera.fx, fy=after.camera.fy)
    width = [item.camera.rays_at(np.array([0, 59]), np.array([20, 20]))[:, 0] for item in (image, after)]
    assert np.ptp(width[1]) == pytest.approx(np.ptp(width[0]) / factor)


def test_other_errors_of_the_calibration_change_one_number(image: RgbdImage) -> None:
    assert changed(image, "principal point +8 px").camera == replace(image.camera, cx=image.camera.cx + 8.0)
    deeper = changed(image, "depth +2 %")
    assert np.allclose(deeper.depth, 2.04)
    assert deeper.camera == image.camera


@pytest.mark.parametrize("by", [2, 6])
def test_colour_and_what_was_found_in_it_move_against_depth(image: RgbdImage, by: int) -> None:
    after = changed(image, f"registration {by} px")
    assert np.array_equal(after.depth, image.depth)
    assert after.rgb is not None
    assert image.rgb is not None
    assert np.array_equal(after.rgb[by:, by:], image.rgb[:-by, :-by])
    v, u = np.nonzero(after.detections[0].mask)
    assert (v.min(), v.max(), u.min(), u.max()) == (10 + by, 19 + by, 15 + by, 39 + by)
    assert after.detections[1].box_xyxy == (3.0 + by, 4.0 + by, 9.0 + by, 8.0 + by)


@pytest.mark.parametrize("degrees", [1.0, 3.0])
def test_a_camera_that_is_believed_to_look_higher_turns_gravity_and_place_alike(
    image: RgbdImage, degrees: float
) -> None:
    after = changed(image, f"pitch {degrees:g} deg")
    assert after.gravity is not None
    assert after.T_world_camera is not None
    assert np.degrees(np.arccos(after.gravity @ image.gravity)) == pytest.approx(degrees)
    assert np.allclose(after.gravity, down_of_camera(after.T_world_camera))
    # What is straight ahead is believed to lie higher.
    ahead = after.T_world_camera[:3, :3] @ np.array([0.0, 0.0, 1.0])
    assert np.degrees(np.arcsin(ahead[2])) == pytest.approx(degrees)
    assert np.array_equal(after.depth, image.depth)


def test_no_disturbance_changes_the_image_that_it_is_given(image: RgbdImage) -> None:
    before = image.depth.copy(), image.detections[0].mask.copy(), image.camera  # type: ignore[union-attr]
    for name in DISTURBANCES:
        if name not in ("boxes only", "as of a segmenter", "touching merged"):  # which take masks, not boxes
            changed(image, name)
    assert np.array_equal(image.depth, before[0])
    assert np.array_equal(image.detections[0].mask, before[1])
    assert image.camera == before[2]


def test_an_unknown_disturbance_is_named() -> None:
    with pytest.raises(UnknownNameError, match="boxes only"):
        disturbance("boxes")
