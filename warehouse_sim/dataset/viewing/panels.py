"""An image with its labels on it: boxes of poses, visible masks with 2D boxes, or all of it in one picture."""

from collections.abc import Mapping
from dataclasses import replace

import cv2
import numpy as np
from jaxtyping import Bool

from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.dataset.records import ImageRecord, TargetRecord
from warehouse_sim.dataset.viewing.overlay import Color, Image, colorize_instances, draw_box_3d, draw_caption
from warehouse_sim.dataset.viewing.survey import class_of, distance_of, place_of
from warehouse_sim.geometry.camera import PinholeCamera

_FONT, _SCALE = cv2.FONT_HERSHEY_SIMPLEX, 0.42
_TRIES = (0, -1, 1, -2, 2, -3, 3)
"""Line heights by which a text is moved until it is free."""


class Captions:
    """Texts for an image, the most important first.

    Args:
        image: Where they are drawn, in place.
    """

    def __init__(self, image: Image) -> None:
        self._image = image
        self._placed: list[tuple[str, tuple[int, int, int, int], Color]] = []

    def add(self, text: str, place: tuple[float, float], color: Color) -> None:
        """Find room for a text at ``place`` (px), or near it; where there is none it is left out."""
        (width, height), _ = cv2.getTextSize(text, _FONT, _SCALE, 1)
        width, height = width + 4, height + 6
        rows, columns = self._image.shape[:2]
        if not (-width < place[0] < columns + width and -height < place[1] < rows + height):
            return
        left = int(np.clip(place[0], 0, max(columns - width, 0)))
        for move in _TRIES:
            top = int(np.clip(place[1] - height / 2 + move * height, 0, max(rows - height, 0)))
            box = left, top, left + width, top + height
            if not any(_overlap(box, other) for _, other, _ in self._placed):
                self._placed.append((text, box, color))
                return

    def draw(self) -> None:
        """Draw them on dark bands in their colours."""
        for text, (left, top, right, bottom), color in self._placed:
            self._image[top:bottom, left:right] //= 4
            bright = tuple(int(128 + channel / 2) for channel in color)
            cv2.putText(self._image, text, (left + 2, bottom - 4), _FONT, _SCALE, bright, 1, cv2.LINE_AA)


def _overlap(a: tuple[int, int, int, int], b: tuple[int, int, int, int]) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


Objects = Mapping[int, ObjectInfo]
Masks = Mapping[int, Bool[np.ndarray, "h w"]]
"""Visible masks by position among the image's labels."""
_LEAST_EDGE, _MOST_SCALE = 640, 4


def labelled_picture(objects: Objects, image: ImageRecord, picture: Image, masks: Masks) -> Image:
    """Return a copy of an image with all its labels: coloured masks, boxes in space, class, distance, visible fraction.

    Labels without a pose have the box of their visible part. Small images are enlarged.

    Args:
        objects: The CAD geometries by obj_id.
        image: Camera and labels.
        picture: The image, or what stands for it, in its size.
        masks: Visible masks; a label without one has no colour.
    """
    scale = float(min(max(1, -(-_LEAST_EDGE // max(picture.shape[:2]))), _MOST_SCALE))
    panel, camera = resized(picture, scale).copy(), scaled(image.camera, scale)
    tint(image, panel, masks, scale)
    captions = Captions(panel)
    for target in near_first(image):
        color, size, distance = label_color(target.gt_index), size_of(objects, target), distance_of(target)
        what = [class_of(target, objects)]
        place = draw_box_2d(panel, target, scale, color) if size is None or distance is None else None
        if size is not None and distance is not None:
            draw_box_3d(panel, camera, target.T_camera_object, size, color)
            what.append(f"{distance:.1f} m")
            if target.T_camera_object[2, 3] > 0:
                u, v = camera.project(target.T_camera_object[None, :3, 3])[0]
                place = float(u), float(v)
        if 0 <= target.visible_fraction <= 1:
            what.append(f"{100 * target.visible_fraction:.0f} %")
        if place is not None:
            captions.add(" ".join(what), place, color)
    captions.draw()
    draw_caption(panel, f"{place_of(image)}: {len(image.targets)} labels")
    return panel


def posed_panel(objects: Objects, image: ImageRecord, panel: Image, camera: PinholeCamera) -> Image:
    """Draw the boxes of the poses into ``panel``, with class and distance, and return it."""
    captions, drawn = Captions(panel), 0
    for target in near_first(image):
        size = size_of(objects, target)
        distance = distance_of(target)
        if size is None or distance is None:
            continue
        color = label_color(target.gt_index)
        draw_box_3d(panel, camera, target.T_camera_object, size, color)
        drawn += 1
        if target.T_camera_object[2, 3] > 0:
            u, v = camera.project(target.T_camera_object[None, :3, 3])[0]
            captions.add(f"{class_of(target, objects)} {distance:.1f} m", (u, v), color)
    captions.draw()
    what = f"{drawn} boxes of poses" if drawn else "no poses"
    draw_caption(panel, f"{place_of(image)}: {what}")
    return panel


def masked_panel(objects: Objects, image: ImageRecord, panel: Image, masks: Masks, scale: float) -> Image:
    """Draw visible masks and 2D boxes into ``panel``, with class and visible fraction, and return it."""
    captions = Captions(panel)
    tint(image, panel, masks, scale)
    for target in near_first(image):
        color = label_color(target.gt_index)
        corner = draw_box_2d(panel, target, scale, color)
        fraction = f" {100 * target.visible_fraction:.0f} %" if 0 <= target.visible_fraction <= 1 else ""
        captions.add(f"{class_of(target, objects)}{fraction}", corner, color)
    captions.draw()
    draw_caption(panel, f"{len(masks)} visible masks, {len(image.targets)} boxes")
    return panel


def tint(image: ImageRecord, panel: Image, masks: Masks, scale: float) -> None:
    """Colour masks on a panel that is ``scale`` times as large, in place; near ones lie over far ones."""
    far_first = [target.gt_index for target in near_first(image)[::-1]]
    for index in (index for index in far_first if index in masks):
        inside = resized(masks[index].astype(np.uint8), scale) > 0
        panel[inside] = (0.5 * panel[inside] + 0.5 * np.array(label_color(index))).astype(np.uint8)


def draw_box_2d(panel: Image, target: TargetRecord, scale: float, color: Color) -> tuple[float, float]:
    """Draw the box of the visible part, and return its top left corner (px of the panel)."""
    left, top, right, bottom = np.array(target.box_visible_xyxy) * scale
    # From the outer border of the first pixel to that of the last one.
    corners = np.array([[left, top], [right + scale, bottom + scale]]) - 0.5
    first, last = np.round(np.clip(corners, -1e4, 1e4)).astype(int).tolist()
    cv2.rectangle(panel, first, last, color, 1)
    return float(corners[0, 0]), float(corners[0, 1])


def size_of(objects: Objects, target: TargetRecord) -> np.ndarray | None:
    """Return the edge lengths (m) of a label's box; None where they are not known."""
    try:
        size = target.info(objects).size
    except KeyError:
        return None
    return size if np.any(size > 0) else None


def near_first(image: ImageRecord) -> list[TargetRecord]:
    """Return the labels by distance; those without a pose come first."""
    return sorted(image.targets, key=lambda item: distance_of(item) or 0.0)


def label_color(index: int) -> Color:
    """Return the colour of the label at a position of an image."""
    red, green, blue = colorize_instances(np.array([[index + 1]], np.int32))[0, 0].tolist()
    return red, green, blue


def scaled(camera: PinholeCamera, scale: float) -> PinholeCamera:
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


def resized(image: np.ndarray, scale: float, sharp: bool = False) -> np.ndarray:
    """Return an image ``scale`` times as large; masks keep their borders, others are smoothed unless ``sharp``."""
    size = max(round(image.shape[1] * scale), 1), max(round(image.shape[0] * scale), 1)
    how = cv2.INTER_NEAREST if sharp or image.ndim == 2 else cv2.INTER_AREA if scale < 1 else cv2.INTER_LINEAR
    return cv2.resize(image, size, interpolation=how)
