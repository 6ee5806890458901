"""Compose a training sample: one image zoomed, shifted and mirrored, or a mosaic of four, and what boxes remain."""

from dataclasses import dataclass, replace

import cv2
import numpy as np
from jaxtyping import Float32, UInt8

from warehouse_sim.estimators.images.settings import ImageAugmentConfig
from warehouse_sim.geometry.boxes import box_areas
from warehouse_sim.learning.samples.array_store import Arrays

_MOSAIC = 0.3
"""Fraction of samples composed of four images."""
_SHIFT, _FLIP = 0.15, 0.5
"""How far images are shifted at most, as a fraction of their size, and which fraction of them is mirrored."""
_GREY = 114
_RICHEST, _SOFTEST_PX, _SHARPEST, _NOISIEST = 1.5, 1.5, 1.0, 15.0
"""Limits of another camera: colour over the image's own, width of its blur (px), detail that is added once more, and
grain (codes)."""
_EVEN = ((np.arange(256) - 127.5) / np.sqrt((256.0**2 - 1.0) / 12.0)).astype(np.float32)
"""Evenly spread numbers with a deviation of 1."""
_LEAST_RELATIVE = np.float32(0.001)
"""Of a depth stays."""
_LEAST_FRACTION = 0.15
"""Of a box must remain, or what remains is only to be ignored."""


@dataclass(frozen=True)
class ImageErrors:
    """How strongly colour and depth of an image are disturbed."""

    colour: float = 0.4
    """Largest relative change of brightness, contrast and each channel."""
    camera: float = 0.0
    """Fraction of colour images that look as another camera's."""
    depth_noise: float = 0.002
    """Standard deviation of noise on depth at 1 m, of which the square of the distance makes more (m)."""
    depth_holes: int = 4
    """Most rectangles without depth."""
    depth_scale: float = 0.05
    """Largest relative error of all depths of an image."""


_ERRORS = ImageErrors()


@dataclass(frozen=True, eq=False)
class Sample:
    """One composed image with its labels."""

    rgb: UInt8[np.ndarray, "h w 3"] | None
    depth: Float32[np.ndarray, "*planes h w"] | None
    """Canonical metres, 0 = no reading; of sweeps two planes, as ``sweep.compose`` says."""
    labels: Float32[np.ndarray, "k 8"]
    """Rows as ``rows.LABEL`` names them; the height in px is that on the canvas over the canvas' own scale."""


@dataclass(frozen=True)
class _Place:
    """Where an image goes: a rectangle of the canvas, and the map from its pixels there."""

    left: int
    top: int
    right: int
    bottom: int
    zoom: float
    mirrored: bool
    shift: tuple[float, float]
    """Of the image's upper left corner on the canvas (px)."""


def plain_sample(arrays: Arrays, index: int) -> Sample:
    """Return an image as it is stored."""
    labels = arrays["labels"][index]
    depth = arrays["depth"][index].astype(np.float32) / 1000.0 if "depth" in arrays else None
    rgb = np.asarray(arrays["rgb"][index]) if "rgb" in arrays else None
    return Sample(rgb, depth, np.array(labels[np.isfinite(labels[:, 0])]))


def composed_sample(
    arrays: Arrays, index: int, config: ImageAugmentConfig, rng: np.random.Generator, mosaics: bool = True
) -> Sample:
    """Return an image, disturbed afresh.

    Args:
        arrays: Images of one canvas.
        index: Which of them; those of a mosaic beside it are drawn.
        config: How strongly.
        rng: Decides.
        mosaics: Whether there are any.
    """
    height, width = arrays["rgb" if "rgb" in arrays else "depth"].shape[1:3]
    if rng.random() < _MOSAIC and mosaics:
        u, v = round(width * rng.uniform(0.3, 0.7)), round(height * rng.uniform(0.3, 0.7))
        corners = [(0, 0, u, v), (u, 0, width, v), (0, v, u, height), (u, v, width, height)]
        indices = [index, *rng.integers(len(arrays["labels"]), size=3).tolist()]
    else:
        corners, indices = [(0, 0, width, height)], [index]
    parts = [
        (plain_sample(arrays, number), _place(corner, (width, height), config, rng))
        for number, corner in zip(indices, corners, strict=True)
    ]
    labels = np.concatenate([_moved(part.labels, place, width) for part, place in parts])
    rgb = _painted([(part.rgb, place) for part, place in parts], (height, width, 3), np.uint8, _GREY)
    depth = _painted([(part.depth, place) for part, place in parts], (height, width), np.float32, 0)
    return disturbed(Sample(rgb, depth, labels), replace(_ERRORS, camera=config.camera), rng)


def disturbed(sample: Sample, errors: ImageErrors, rng: np.random.Generator) -> Sample:
    """Return a sample with errors of colour and depth."""
    rgb, depth = sample.rgb, sample.depth
    if rgb is not None and errors.colour:
        gain = rng.uniform(1 - errors.colour, 1 + errors.colour) * rng.uniform(
            1 - errors.colour / 4, 1 + errors.colour / 4, 3
        )
        power = np.exp(rng.uniform(-errors.colour, errors.colour))
        table = 255.0 * np.clip((np.arange(256)[:, None] / 255.0) ** power * gain, 0, 1)
        rgb = np.asarray(cv2.LUT(rgb, table.astype(np.uint8)[None]))
    if rgb is not None and rng.random() < errors.camera:
        rgb = _of_another_camera(rgb, rng)
    if depth is not None:
        depth = _noisy(depth, 1.0 + rng.uniform(-errors.depth_scale, errors.depth_scale), errors.depth_noise, rng)
        height, width = depth.shape
        for _ in range(int(rng.integers(errors.depth_holes + 1))):
            u, v = int(rng.integers(width)), int(rng.integers(height))
            depth[v : v + int(rng.integers(1, height // 8 + 2)), u : u + int(rng.integers(1, width // 12 + 2))] = 0.0
    return replace(sample, rgb=rgb, depth=depth)


def _noisy(
    depth: Float32[np.ndarray, "h w"], factor: float, sigma: float, rng: np.random.Generator
) -> Float32[np.ndarray, "h w"]:
    """Return depth (m) times a factor, with noise of a deviation of ``sigma`` times its square; 0 stays 0.

    The noise is even, which takes a tenth of the time of a normal one.
    """
    codes = np.frombuffer(rng.bytes(depth.size), np.uint8).reshape(depth.shape)
    relative = np.asarray(cv2.LUT(codes, _EVEN * np.float32(sigma)))
    relative *= depth
    relative += np.float32(factor)
    np.maximum(relative, _LEAST_RELATIVE, out=relative)
    relative *= depth
    return relative


def _of_another_camera(rgb: UInt8[np.ndarray, "h w 3"], rng: np.random.Generator) -> UInt8[np.ndarray, "h w 3"]:
    """Return an image with less or more colour, detail and grain, as phones and machine cameras differ in them."""
    grey = cv2.cvtColor(cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY), cv2.COLOR_GRAY2RGB)
    richness = rng.uniform(0.0, _RICHEST)
    rgb = cv2.addWeighted(rgb, richness, grey, 1.0 - richness, 0.0)
    soft = cv2.GaussianBlur(rgb, (0, 0), rng.uniform(0.3, _SOFTEST_PX))
    detail = rng.uniform(-1.0, _SHARPEST)
    rgb = cv2.addWeighted(rgb, 1.0 + detail, soft, -detail, 0.0)
    grain = np.frombuffer(rng.bytes(rgb.size), np.uint8).reshape(rgb.shape)
    width = rng.uniform(0.0, _NOISIEST)
    # Even in [-width, width]; both ends of the codes saturate.
    return np.asarray(cv2.addWeighted(rgb, 1.0, grain, width / 127.5, -width))


def _place(
    corner: tuple[int, int, int, int], size_wh: tuple[int, int], config: ImageAugmentConfig, rng: np.random.Generator
) -> _Place:
    """Draw how an image is seen through a rectangle of the canvas."""
    left, top, right, bottom = corner
    zoom = float(np.exp(rng.uniform(-1, 1) * np.log(config.zoom)))
    # A quarter of the canvas shows a quarter of its image or more.
    shift = []
    for low, high, size in ((left, right, size_wh[0]), (top, bottom, size_wh[1])):
        free = (high - low) - zoom * size
        middle = low + free * (0.5 if high - low == size else rng.uniform())
        shift.append(float(middle + rng.uniform(-1, 1) * _SHIFT * size))
    mirrored = bool(rng.random() < _FLIP)
    return _Place(left, top, right, bottom, zoom, mirrored, (shift[0], shift[1]))


def _moved(labels: Float32[np.ndarray, "k 8"], place: _Place, width: int) -> Float32[np.ndarray, "n 8"]:
    """Return the labels that are seen through a place, with what is left of their boxes."""
    labels = labels.copy()
    boxes = labels[:, :4].astype(float)
    if place.mirrored:
        boxes[:, [0, 2]] = width - boxes[:, [2, 0]]
    boxes = boxes * place.zoom + np.tile(place.shift, 2)
    cut = np.clip(boxes, [place.left, place.top] * 2, [place.right, place.bottom] * 2)
    fraction = box_areas(cut) / np.maximum(box_areas(boxes), 1e-9)
    labels[:, :4] = cut
    labels[:, 5] *= np.where(fraction < _LEAST_FRACTION, 0.0, fraction)
    labels[:, 6] *= place.zoom * (cut[:, 3] - cut[:, 1]) / np.maximum(boxes[:, 3] - boxes[:, 1], 1e-9)
    kept: Float32[np.ndarray, "n 8"] = labels[box_areas(cut) > 1.0]
    return kept


def _painted(
    parts: list[tuple[np.ndarray | None, _Place]], shape: tuple[int, ...], dtype: type, fill: int
) -> np.ndarray | None:
    """Return the images seen through their places; depths get nearer as images are enlarged."""
    if parts[0][0] is None:
        return None
    canvas: np.ndarray = np.full(shape, fill, dtype=dtype)
    for image, place in parts:
        assert image is not None
        is_depth, width = image.ndim == 2, shape[1]
        zoom, (right, down) = place.zoom, place.shift
        # Pixel centres are integers: edges are half a pixel off.
        sign, start = (-zoom, right + zoom * (width - 0.5)) if place.mirrored else (zoom, right + 0.5 * zoom)
        M = np.array([[sign, 0.0, start - 0.5 - place.left], [0.0, zoom, down + 0.5 * zoom - 0.5 - place.top]])
        size = place.right - place.left, place.bottom - place.top
        how = cv2.INTER_NEAREST if is_depth else cv2.INTER_LINEAR
        seen = cv2.warpAffine(image, M, size, flags=how, borderValue=(fill,) * 3)
        canvas[place.top : place.bottom, place.left : place.right] = seen / np.float32(zoom) if is_depth else seen
    return canvas
