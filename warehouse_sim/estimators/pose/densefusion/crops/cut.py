"""Cut each target of an image out as a fixed number of points and a square crop of colour and depth."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
from jaxtyping import Bool, Float, Float32, Int32, UInt8

from warehouse_sim.dataset.records import ImagePixels, ImageRecord, TargetRecord
from warehouse_sim.estimators.gravity import Direction, down_if_placed
from warehouse_sim.estimators.pose.densefusion.crops.surround import Surroundings, Window, surroundings
from warehouse_sim.estimators.pose.densefusion.settings import CropConfig
from warehouse_sim.estimators.pose.fitting.verification import DepthView
from warehouse_sim.geometry.boxes import mask_box_xyxy
from warehouse_sim.geometry.camera import PinholeCamera


@dataclass(frozen=True, eq=False)
class Crop:
    """One target of one image, ready for a network."""

    scene_id: int
    image_id: int
    position: int
    """Number among the image's labels or detections."""
    obj_id: int
    T_camera_object: Float[np.ndarray, "4 4"]
    points: Float32[np.ndarray, "p 3"]
    """Back-projected pixels of the mask in the camera frame (m), in random order."""
    border_px: UInt8[np.ndarray, " p"]
    """Distance of each point's pixel to the border of the mask, 1 = on it."""
    pixel: Int32[np.ndarray, " p"]
    """Row-major index into the square crop of each point's pixel; zero without a square crop."""
    rgb: UInt8[np.ndarray, "s s 3"] | None = None
    depth: Float32[np.ndarray, "s s"] | None = None
    """Metres along z, 0 = no reading."""
    ray_map: Float[np.ndarray, "2 3"] | None = None
    """Maps (column, row, 1) of the depth crop's pixels to their rays (x / z, y / z)."""
    down: Direction | None = None
    """Gravity, a unit vector in the camera frame; None if unknown."""
    around: Surroundings | None = None
    """What is known of points that need not be the object's; None where all are pixels of the mask."""
    view: DepthView | None = None
    """The image that it is cut out of, for what judges poses by it; None in training."""
    bonus: float = 0.0
    """What the detection says for this object, in units of the verification, <= 0."""

    @property
    def masked_points(self) -> Float32[np.ndarray, "q 3"]:
        """Those of the points that the mask holds."""
        return self.points if self.around is None else self.points[self.around.signed_px > 0]


class CropLabel(NamedTuple):
    """Which object of which image a crop shows, as the first fields of ``Crop`` say it."""

    scene_id: int
    image_id: int
    position: int
    obj_id: int
    T_camera_object: Float[np.ndarray, "4 4"]
    """True pose; the identity if unknown it."""
    down: Direction | None = None
    """Gravity, a unit vector in the camera frame; None if unknown."""


def back_project(
    camera: PinholeCamera, u: Int32[np.ndarray, " n"], v: Int32[np.ndarray, " n"], depth: Float32[np.ndarray, " n"]
) -> Float32[np.ndarray, "n 3"]:
    """Return camera-frame points (m) of pixels with z-depth (m); pixel centres are integers."""
    z = depth.astype(np.float64)[:, None]
    return np.concatenate([camera.tangents_at(u, v) * z, z], axis=-1).astype(np.float32)


def image_crops(reader: ImagePixels, image: ImageRecord, config: CropConfig, seed: int) -> Iterator[Crop]:
    """Yield a crop of each wanted target of ``image``, decoding the image once.

    Args:
        reader: The dataset, or an observation that is in none.
        image: Which image.
        config: How to cut.
        seed: Decides which pixels of large targets are kept, the same for each target whatever the order.
    """
    targets = [target for target in image.targets if target.has_pose and config.min_visible.takes(target)]
    if not targets:
        return
    depth = reader.depth(image)
    rgb = reader.rgb(image) if config.reads_rgb else None
    owners = _owners(reader, image) if config.has_surroundings else None
    for target in targets:
        rng = np.random.default_rng([seed, image.scene_id, image.image_id, target.gt_index])
        mask = reader.mask_visible(image, target.gt_index)
        crop = cut_mask(image.camera, label_of(image, target), mask, depth, rgb, config, rng, owners)
        if crop is not None:
            yield crop


def label_of(image: ImageRecord, target: TargetRecord) -> CropLabel:
    """Return what the labels of a dataset say of one target."""
    T_camera_object = np.asarray(target.T_camera_object, dtype=np.float64)
    down = down_if_placed(image.T_world_camera)
    return CropLabel(image.scene_id, image.image_id, target.gt_index, target.obj_id, T_camera_object, down)


def cut_mask(
    camera: PinholeCamera,
    label: CropLabel,
    mask: Bool[np.ndarray, "h w"],
    depth: Float32[np.ndarray, "h w"],
    rgb: UInt8[np.ndarray, "h w 3"] | None,
    config: CropConfig,
    rng: np.random.Generator,
    owners: Int32[np.ndarray, "h w"] | None = None,
) -> Crop | None:
    """Return the crop of what a mask shows, or None when the sensor sees too few points of it.

    Args:
        camera: Intrinsics.
        label: What it shows.
        mask: Its pixels.
        depth: Metres along the optical axis, 0 = no reading.
        rgb: Colours, where the crop holds any.
        config: How to cut.
        rng: Decides which pixels are kept.
        owners: Position of the label that each pixel truly shows plus 1, 0 for none, for crops with surroundings;
            None if unknown.
    """
    box = mask_box_xyxy(mask)
    if box is None:
        return None
    around: Surroundings | None = None
    if config.has_surroundings:
        kept = surroundings(mask, depth, owners, label.position + 1, box, config, rng)
        if kept is None:
            return None
        u, v, around = kept
        border_px = np.maximum(around.signed_px, 0).astype(np.uint8)
    else:
        inner = _pixels_of(mask, depth, box, config, rng)
        if inner is None:
            return None
        u, v, border_px = inner
    window, side = Window.around(box, config.stored_margin), config.stored_side_px
    return Crop(
        *label[:5],
        back_project(camera, u, v, depth[v, u]),
        border_px,
        pixel=window.index(u, v, side) if side and around is None else np.zeros(len(u), dtype=np.int32),
        rgb=window.cut_rgb(rgb, side) if rgb is not None and side and config.rgb else None,
        depth=window.cut_depth(depth, side) if side and config.depth else None,
        ray_map=window.ray_map(camera, side) if side and config.depth else None,
        down=label.down,
        around=around,
    )


def _pixels_of(
    mask: Bool[np.ndarray, "h w"],
    depth: Float32[np.ndarray, "h w"],
    box_xyxy: tuple[int, int, int, int],
    config: CropConfig,
    rng: np.random.Generator,
) -> tuple[Int32[np.ndarray, " p"], Int32[np.ndarray, " p"], UInt8[np.ndarray, " p"]] | None:
    """Return columns, rows and border distances of pixels of a mask with a reading, or None if they are too few."""
    left, top, right, bottom = box_xyxy
    # One pixel of background all around, so that pixels at the edge of the box have their true border distance.
    inside = np.pad(mask[top : bottom + 1, left : right + 1], 1).astype(np.uint8)
    border = cv2.distanceTransform(inside, cv2.DIST_C, 3)[1:-1, 1:-1]
    v, u = np.nonzero((inside[1:-1, 1:-1] > 0) & (depth[top : bottom + 1, left : right + 1] > 0))
    if len(u) < config.min_points:
        return None
    chosen = rng.permutation(len(u))[: config.stored_points]
    u, v = u[chosen], v[chosen]
    border_px = np.minimum(border[v, u], 255).astype(np.uint8)
    return (u + left).astype(np.int32), (v + top).astype(np.int32), border_px


def _owners(reader: ImagePixels, image: ImageRecord) -> Int32[np.ndarray, "h w"]:
    """Return the position of the label that each pixel shows plus 1, 0 for none."""
    owners = np.zeros((image.camera.height, image.camera.width), dtype=np.int32)
    for target in image.targets:
        if target.pixels_visible > 0:
            owners[reader.mask_visible(image, target.gt_index)] = target.gt_index + 1
    return owners
