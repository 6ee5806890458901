"""Readings of any sensor as panels: the channels by name, and their numbers as images, bars or points."""

from collections.abc import Mapping
from typing import Any

import cv2
import numpy as np

from warehouse_sim.dataset.viewing.overlay import Image, colorize_depth
from warehouse_sim.schema import MountedReading, Reading

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
