"""The pinhole image that a distorted one is made from, and where in it each pixel looks."""

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache

import cv2
import numpy as np
from jaxtyping import Float, Float32, Int

from warehouse_sim.geometry.camera import PinholeCamera

_MARGIN_PX = 4
"""More than the image needs on each side, for filters."""
_MOST_TAPS = 4
_SHARP = 1.25
"""Source pixels per pixel up to which one tap is enough."""


@dataclass(frozen=True, eq=False)
class LensMap:
    """Of one camera with a lens; see ``lens_map``."""

    camera: PinholeCamera
    source: PinholeCamera
    """A pinhole that sees all that the camera sees, nowhere with fewer pixels than it."""
    place: Float[np.ndarray, "h w 2"]
    """Where in the source each pixel's centre looks (u, v)."""

    @cached_property
    def nearest(self) -> Int[np.ndarray, "h w"]:
        """The source pixel that each pixel looks into, as a number in the flat image."""
        columns, rows = np.moveaxis(self.pixels, -1, 0)
        return rows.astype(np.intp) * self.source.width + columns

    @cached_property
    def pixels(self) -> Int[np.ndarray, "h w 2"]:
        """Column and row of the source pixel that each pixel looks into."""
        return np.floor(self.place + 0.5).astype(np.int32)

    @cached_property
    def off_centre(self) -> Float32[np.ndarray, "h w 2"]:
        """By how much each pixel looks beside that source pixel's centre (u, v), -0.5 to 0.5."""
        return (self.place - self.pixels).astype(np.float32)

    @cached_property
    def taps(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """Places, in OpenCV's fixed-point form, whose mean a pixel's colour is.

        A tap itself gathers one source pixel; where a pixel covers more, several are spread over what it covers beyond.
        """
        spread = []
        for axis in (1, 0):
            way = np.gradient(self.place, axis=axis)
            length = np.hypot(way[..., 0], way[..., 1])[..., None]
            longest = float(length.max())
            count = 1 if longest <= _SHARP else min(math.ceil(longest), _MOST_TAPS)
            beyond = way * np.maximum(1.0 - 1.0 / length, 0.0)
            spread.append([step * beyond for step in (np.linspace(-0.5, 0.5, count) if count > 1 else [0.0])])
        places = [self.place + across + down for down in spread[1] for across in spread[0]]
        return [cv2.convertMaps(place.astype(np.float32), None, cv2.CV_16SC2) for place in places]

    @cached_property
    def canvas(self) -> Float32[np.ndarray, "r c 2"]:
        """Places in the source of every ``CANVAS_STEP``-th pixel of the canvas of 3 x 3 images around the image."""
        width, height = self.camera.width, self.camera.height
        u = np.arange(-width, 2 * width + CANVAS_STEP, CANVAS_STEP)
        v = np.arange(-height, 2 * height + CANVAS_STEP, CANVAS_STEP)
        columns, rows = np.meshgrid(u, v)
        rays = self.camera.rays_at(columns.ravel(), rows.ravel())
        return self.source.project(rays).reshape(*columns.shape, 2).astype(np.float32)


CANVAS_STEP = 8
"""Pixels between the places that are known exactly outside of the image."""


@lru_cache(maxsize=2)
def lens_map(camera: PinholeCamera) -> LensMap:
    """Return the map of a camera with a lens, made once: it takes a few tenths of a second."""
    source = source_camera(camera)
    return LensMap(camera, source, source.project(camera.rays()))


def source_camera(camera: PinholeCamera) -> PinholeCamera:
    """Return a pinhole whose image holds that of ``camera``, and whose 3 x 3 images hold its 3 x 3 images.

    Its focal length is that of the camera times its largest magnification in the image, so that it has at least one
    pixel for each of the camera's in every place and direction. Where the two magnify alike, pixels fall on pixels.
    """
    finer = _largest_magnification(camera)
    fx, fy = finer * camera.fx, finer * camera.fy
    width, height = camera.width, camera.height
    canvas = camera.crop(-width, -height, 3 * width, 3 * height).tangent_bounds()
    left, right, top, bottom = camera.tangent_bounds()
    before_u, after_u = _reach((left * fx, right * fx), (canvas[0] * fx, canvas[1] * fx))
    before_v, after_v = _reach((top * fy, bottom * fy), (canvas[2] * fy, canvas[3] * fy))
    # Whole pixels on both sides of the camera's own principal point.
    cx, cy = camera.cx % 1.0 + before_u, camera.cy % 1.0 + before_v
    return PinholeCamera(before_u + after_u + 1, before_v + after_v + 1, fx, fy, cx, cy)


def _reach(image: tuple[float, float], canvas: tuple[float, float]) -> tuple[int, int]:
    """Return how many pixels an axis needs before and after the principal point.

    Args:
        image: Ends of the image on the axis, from the principal point (px).
        canvas: Ends of the canvas; that of the source reaches one image further on both sides.
    """
    low, high = image
    more = max(0.0, (2.0 * low - high - canvas[0]) / 3.0, (canvas[1] - 2.0 * high + low) / 3.0)
    return math.ceil(more - low) + _MARGIN_PX, math.ceil(more + high) + 1 + _MARGIN_PX


def _largest_magnification(camera: PinholeCamera) -> float:
    """Return the most pixels of the camera's image, in any direction, on a pixel of its pinhole's; at least 1."""
    assert camera.distortion is not None
    scale = np.array([camera.fx, camera.fy])
    local = camera.distortion.jacobian(camera.rays()[::4, ::4, :2]) * scale[:, None] / scale
    return max(1.0, float(np.linalg.norm(local, ord=2, axis=(-2, -1)).max()))
