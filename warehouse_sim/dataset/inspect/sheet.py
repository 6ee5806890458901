"""Contact sheet of a dataset: of some images what they show, and how their labels lie on it."""

from collections.abc import Sequence
from dataclasses import replace

import cv2
import numpy as np

from warehouse_sim.dataset.cloud_overlay import draw_cloud
from warehouse_sim.dataset.inspect.captions import Captions
from warehouse_sim.dataset.inspect.oddities import Oddities, place_of
from warehouse_sim.dataset.inspect.survey import class_of, distance_of
from warehouse_sim.dataset.overlay import Color, Image, colorize_depth, colorize_ids, draw_box_3d, draw_caption
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.records import ImageRecord, TargetRecord
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.schema import LidarScan, MountedReading

_WIDTH, _MOST_SCALE = 800, 2.0
_DARK, _GAP = 18, 4
_SPARSE = 0.2
"""Share of pixels with a reading below which depth is drawn with larger dots."""


def dataset_sheet(reader: DatasetReader, images: Sequence[ImageRecord], oddities: Oddities) -> Image:
    """Return two rows an image: boxes of poses, masks with 2D boxes; depth, LiDAR's points where there are any.

    What a dataset does not have has no panel.

    Args:
        reader: The dataset.
        images: Which images.
        oddities: Takes what is odd about the images that are drawn.
    """
    panels = [_panels(reader, image, oddities) for image in images]
    rows = [row for found in panels for row in (found[:2], found[2:]) if row]
    width = max(panel.shape[1] for row in rows for panel in row) + _GAP
    return np.concatenate([_strip(row, width) for row in rows])


def _strip(row: list[Image], width: int) -> Image:
    strip = np.full((max(panel.shape[0] for panel in row) + _GAP, 2 * width, 3), _DARK, np.uint8)
    for number, panel in enumerate(row):
        strip[: panel.shape[0], number * width : number * width + panel.shape[1]] = panel
    return strip


def _panels(reader: DatasetReader, image: ImageRecord, oddities: Oddities) -> list[Image]:
    try:
        rgb = reader.rgb(image)
    except DatasetError as problem:
        oddities.note("images that cannot be read", str(problem))
        return [_blank(image, "no image")]
    scale = min(_WIDTH / rgb.shape[1], _MOST_SCALE)
    camera = _scaled(image.camera, scale)
    small = _resized(rgb, scale)
    masks = _masks(reader, image, oddities)
    panels = [
        _posed(reader, image, small.copy(), camera),
        _masked(reader, image, small.copy(), masks, scale),
    ]
    depth = _depth(reader, image, masks, scale, oddities)
    panels += [] if depth is None else [depth]
    sweep = _sweep(reader, image, oddities)
    if sweep is not None:
        cloud = draw_cloud(small, camera, sweep.T_camera_sensor, sweep.reading.points)
        draw_caption(cloud, f"LiDAR, {len(sweep.reading.points):,} points")
        panels.append(cloud)
    return panels


def _posed(reader: DatasetReader, image: ImageRecord, panel: Image, camera: PinholeCamera) -> Image:
    captions, drawn = Captions(panel), 0
    for target in _near_first(image):
        size = _size(reader, target)
        distance = distance_of(target)
        if size is None or distance is None:
            continue
        color = _color(target.gt_index)
        draw_box_3d(panel, camera, target.T_camera_object, size, color)
        drawn += 1
        if target.T_camera_object[2, 3] > 0:
            u, v = camera.project(target.T_camera_object[None, :3, 3])[0]
            captions.add(f"{class_of(target, reader)} {distance:.1f} m", (u, v), color)
    captions.draw()
    what = f"{drawn} boxes of poses" if drawn else "no poses"
    draw_caption(panel, f"{place_of(image)}: {what}")
    return panel


def _masked(
    reader: DatasetReader, image: ImageRecord, panel: Image, masks: dict[int, np.ndarray], scale: float
) -> Image:
    captions = Captions(panel)
    far_first = [target.gt_index for target in _near_first(image)[::-1]]
    for index in (index for index in far_first if index in masks):
        inside = _resized(masks[index].astype(np.uint8), scale) > 0
        panel[inside] = (0.5 * panel[inside] + 0.5 * np.array(_color(index))).astype(np.uint8)
    for target in _near_first(image):
        color = _color(target.gt_index)
        left, top, right, bottom = np.array(target.box_visible_xyxy) * scale
        # From the outer border of the first pixel to that of the last one.
        corners = np.array([[left, top], [right + scale, bottom + scale]]) - 0.5
        first, last = np.round(np.clip(corners, -1e4, 1e4)).astype(int).tolist()
        cv2.rectangle(panel, first, last, color, 1)
        share = f" {100 * target.visible_fraction:.0f} %" if 0 <= target.visible_fraction <= 1 else ""
        captions.add(f"{class_of(target, reader)}{share}", (float(corners[0, 0]), float(corners[0, 1])), color)
    captions.draw()
    draw_caption(panel, f"{len(masks)} visible masks, {len(image.targets)} boxes")
    return panel


def _depth(
    reader: DatasetReader, image: ImageRecord, masks: dict[int, np.ndarray], scale: float, oddities: Oddities
) -> Image | None:
    try:
        depth = reader.depth(image)
    except DatasetError:
        return None
    oddities.of_depth(image, depth)
    for target in image.targets:
        if target.gt_index in masks and masks[target.gt_index].shape == depth.shape:
            diameter = _diameter(reader, target)
            oddities.of_reading(image, target, depth[masks[target.gt_index]], diameter)
    valid = depth[depth > 0]
    near, far = (float(x) for x in np.percentile(valid, [1, 99])) if valid.size else (0.5, 20.0)
    near = max(near, 1e-3)
    colors = colorize_depth(depth, near, max(far, 1.01 * near))
    if valid.size < _SPARSE * depth.size:
        colors = cv2.dilate(colors, np.ones((3, 3), np.uint8))
    panel = _resized(colors, scale, sharp=True)
    draw_caption(panel, f"depth {near:.2f} - {far:.2f} m, {valid.size / depth.size:.0%} of pixels")
    return panel


def _masks(reader: DatasetReader, image: ImageRecord, oddities: Oddities) -> dict[int, np.ndarray]:
    found = {}
    for index in (target.gt_index for target in image.targets):
        try:
            mask = reader.mask_visible(image, index)
        except DatasetError as problem:
            oddities.note("masks that cannot be read", str(problem))
            continue
        if mask.any():
            found[index] = mask
        else:
            oddities.note("empty masks", f"{place_of(image)}, mask {index}")
    return found


def _sweep(reader: DatasetReader, image: ImageRecord, oddities: Oddities) -> MountedReading[LidarScan] | None:
    try:
        return reader.sweep(image)
    except DatasetError as problem:
        oddities.note("sweeps that cannot be read", str(problem))
        return None


def _size(reader: DatasetReader, target: TargetRecord) -> np.ndarray | None:
    try:
        size = target.info(reader.objects).size
    except KeyError:
        return None
    return size if np.any(size > 0) else None


def _diameter(reader: DatasetReader, target: TargetRecord) -> float:
    try:
        return target.info(reader.objects).diameter
    except KeyError:
        return 0.0


def _near_first(image: ImageRecord) -> list[TargetRecord]:
    return sorted(image.targets, key=lambda item: distance_of(item) or 0.0)


def _color(index: int) -> Color:
    red, green, blue = colorize_ids(np.array([[index + 1]], np.int32))[0, 0].tolist()
    return red, green, blue


def _scaled(camera: PinholeCamera, scale: float) -> PinholeCamera:
    """Return the camera of an image that is resized; pixel centres stay integers."""
    return replace(
        camera,
        width=round(camera.width * scale),
        height=round(camera.height * scale),
        fx=camera.fx * scale,
        fy=camera.fy * scale,
        cx=(camera.cx + 0.5) * scale - 0.5,
        cy=(camera.cy + 0.5) * scale - 0.5,
    )


def _resized(image: np.ndarray, scale: float, sharp: bool = False) -> np.ndarray:
    size = max(round(image.shape[1] * scale), 1), max(round(image.shape[0] * scale), 1)
    how = cv2.INTER_NEAREST if sharp or image.ndim == 2 else cv2.INTER_AREA if scale < 1 else cv2.INTER_LINEAR
    return cv2.resize(image, size, interpolation=how)


def _blank(image: ImageRecord, text: str) -> Image:
    scale = min(_WIDTH / image.camera.width, _MOST_SCALE)
    size = max(round(image.camera.height * scale), 40), max(round(image.camera.width * scale), 200)
    panel = np.full((*size, 3), _DARK, np.uint8)
    draw_caption(panel, f"{place_of(image)}: {text}")
    return panel
