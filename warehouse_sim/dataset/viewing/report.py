"""Inspect a dataset: a text that counts and a sheet that shows."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from warehouse_sim.dataset.files.image_io import encode_rgb
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.records import ImageRecord, TargetRecord
from warehouse_sim.dataset.viewing.overlay import Image, colorize_depth, draw_caption, draw_cloud
from warehouse_sim.dataset.viewing.panels import masked_panel, posed_panel, resized, scaled
from warehouse_sim.dataset.viewing.survey import Oddities, place_of, spread, survey
from warehouse_sim.errors import DatasetError
from warehouse_sim.output import make_folder, write_bytes
from warehouse_sim.schema import LidarScan, MountedReading

_WIDTH, _MOST_SCALE = 800, 2.0
_DARK, _GAP = 18, 4
_SPARSE = 0.2
"""Fraction of pixels with a reading below which depth is drawn with larger dots."""


def dataset_sheet(reader: DatasetReader, images: Sequence[ImageRecord], oddities: Oddities) -> Image:
    """Return two rows an image: boxes of poses, masks with 2D boxes; depth, LiDAR's points where there are any.

    What a dataset does not have has no panel; without colours labels are drawn on depth.

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
        rgb = _base(reader, image)
    except DatasetError as problem:
        oddities.note("images that cannot be read", str(problem))
        return [_blank(image, "no image")]
    scale = min(_WIDTH / rgb.shape[1], _MOST_SCALE)
    camera = scaled(image.camera, scale)
    small = resized(rgb, scale)
    masks = _masks(reader, image, oddities)
    panels = [
        posed_panel(reader.objects, image, small.copy(), camera),
        masked_panel(reader.objects, image, small.copy(), masks, scale),
    ]
    depth = _depth(reader, image, masks, scale, oddities)
    panels += [] if depth is None else [depth]
    sweep = _sweep(reader, image, oddities)
    if sweep is not None:
        cloud = draw_cloud(small, camera, sweep.T_camera_sensor, sweep.reading.points)
        draw_caption(cloud, f"LiDAR, {len(sweep.reading.points):,} points")
        panels.append(cloud)
    return panels


def _base(reader: DatasetReader, image: ImageRecord) -> Image:
    """Return what labels are drawn on: the colour image; where it was left out depth, or a dark ground.

    Raises:
        DatasetError: A file that should be there cannot be read.
    """
    if not reader.leaves_out("rgb"):
        return reader.rgb(image)
    if not reader.leaves_out("depth"):
        return colorize_depth(reader.depth(image))
    return np.full((image.camera.height, image.camera.width, 3), _DARK, np.uint8)


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
            oddities.of_reading(image, target, depth, masks[target.gt_index], diameter)
    valid = depth[depth > 0]
    near, far = (float(x) for x in np.percentile(valid, [1, 99])) if valid.size else (0.5, 20.0)
    near = max(near, 1e-3)
    colors = colorize_depth(depth, near, max(far, 1.01 * near))
    if valid.size < _SPARSE * depth.size:
        colors = cv2.dilate(colors, np.ones((3, 3), np.uint8))
    panel = resized(colors, scale, sharp=True)
    draw_caption(panel, f"depth {near:.2f} - {far:.2f} m, {valid.size / depth.size:.0%} of pixels")
    return panel


def _masks(reader: DatasetReader, image: ImageRecord, oddities: Oddities) -> dict[int, np.ndarray]:
    found: dict[int, np.ndarray] = {}
    if reader.leaves_out("masks"):
        return found
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


def _diameter(reader: DatasetReader, target: TargetRecord) -> float:
    try:
        return target.info(reader.objects).diameter
    except KeyError:
        return 0.0


def _blank(image: ImageRecord, text: str) -> Image:
    scale = min(_WIDTH / image.camera.width, _MOST_SCALE)
    size = max(round(image.camera.height * scale), 40), max(round(image.camera.width * scale), 200)
    panel = np.full((*size, 3), _DARK, np.uint8)
    draw_caption(panel, f"{place_of(image)}: {text}")
    return panel


SHEET, TEXT = "contact_sheet.png", "survey.txt"


@dataclass(frozen=True)
class Inspection:
    """What was found."""

    lines: list[str]
    """Counts, histograms and oddities."""
    sheet: Path
    """PNG of some images with their labels."""


def inspect(data: Path, out: Path, count: int = 6, split: str | None = None) -> Inspection:
    """Count what a dataset holds and draw some of its images with their labels.

    Args:
        data: Folder of a dataset in any format that can be read, of this package or a third-party one.
        out: Folder for the sheet and the text.
        count: Images on the sheet, >= 1.
        split: Of which split; all by default.

    Raises:
        DatasetError: The folder cannot be read, or has no such split or no image in it.
    """
    reader, oddities = DatasetReader(data), Oddities()
    found = survey(reader, oddities)
    shown = reader.images(split) if split else list(_all_images(reader))
    if not shown:
        raise DatasetError(f"{data}: has no images" + (f" in the split {split}" if split else ""))
    sheet = dataset_sheet(reader, spread(shown, count), oddities)
    odd = oddities.lines()
    lines = [reader.name, *found.lines(), "", *(["odd:", *(f"  {line}" for line in odd)] if odd else ["nothing odd"])]
    make_folder(out)
    write_bytes(out / SHEET, encode_rgb(sheet))
    write_bytes(out / TEXT, ("\n".join(lines) + "\n").encode("utf-8"))
    return Inspection(lines, out / SHEET)


def _all_images(reader: DatasetReader) -> Iterator[ImageRecord]:
    for split in reader.parts:
        yield from reader.images(split)
