"""Errors of what an estimator is given: outlines, neighbours, boxes, names; calibration, registration, pitch.

Each is a function of an image with ground-truth masks and a random stream, and none is what training uses.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import cv2
import numpy as np
from jaxtyping import Bool, Float

from warehouse_sim.errors import UnknownNameError
from warehouse_sim.estimators.image import Detection, RgbdImage
from warehouse_sim.geometry.pose import make_transform, rotation_x

Disturb = Callable[[RgbdImage, np.random.Generator], RgbdImage]
_FIELD_PX = 8.0
"""Correlation length of a segmenter's errors along an outline."""
_FIELD_SIGMA_PX = 2.5
"""Their standard deviation; about what is left of an outline that was predicted at a quarter of the resolution."""
_HOLE_FRACTION, _HOLES = 0.2, (0.1, 0.3)
"""How many masks have a hole, and how large it is against their box."""
_TOUCH_PX, _TOUCH_M = 2, 0.25
"""Masks so near in the image and in depth become one."""


def exact(image: RgbdImage, rng: np.random.Generator) -> RgbdImage:
    """Return the image as it is."""
    return image


def grown(image: RgbdImage, rng: np.random.Generator, by_px: int) -> RgbdImage:
    """Return masks that are dilated by some pixels, or eroded where the number is negative."""
    kernel = np.ones((2 * abs(by_px) + 1, 2 * abs(by_px) + 1), np.uint8)
    change = cv2.dilate if by_px > 0 else cv2.erode

    return _with_masks(image, [change(_bytes(item), kernel, borderValue=0).astype(bool) for item in _masks(image)])


def segmented(image: RgbdImage, rng: np.random.Generator) -> RgbdImage:
    """Return masks as a segmenter gives them: outlines that wander by some pixels, now and then a hole."""
    return _with_masks(image, [_wandering(mask, rng) for mask in _masks(image)])


def merged(image: RgbdImage, rng: np.random.Generator) -> RgbdImage:
    """Return masks that hold each touching neighbour, too, as semantic segmentation gives them."""
    masks = _masks(image)
    depths = [_median_depth(image, mask) for mask in masks]
    kernel = np.ones((2 * _TOUCH_PX + 1,) * 2, np.uint8)
    found = []
    for mask, depth in zip(masks, depths, strict=True):
        near = cv2.dilate(_bytes(mask), kernel).astype(bool)
        touching = [
            other
            for other, there in zip(masks, depths, strict=True)
            if abs(there - depth) <= _TOUCH_M and (near & other).any()
        ]
        found.append(np.logical_or.reduce([mask, *touching]))
    return _with_masks(image, found)


def boxed(image: RgbdImage, rng: np.random.Generator) -> RgbdImage:
    """Return boxes in place of masks."""
    found = []
    for item, mask in zip(image.detections, _masks(image), strict=True):
        v, u = np.nonzero(mask)
        box = float(u.min()), float(v.min()), float(u.max()), float(v.max())
        found.append(replace(item, mask=None, box_xyxy=box))
    return replace(image, detections=tuple(found))


def unnamed(image: RgbdImage, rng: np.random.Generator) -> RgbdImage:
    """Return detections that do not say of which object they are."""
    return replace(image, detections=tuple(replace(item, model=None) for item in image.detections))


MASK_ERRORS: dict[str, Disturb] = {
    "exact": exact,
    "eroded by 1 px": partial(grown, by_px=-1),
    "dilated by 1 px": partial(grown, by_px=1),
    "eroded by 3 px": partial(grown, by_px=-3),
    "dilated by 3 px": partial(grown, by_px=3),
    "as of a segmenter": segmented,
    "touching merged": merged,
    "boxes only": boxed,
}
"""Those that keep the name of the object, in the order of the tables."""


def _masks(image: RgbdImage) -> list[Bool[np.ndarray, "h w"]]:
    return [item.pixels(*image.depth.shape) for item in image.detections]


def _with_masks(image: RgbdImage, masks: list[Bool[np.ndarray, "h w"]]) -> RgbdImage:
    """Return the image with other masks; one that is left empty keeps the old one, as its detection is one."""
    pairs = zip(image.detections, masks, strict=True)
    found: list[Detection] = [replace(item, mask=mask if mask.any() else item.mask) for item, mask in pairs]
    return replace(image, detections=tuple(found))


def _bytes(mask: Bool[np.ndarray, "h w"]) -> np.ndarray:
    return np.ascontiguousarray(mask).view(np.uint8)


def _median_depth(image: RgbdImage, mask: Bool[np.ndarray, "h w"]) -> float:
    seen = image.depth[mask & (image.depth > 0)]
    return float(np.median(seen)) if seen.size else np.inf


def _wandering(mask: Bool[np.ndarray, "h w"], rng: np.random.Generator) -> Bool[np.ndarray, "h w"]:
    v, u = np.nonzero(mask)
    margin = int(6 * _FIELD_SIGMA_PX)
    top, left = max(int(v.min()) - margin, 0), max(int(u.min()) - margin, 0)
    window = np.s_[top : int(v.max()) + margin + 1, left : int(u.max()) + margin + 1]
    inside = mask[window]
    outline = _distance(inside) - _distance(~inside)
    found = outline + _FIELD_SIGMA_PX * _smooth_field(inside.shape, rng) > 0
    if rng.random() < _HOLE_FRACTION:
        found &= ~_hole(inside.shape, (v - top, u - left), rng)
    result = np.zeros_like(mask)
    result[window] = found
    return result


def _distance(mask: Bool[np.ndarray, "h w"]) -> Float[np.ndarray, "h w"]:
    return cv2.distanceTransform(_bytes(mask), cv2.DIST_L2, 5)


def _smooth_field(shape: tuple[int, ...], rng: np.random.Generator) -> Float[np.ndarray, "h w"]:
    """Return correlated normal noise of unit variance."""
    field = cv2.GaussianBlur(rng.standard_normal(shape), (0, 0), _FIELD_PX / 2.0)
    # The sum of squares of a Gaussian kernel is 1 / (4 pi sigma^2).
    return field * np.sqrt(4.0 * np.pi) * _FIELD_PX / 2.0


def _hole(
    shape: tuple[int, ...], pixels: tuple[np.ndarray, np.ndarray], rng: np.random.Generator
) -> Bool[np.ndarray, "h w"]:
    """Return an ellipse about one of the pixels, its axes a fraction of those of their box."""
    v, u = pixels
    chosen = int(rng.integers(len(v)))
    half = [max(np.ptp(axis) * rng.uniform(*_HOLES) / 2.0, 1.0) for axis in (v, u)]
    rows, columns = np.ogrid[: shape[0], : shape[1]]
    return ((rows - v[chosen]) / half[0]) ** 2 + ((columns - u[chosen]) / half[1]) ** 2 <= 1.0


def focal_off(image: RgbdImage, rng: np.random.Generator, percent: float) -> RgbdImage:
    """Return focal lengths that are so many percent too long: all seems narrower than it is."""
    camera, factor = image.camera, 1.0 + percent / 100.0
    return replace(image, camera=replace(camera, fx=factor * camera.fx, fy=factor * camera.fy))


def centre_off(image: RgbdImage, rng: np.random.Generator, by_px: float) -> RgbdImage:
    """Return a principal point that lies so many pixels to the right."""
    return replace(image, camera=replace(image.camera, cx=image.camera.cx + by_px))


def depth_off(image: RgbdImage, rng: np.random.Generator, percent: float) -> RgbdImage:
    """Return depth that reads so many percent too far."""
    return replace(image, depth=image.depth * np.float32(1.0 + percent / 100.0))


def unregistered(image: RgbdImage, rng: np.random.Generator, by_px: int) -> RgbdImage:
    """Return colour and all that was found in it so many pixels right and down against depth.

    So it is where the place of the colour camera beside the depth camera is wrong.
    """
    found = []
    for item in image.detections:
        box = item.box_xyxy
        moved = None if box is None else (box[0] + by_px, box[1] + by_px, box[2] + by_px, box[3] + by_px)
        mask = None if item.mask is None else _shifted(np.asarray(item.mask, dtype=bool), by_px)
        # Of an object at the rim that leaves the image nothing else is left to say.
        found.append(replace(item, mask=item.mask if mask is not None and not mask.any() else mask, box_xyxy=moved))
    rgb = None if image.rgb is None else _shifted(image.rgb, by_px)
    return replace(image, detections=tuple(found), rgb=rgb)


def pitched(image: RgbdImage, rng: np.random.Generator, by_deg: float) -> RgbdImage:
    """Return a camera that is believed to look so many degrees higher than it does: gravity and place turn."""
    turn = make_transform(rotation_x(np.deg2rad(by_deg)))
    gravity = None if image.gravity is None else turn[:3, :3].T @ image.gravity
    place = None if image.T_world_camera is None else image.T_world_camera @ turn
    return replace(image, gravity=gravity, T_world_camera=place)


CAMERA_ERRORS: dict[str, Disturb] = {
    "focal length +0.5 %": partial(focal_off, percent=0.5),
    "focal length +2 %": partial(focal_off, percent=2.0),
    "principal point +2 px": partial(centre_off, by_px=2.0),
    "principal point +8 px": partial(centre_off, by_px=8.0),
    "depth +0.5 %": partial(depth_off, percent=0.5),
    "depth +2 %": partial(depth_off, percent=2.0),
    "registration 2 px": partial(unregistered, by_px=2),
    "registration 6 px": partial(unregistered, by_px=6),
    "pitch 1 deg": partial(pitched, by_deg=1.0),
    "pitch 3 deg": partial(pitched, by_deg=3.0),
}
"""In the order of the tables."""


def _shifted(values: Bool[np.ndarray, "h w *c"], by_px: int) -> Bool[np.ndarray, "h w *c"]:
    """Return an image moved right and down; what comes in is zero."""
    moved = np.zeros_like(values)
    moved[by_px:, by_px:] = values[: values.shape[0] - by_px, : values.shape[1] - by_px]
    return moved


UNNAMED = "class unknown"
DISTURBANCES: dict[str, Disturb] = MASK_ERRORS | {UNNAMED: unnamed} | CAMERA_ERRORS


def disturbance(name: str) -> Disturb:
    """Return what does it.

    Raises:
        UnknownNameError: There is none of that name.
    """
    if name not in DISTURBANCES:
        raise UnknownNameError("disturbance", name, list(DISTURBANCES))
    return DISTURBANCES[name]
