"""One image that shows everything an observation holds, readings included."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import cv2
import numpy as np

from warehouse_sim.dataset.files.image_io import encode_rgb
from warehouse_sim.dataset.viewing.overlay import (
    Image,
    colorize_depth,
    colorize_instances,
    draw_box_3d,
    draw_caption,
    draw_cloud,
)
from warehouse_sim.generation.observe import observe_scene
from warehouse_sim.generation.recipe import Recipe
from warehouse_sim.generation.scene import prepare_scene
from warehouse_sim.geometry.boxes import box_corners
from warehouse_sim.geometry.pose import invert, transform_points
from warehouse_sim.output import make_folder, write_bytes
from warehouse_sim.render import open_renderer
from warehouse_sim.schema import CAMERA, IMU, LIDAR, LidarScan, MountedReading, Observation, Reading

_BACKGROUND, _BAR, _TEXT = (18, 18, 18), (90, 170, 230), (235, 235, 235)
_LINE_PX = 26
_MOST_BARS = 128


def reading_panels(readings: Mapping[str, MountedReading[Reading]], size: tuple[int, int]) -> dict[str, Image]:
    """Return one panel of ``size`` (rows, columns) for each reading, by its caption."""
    return {
        f"{name}: {', '.join(item.reading.channels)}": _panel(item.reading, size) for name, item in readings.items()
    }


def _panel(reading: Reading, size: tuple[int, int]) -> Image:
    """Return the first channel that is an image with all others in words, or each channel in words over its bars."""
    channels = {name: np.asarray(values) for name, values in reading.channels.items()}
    image = next((values for values in channels.values() if _is_image(values)), None)
    height, width = size
    if image is not None:
        colors = image if image.ndim == 3 else colorize_depth(image)
        return cv2.resize(colors, (width, height), interpolation=cv2.INTER_AREA)
    panel: Image = np.full((height, width, 3), _BACKGROUND, np.uint8)
    rows = max((height - 2 * _LINE_PX) // max(len(channels), 1), 1)
    for number, (name, values) in enumerate(channels.items()):
        top = 2 * _LINE_PX + number * rows
        _write(panel, _in_words(name, values), top)
        _draw_bars(panel[top + 6 : top + rows - _LINE_PX], values)
    return panel


def _is_image(values: np.ndarray[Any, Any]) -> bool:
    plane = values.ndim == 2 and values.dtype.kind == "f" and min(values.shape) > 3
    return plane or (values.ndim == 3 and values.shape[2] == 3 and values.dtype == np.uint8)


def _in_words(name: str, values: np.ndarray[Any, Any]) -> str:
    """Return shape, type and the range of what is finite."""
    text = f"{name}  {' x '.join(map(str, values.shape)) or 'one value'}  {values.dtype}"
    if values.dtype.kind not in "fiub" or values.size == 0:
        return text
    finite = values[np.isfinite(values)]
    missing = "" if finite.size == values.size else f", {values.size - finite.size} not finite"
    return f"{text}  {finite.min():.4g} to {finite.max():.4g}{missing}" if finite.size else f"{text}  nothing finite"


def _draw_bars(area: Image, values: np.ndarray[Any, Any]) -> None:
    """Draw up to ``_MOST_BARS`` numbers of one row as bars over zero; more than one row has no bars."""
    if values.ndim != 1 or values.dtype.kind not in "fiub" or not values.size > 0 or area.shape[0] < 4:
        return
    heights = np.nan_to_num(np.abs(values[:_MOST_BARS].astype(float)), posinf=0.0)
    heights /= max(float(heights.max()), 1e-12)
    step = area.shape[1] / len(heights)
    for number, fraction in enumerate(heights):
        left, right = round(number * step) + 1, max(round((number + 1) * step) - 1, round(number * step) + 2)
        area[area.shape[0] - round(fraction * area.shape[0]) :, left:right] = _BAR


def _write(panel: Image, text: str, bottom: int) -> None:
    cv2.putText(panel, text, (8, bottom), cv2.FONT_HERSHEY_SIMPLEX, 0.5, _TEXT, 1, cv2.LINE_AA)


BOX_COLOR = (60, 230, 90)
FOOTPRINT = [0, 2, 6, 4]
"""Corners of the lower face, in order around it."""
BEV_RANGE = 18.0
"""Metres shown from left to right in the view from above."""


def render_contact_sheet(
    recipe: Recipe,
    seed: int,
    scene_index: int,
    out: Path,
    backend: str = "raster",
    backend_options: Mapping[str, Any] = MappingProxyType({}),
) -> None:
    """Render the first observation of a scene and write its contact sheet as PNG.

    Args:
        recipe: What to draw from.
        seed: Seed of the dataset.
        scene_index: Which scene.
        out: PNG file.
        backend: Render backend.
        backend_options: Its options, see ``render.option_settings``.
    """
    prepared, rig = prepare_scene(recipe, seed, scene_index), recipe.sensors
    if "rgb" not in rig.wanted:  # most panels are drawn on the image
        rig = replace(rig, outputs=("rgb", *rig.wanted))
    with open_renderer(backend, **backend_options) as renderer:
        observation = next(observe_scene(prepared.scene, rig, renderer, prepared.variants[:1]))
    make_folder(out.parent)
    write_bytes(out, encode_rgb(contact_sheet(observation)))


def contact_sheet(observation: Observation) -> Image:
    """Return captioned panels in two columns: RGB, depth, instance masks, boxes, LiDAR from above and in the image.

    The second camera, LiDARs beside the main one and sensors of any other kind follow, one panel each; a sensor that
    the rig does not have has none.
    """
    rgb = observation.rgbd.rgb
    visible = [item for item in observation.annotations if item.pixels_visible > 0]
    panels = {
        "RGB": rgb.copy(),
        "depth as the sensor reads it, 0.5-20 m": colorize_depth(observation.rgbd.depth),
        "instance mask": colorize_instances(observation.buffers.instance_mask),
        f"boxes of {len(visible)} visible targets": _boxes(observation),
    }
    if observation.lidar is not None:
        panels["LiDAR from above"] = _lidar_from_above(observation, observation.lidar)
        panels["LiDAR in the image"] = draw_cloud(
            rgb, observation.camera, observation.T_camera_lidar, observation.lidar.points
        )
    shown = (CAMERA, LIDAR, IMU)  # six numbers are no picture
    panels |= reading_panels({k: v for k, v in observation.readings.items() if k not in shown}, rgb.shape[:2])
    if len(panels) % 2:
        panels[""] = np.full_like(rgb, 18)
    for caption, panel in panels.items():
        draw_caption(panel, caption)
    left, right = list(panels.values())[::2], list(panels.values())[1::2]
    return np.concatenate([np.concatenate(left), np.concatenate(right)], axis=1)


def _boxes(observation: Observation) -> Image:
    image = observation.rgbd.rgb.copy()
    for item in observation.annotations:
        if item.visible_fraction >= 0.1:
            draw_box_3d(image, observation.camera, item.T_camera_object, item.size, BOX_COLOR)
    return image


def _lidar_from_above(observation: Observation, scan: LidarScan) -> Image:
    image = np.full_like(observation.rgbd.rgb, 18)
    height, width, _ = image.shape
    # The sensor stands near the left edge and looks to the right.
    scale, origin = width / BEV_RANGE, np.array([width // 10, height // 2])
    pixels = np.round(scan.points[:, :2] * [scale, -scale]).astype(int) + origin
    inside = ((pixels >= 0) & (pixels < [width, height])).all(axis=1)
    image[pixels[inside, 1], pixels[inside, 0]] = colorize_instances(scan.instance_ids[None])[0][inside]
    T_lidar_camera = invert(observation.T_camera_lidar)
    for item in observation.annotations:
        corners = transform_points(T_lidar_camera @ item.T_camera_object, box_corners(item.size)[FOOTPRINT])
        outline = np.round(corners[:, :2] * [scale, -scale]).astype(np.int32) + origin.astype(np.int32)
        cv2.polylines(image, [outline], True, BOX_COLOR, 1, cv2.LINE_AA)
    cv2.drawMarker(image, origin.tolist(), (255, 255, 255), cv2.MARKER_CROSS, 12, 2)
    return image
