"""Cut each target of an image out as a fixed number of points and a square colour crop."""

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Bool, Float, Float32, Int32, UInt8

from warehouse_sim.dataset.reader import DatasetReader, ImageRecord, TargetRecord
from warehouse_sim.geometry.camera import PinholeCamera


@dataclass(frozen=True)
class CropConfig:
    """How targets are cut out of images."""

    side_px: int | None = None
    """Side of the square colour crop in pixels; none when the network reads no colour."""
    stored_points: int = 1024
    """Most points kept of one target, >= 1; each training step draws its own from them."""
    min_points: int = 32
    """Targets with fewer depth readings are left out, >= 1."""
    min_visible_fraction: float = 0.1
    """Targets less visible than this are left out, 0-1."""
    margin: float = 0.1
    """Space around the mask in the colour crop, as a share of its longer side, >= 0."""


@dataclass(frozen=True, eq=False)
class Crop:
    """One target of one image, ready for a network."""

    scene_id: int
    image_id: int
    gt_index: int
    obj_id: int
    T_camera_object: Float[np.ndarray, "4 4"]
    points: Float32[np.ndarray, "p 3"]
    """Back-projected pixels of the mask in the camera frame (m), in random order."""
    border_px: UInt8[np.ndarray, " p"]
    """Distance of each point's pixel to the border of the mask, 1 = on it."""
    pixel: Int32[np.ndarray, " p"]
    """Row-major index into the colour crop of each point's pixel; zero without a colour crop."""
    rgb: UInt8[np.ndarray, "s s 3"] | None


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

    def cut(self, image: UInt8[np.ndarray, "h w 3"], side_px: int) -> UInt8[np.ndarray, "s s 3"]:
        """Return the window resampled to ``side_px``; black beyond the image."""
        height, width = image.shape[:2]
        right, bottom = self.left + self.side, self.top + self.side
        inside = image[max(self.top, 0) : min(bottom, height), max(self.left, 0) : min(right, width)]
        missing = max(-self.top, 0), max(bottom - height, 0), max(-self.left, 0), max(right - width, 0)
        whole = cv2.copyMakeBorder(inside, *missing, cv2.BORDER_CONSTANT, value=(0, 0, 0))
        return cv2.resize(whole, (side_px, side_px), interpolation=cv2.INTER_AREA).astype(np.uint8)

    def index(self, u: Int32[np.ndarray, " n"], v: Int32[np.ndarray, " n"], side_px: int) -> Int32[np.ndarray, " n"]:
        """Return the row-major index of the crop pixel that covers each image pixel's centre."""
        column = (2 * (u - self.left) + 1) * side_px // (2 * self.side)
        row = (2 * (v - self.top) + 1) * side_px // (2 * self.side)
        return (row * side_px + column).astype(np.int32)


def back_project(
    camera: PinholeCamera, u: Int32[np.ndarray, " n"], v: Int32[np.ndarray, " n"], depth: Float32[np.ndarray, " n"]
) -> Float32[np.ndarray, "n 3"]:
    """Return camera-frame points (m) of pixels with z-depth (m); pixel centres are integers."""
    z = depth.astype(np.float64)
    x, y = (u - camera.cx) / camera.fx * z, (v - camera.cy) / camera.fy * z
    return np.stack([x, y, z], axis=-1).astype(np.float32)


def wanted_targets(image: ImageRecord, config: CropConfig) -> list[TargetRecord]:
    """Return the targets of ``image`` that are visible enough to be estimated."""
    return [
        target
        for target in image.targets
        if target.visible_fraction >= config.min_visible_fraction and target.pixels_visible >= config.min_points
    ]


def image_crops(reader: DatasetReader, image: ImageRecord, config: CropConfig, seed: int) -> Iterator[Crop]:
    """Yield a crop of each wanted target of ``image``, decoding the image once.

    Args:
        reader: The dataset.
        image: Which image.
        config: How to cut.
        seed: Decides which pixels of large targets are kept, the same for each target whatever the order.
    """
    targets = wanted_targets(image, config)
    if not targets:
        return
    depth = reader.depth(image)
    rgb = reader.rgb(image) if config.side_px else None
    for target in targets:
        rng = np.random.default_rng([seed, image.scene_id, image.image_id, target.gt_index])
        crop = cut_target(image, target, reader.mask_visible(image, target.gt_index), depth, rgb, config, rng)
        if crop is not None:
            yield crop


def cut_target(
    image: ImageRecord,
    target: TargetRecord,
    mask: Bool[np.ndarray, "h w"],
    depth: Float32[np.ndarray, "h w"],
    rgb: UInt8[np.ndarray, "h w 3"] | None,
    config: CropConfig,
    rng: np.random.Generator,
) -> Crop | None:
    """Return the crop of one target, or None when the sensor sees too few points of it."""
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    if rows.size == 0:
        return None
    top, bottom, left, right = int(rows[0]), int(rows[-1]), int(columns[0]), int(columns[-1])
    # One pixel of background all around, so that pixels at the edge of the box have their true border distance.
    inside = np.pad(mask[top : bottom + 1, left : right + 1], 1).astype(np.uint8)
    border = cv2.distanceTransform(inside, cv2.DIST_C, 3)[1:-1, 1:-1]
    v, u = np.nonzero((inside[1:-1, 1:-1] > 0) & (depth[top : bottom + 1, left : right + 1] > 0))
    if len(u) < config.min_points:
        return None
    chosen = rng.permutation(len(u))[: config.stored_points]
    u, v = u[chosen], v[chosen]
    border_px = np.minimum(border[v, u], 255).astype(np.uint8)
    u, v = (u + left).astype(np.int32), (v + top).astype(np.int32)
    window = Window.around((left, top, right, bottom), config.margin)
    return Crop(
        image.scene_id,
        image.image_id,
        target.gt_index,
        target.obj_id,
        np.asarray(target.T_camera_object, dtype=np.float64),
        back_project(image.camera, u, v, depth[v, u]),
        border_px,
        window.index(u, v, config.side_px) if config.side_px else np.zeros(len(u), dtype=np.int32),
        window.cut(rgb, config.side_px) if rgb is not None and config.side_px else None,
    )
