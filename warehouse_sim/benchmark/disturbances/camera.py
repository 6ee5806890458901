"""What a robot believes wrongly of its camera: calibration, registration of colour and depth, pitch.

Each is a function of an image and a random stream, as those of ``mask_errors``; images and labels stay what they are,
so that an estimate of what is believed is scored against what is true.
"""

from dataclasses import replace

import numpy as np
from jaxtyping import Bool

from warehouse_sim.benchmark.disturbances.masks import Disturb
from warehouse_sim.estimators.image import RgbdImage
from warehouse_sim.geometry.pose import Transform, make_transform


def focal_off(percent: float) -> Disturb:
    """Return what believes focal lengths that are so many percent too long: all seems narrower than it is."""

    def disturb(image: RgbdImage, rng: np.random.Generator) -> RgbdImage:
        camera, factor = image.camera, 1.0 + percent / 100.0
        return replace(image, camera=replace(camera, fx=factor * camera.fx, fy=factor * camera.fy))

    return disturb


def centre_off(by_px: float) -> Disturb:
    """Return what believes a principal point that lies so many pixels to the right."""

    def disturb(image: RgbdImage, rng: np.random.Generator) -> RgbdImage:
        return replace(image, camera=replace(image.camera, cx=image.camera.cx + by_px))

    return disturb


def depth_off(percent: float) -> Disturb:
    """Return what reads depth so many percent too far."""

    def disturb(image: RgbdImage, rng: np.random.Generator) -> RgbdImage:
        return replace(image, depth=image.depth * np.float32(1.0 + percent / 100.0))

    return disturb


def unregistered(by_px: int) -> Disturb:
    """Return what shifts colour and all that was found in it so many pixels right and down against depth.

    So it is where the place of the colour camera beside the depth camera is wrong.
    """

    def disturb(image: RgbdImage, rng: np.random.Generator) -> RgbdImage:
        found = []
        for item in image.detections:
            box = item.box_xyxy
            moved = None if box is None else (box[0] + by_px, box[1] + by_px, box[2] + by_px, box[3] + by_px)
            mask = None if item.mask is None else _shifted(np.asarray(item.mask, dtype=bool), by_px)
            # Of an object at the rim that leaves the image nothing else is left to say.
            found.append(replace(item, mask=item.mask if mask is not None and not mask.any() else mask, box_xyxy=moved))
        rgb = None if image.rgb is None else _shifted(image.rgb, by_px)
        return replace(image, detections=tuple(found), rgb=rgb)

    return disturb


def pitched(by_deg: float) -> Disturb:
    """Return what believes that the camera looks so many degrees higher than it does: gravity and place turn."""

    def disturb(image: RgbdImage, rng: np.random.Generator) -> RgbdImage:
        turn = _about_x(np.deg2rad(by_deg))
        gravity = None if image.gravity is None else turn[:3, :3].T @ image.gravity
        place = None if image.T_world_camera is None else image.T_world_camera @ turn
        return replace(image, gravity=gravity, T_world_camera=place)

    return disturb


CAMERA_ERRORS: dict[str, Disturb] = {
    "focal length +0.5 %": focal_off(0.5),
    "focal length +2 %": focal_off(2.0),
    "principal point +2 px": centre_off(2.0),
    "principal point +8 px": centre_off(8.0),
    "depth +0.5 %": depth_off(0.5),
    "depth +2 %": depth_off(2.0),
    "registration 2 px": unregistered(2),
    "registration 6 px": unregistered(6),
    "pitch 1 deg": pitched(1.0),
    "pitch 3 deg": pitched(3.0),
}
"""In the order of the tables."""


def _shifted(values: Bool[np.ndarray, "h w *c"], by_px: int) -> Bool[np.ndarray, "h w *c"]:
    """Return an image moved right and down; what comes in is zero."""
    moved = np.zeros_like(values)
    moved[by_px:, by_px:] = values[: values.shape[0] - by_px, : values.shape[1] - by_px]
    return moved


def _about_x(angle: float) -> Transform:
    c, s = np.cos(angle), np.sin(angle)
    return make_transform(np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]]), np.zeros(3))
