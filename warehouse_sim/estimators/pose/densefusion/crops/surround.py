"""What is cut out about an object: the square window of the image, and the points around the mask."""

from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Bool, Float, Float32, Int8, Int16, Int32, UInt8

from warehouse_sim.estimators.pose.densefusion.settings import CropConfig
from warehouse_sim.geometry.camera import PinholeCamera

_RAY_GRID = 5
"""Rows and columns of the rays to which a crop's ray map is fitted."""


@dataclass(frozen=True)
class Window:
    """A square window of an image, possibly reaching beyond it, that is resampled to a crop."""

    left: int
    top: int
    side: int
    """Side in image pixels."""

    @classmethod
    def around(cls, box_xyxy: tuple[int, int, int, int], margin: float) -> "Window":
        """Return the square about a box of inclusive pixel corners."""
        left, top, right, bottom = box_xyxy
        width, height = right - left + 1, bottom - top + 1
        side = int(np.ceil(max(width, height) * (1.0 + 2.0 * margin)))
        return cls(left - (side - width) // 2, top - (side - height) // 2, side)

    def cut_rgb(self, image: UInt8[np.ndarray, "h w 3"], side_px: int) -> UInt8[np.ndarray, "s s 3"]:
        """Return the colours, averaged over each crop pixel; black beyond the image."""
        height, width = image.shape[:2]
        right, bottom = self.left + self.side, self.top + self.side
        inside = image[max(self.top, 0) : min(bottom, height), max(self.left, 0) : min(right, width)]
        missing = max(-self.top, 0), max(bottom - height, 0), max(-self.left, 0), max(right - width, 0)
        whole = cv2.copyMakeBorder(inside, *missing, cv2.BORDER_CONSTANT, value=(0, 0, 0))
        return cv2.resize(whole, (side_px, side_px), interpolation=cv2.INTER_AREA).astype(np.uint8)

    def cut_depth(self, depth: Float32[np.ndarray, "h w"], side_px: int) -> Float32[np.ndarray, "s s"]:
        """Return the reading (m) at the centre of each crop pixel, 0 where there is none.

        Depth is never averaged: between an object and what lies behind it there is no surface.
        """
        height, width = depth.shape
        steps = (2 * np.arange(side_px) + 1) * self.side // (2 * side_px)
        u, v = self.left + steps, self.top + steps
        crop = depth[np.clip(v, 0, height - 1)[:, None], np.clip(u, 0, width - 1)]
        crop[(v < 0) | (v >= height), :] = 0.0
        crop[:, (u < 0) | (u >= width)] = 0.0
        return crop

    def ray_map(self, camera: PinholeCamera, side_px: int) -> Float[np.ndarray, "2 3"]:
        """Return the matrix that maps (column, row, 1) of a crop pixel to its ray (x / z, y / z).

        For a camera without distortion these are the first rows of the inverse of the crop's own intrinsics; with
        distortion they are the best fit over the window.
        """
        height, width = camera.height, camera.width
        # To the outer borders of the pixels that the window and the image share: beyond it a lens says nothing.
        u = np.linspace(max(self.left, 0) - 0.5, min(self.left + self.side, width) - 0.5, _RAY_GRID)
        v = np.linspace(max(self.top, 0) - 0.5, min(self.top + self.side, height) - 0.5, _RAY_GRID)
        u, v = (grid.ravel() for grid in np.meshgrid(u, v))
        # Edges, not centres, scale linearly: a pixel's outer edge lies half a pixel before its centre.
        scale = side_px / self.side
        column, row = (u - self.left + 0.5) * scale - 0.5, (v - self.top + 0.5) * scale - 0.5
        crop_pixels = np.stack([column, row, np.ones_like(row)], axis=-1)
        return np.linalg.lstsq(crop_pixels, camera.tangents_at(u, v), rcond=None)[0].T

    def index(self, u: Int32[np.ndarray, " n"], v: Int32[np.ndarray, " n"], side_px: int) -> Int32[np.ndarray, " n"]:
        """Return the row-major index of the crop pixel that covers each image pixel's centre."""
        column = (2 * (u - self.left) + 1) * side_px // (2 * self.side)
        row = (2 * (v - self.top) + 1) * side_px // (2 * self.side)
        return (row * side_px + column).astype(np.int32)


OUTLINE_SIDE = 80
"""Cells along a side of the map of distances to the outline."""
_TOUCH_PX = 8
"""Other targets that come so near to the mask are kept whole, as far as they lie in the window."""
_MOST_NEIGHBOURS = 15
_LEAST_INSIDE = 128
"""So many pixels of the mask are kept whatever is around it, if it has them."""
_FAR_PX = 127


@dataclass(frozen=True, eq=False)
class Surroundings:
    """What is known of each of a crop's points, some of which are not the object's."""

    signed_px: Int8[np.ndarray, " p"]
    """Distance of each point's pixel to the nearest one on the mask's other side: positive inside, negative outside."""
    belongs: Bool[np.ndarray, " p"]
    """Whether the point is truly the object's; what the mask says if unknown."""
    neighbour: UInt8[np.ndarray, " p"]
    """Which other target it belongs to, numbered 1-15 in this crop; 0 for none."""
    uv: Int16[np.ndarray, "p 2"]
    """Column and row (image pixels) from the upper left pixel of the window."""
    window_px: int
    """Side of the window in image pixels."""
    outline: Int8[np.ndarray, "o o"]
    """``signed_px`` at the centres of a grid of cells over the window."""


def surroundings(
    mask: Bool[np.ndarray, "h w"],
    depth: Float32[np.ndarray, "h w"],
    owners: Int32[np.ndarray, "h w"] | None,
    own: int,
    box_xyxy: tuple[int, int, int, int],
    config: CropConfig,
    rng: np.random.Generator,
) -> tuple[Int32[np.ndarray, " p"], Int32[np.ndarray, " p"], Surroundings] | None:
    """Return columns and rows of the kept pixels in random order, and what is known of them.

    All pixels with a reading in the rim about the mask's box are equally likely to be kept, and those of touching
    targets, so that a mask that is drawn too large over them finds the density of a true one.

    Args:
        mask: Pixels that are said to be the object's.
        depth: Metres along the optical axis, 0 = no reading.
        owners: Which target each pixel shows, 0 for none; None if unknown.
        own: Which of ``owners`` the object is.
        box_xyxy: Inclusive corners of the mask.
        config: How wide the rim is, and how much is kept.
        rng: Source of the choice.

    Returns:
        None where the mask holds too few readings.
    """
    window = Window.around(box_xyxy, config.stored_margin)
    left, top = max(window.left, 0), max(window.top, 0)
    part = np.s_[top : window.top + window.side, left : window.left + window.side]
    inside, reading = mask[part], depth[part] > 0
    if np.count_nonzero(inside & reading) < config.min_points:
        return None
    signed = _signed_distance(inside)
    owner = owners[part] if owners is not None else np.where(inside, own, 0)
    neighbour = _neighbours(owner, own, signed)
    region = (neighbour > 0) | _rim(box_xyxy, (left, top), inside.shape, config)
    v, u = np.nonzero((region | inside) & reading)
    chosen = _choose(inside[v, u], config.stored_points, rng)
    u, v = u[chosen], v[chosen]
    uv = np.stack([u + left - window.left, v + top - window.top], axis=1).astype(np.int16)
    known = Surroundings(
        signed[v, u],
        owner[v, u] == own,
        neighbour[v, u],
        uv,
        window.side,
        _outline(signed, window, (left, top)),
    )
    return (u + left).astype(np.int32), (v + top).astype(np.int32), known


def _signed_distance(inside: Bool[np.ndarray, "h w"]) -> Int8[np.ndarray, "h w"]:
    # What lies beyond the image or the window counts as outside.
    within = cv2.distanceTransform(np.pad(inside, 1).astype(np.uint8), cv2.DIST_L2, 5)[1:-1, 1:-1]
    beyond = cv2.distanceTransform((~inside).astype(np.uint8), cv2.DIST_L2, 5)
    return np.clip(np.rint(np.where(inside, within, -beyond)), -_FAR_PX, _FAR_PX).astype(np.int8)


def _neighbours(owner: Int32[np.ndarray, "h w"], own: int, signed: Int8[np.ndarray, "h w"]) -> UInt8[np.ndarray, "h w"]:
    """Return the numbers of the other targets that come near to the mask, those that touch it most first."""
    found = np.zeros(owner.shape, dtype=np.uint8)
    near = owner[signed >= -_TOUCH_PX]
    names, counts = np.unique(near[(near > 0) & (near != own)], return_counts=True)
    for number, name in enumerate(names[np.argsort(-counts, kind="stable")][:_MOST_NEIGHBOURS], start=1):
        found[owner == name] = number
    return found


def _rim(
    box_xyxy: tuple[int, int, int, int], corner: tuple[int, int], shape: tuple[int, ...], config: CropConfig
) -> Bool[np.ndarray, "h w"]:
    (left, top, right, bottom), (first_u, first_v) = box_xyxy, corner
    rim = config.rim_px(right - left + 1, bottom - top + 1)
    region = np.zeros(shape, dtype=bool)
    region[
        max(top - rim - first_v, 0) : max(bottom + rim + 1 - first_v, 0),
        max(left - rim - first_u, 0) : max(right + rim + 1 - first_u, 0),
    ] = True
    return region


def _choose(inside: Bool[np.ndarray, " n"], most: int, rng: np.random.Generator) -> Int32[np.ndarray, " p"]:
    """Return which pixels are kept, in random order; of a mask that is small against its rim more than its fraction."""
    order = rng.permutation(len(inside))
    chosen, rest = order[:most], order[most:]
    lacking = min(_LEAST_INSIDE, most) - np.count_nonzero(inside[chosen])
    spare = rest[inside[rest]][: max(lacking, 0)]
    if len(spare) == 0:
        return chosen
    others = np.flatnonzero(~inside[chosen])[: len(spare)]
    chosen[others] = spare[: len(others)]
    return rng.permutation(chosen)


def _outline(signed: Int8[np.ndarray, "h w"], window: Window, corner: tuple[int, int]) -> Int8[np.ndarray, "o o"]:
    steps = (2 * np.arange(OUTLINE_SIDE) + 1) * window.side // (2 * OUTLINE_SIDE)
    u, v = steps + window.left - corner[0], steps + window.top - corner[1]
    height, width = signed.shape
    # Beyond the image the outline goes on as at its border.
    return signed[np.clip(v, 0, height - 1)[:, None], np.clip(u, 0, width - 1)]
