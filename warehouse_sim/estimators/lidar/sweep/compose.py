"""Compose a training sample of sweeps: a sector of a turn, zoomed and mirrored, or two halves of different ones."""

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float32

from warehouse_sim.estimators.images.compose import Sample
from warehouse_sim.estimators.lidar.sweep.range_image import SweepGrid
from warehouse_sim.estimators.lidar.sweep.rows import UNKNOWN_MM
from warehouse_sim.estimators.lidar.sweep.settings import SweepAugmentConfig
from warehouse_sim.geometry.boxes import box_areas
from warehouse_sim.learning.samples.array_store import Arrays

MARGIN = 96
"""Columns of a turn that are repeated at both ends where a whole one is looked at (px); a multiple of 32."""


@dataclass(frozen=True)
class Sector:
    """Which part of a turn is seen, and how: column u of the sample shows column ``at(u)`` of the turn."""

    middle: float
    """Column of the turn that is in the middle of the sector."""
    width: int
    """Columns of the sector."""
    zoom: float = 1.0
    mirrored: bool = False
    shift: float = 0.0
    """Rows that everything lies lower."""

    @property
    def step(self) -> float:
        """Columns of the turn to a column of the sector."""
        return (-1.0 if self.mirrored else 1.0) / self.zoom


def plain_sweep(arrays: Arrays, index: int, grid: SweepGrid, wanted: Collection[int] = ()) -> Sample:
    """Return a whole turn with ``MARGIN`` columns more at both ends, and the labels that are seen there, twice if so.

    Args:
        arrays: Sweeps.
        index: Which of them.
        grid: Of the sweeps.
        wanted: Numbers of the objects that are detected.
    """
    columns = grid.config.columns
    seen = _seen(arrays, index, Sector(columns / 2.0, columns + 2 * MARGIN), grid, wanted)
    labels = _labels(arrays, index)
    turns = np.concatenate([labels + np.array([shift, 0, shift, 0, 0, 0, 0, 0]) for shift in (-columns, 0, columns)])
    turns[:, [0, 2]] += MARGIN
    return Sample(None, seen, _cut(turns.astype(np.float32), 0.0, columns + 2.0 * MARGIN, grid.config.rows))


def composed_sweep(
    arrays: Arrays,
    index: int,
    config: SweepAugmentConfig,
    grid: SweepGrid,
    rng: np.random.Generator,
    mosaics: bool = True,
    wanted: Collection[int] = (),
) -> Sample:
    """Return a sector, disturbed afresh.

    Its planes are range (m, 0 = no reading), height above the floor (m, NaN = unknown), and whether a pixel shows what
    is detected (1 or 0, NaN = no reading).

    Args:
        arrays: Sweeps.
        index: Which of them; that of the other half of a mosaic is drawn.
        config: How strongly.
        grid: Of the sweeps.
        rng: Decides.
        mosaics: Whether there are any.
        wanted: Numbers of the objects that are detected.
    """
    widths, indices = [config.window], [index]
    if rng.random() < config.mosaic and mosaics:
        first = round(config.window * rng.uniform(0.3, 0.7))
        widths, indices = [first, config.window - first], [index, int(rng.integers(len(arrays["labels"])))]
    parts, labels, start = list[np.ndarray](), list[np.ndarray](), 0
    for width, number in zip(widths, indices, strict=True):
        sector = Sector(
            rng.uniform(0.0, grid.config.columns),
            width,
            float(np.exp(rng.uniform(-1.0, 1.0) * np.log(config.zoom))),
            bool(rng.random() < config.flip),
            float(rng.uniform(-1.0, 1.0) * config.shift),
        )
        parts.append(_seen(arrays, number, sector, grid, wanted))
        labels.append(moved_labels(_labels(arrays, number), sector, grid) + np.array([start, 0] * 2 + [0] * 4))
        start += width
    sample = Sample(None, np.concatenate(parts, axis=2), np.concatenate(labels).astype(np.float32))
    return disturbed_sweep(sample, config, rng)


def disturbed_sweep(sample: Sample, config: SweepAugmentConfig, rng: np.random.Generator) -> Sample:
    """Return a sample with errors of ranges, holes, and a floor that is a little wrong, or unknown."""
    assert sample.depth is not None
    metres, height, shows = np.array(sample.depth)
    noise = rng.standard_normal(metres.shape, dtype=np.float32) * np.float32(rng.uniform(0.0, config.noise))
    metres = np.where(metres > 0, np.maximum(metres + noise, 0.01), 0.0)
    rows, columns = metres.shape
    for _ in range(int(rng.integers(config.holes + 1))):
        u, v = int(rng.integers(columns)), int(rng.integers(rows))
        hole = np.s_[v : v + int(rng.integers(1, rows // 8 + 2)), u : u + int(rng.integers(1, columns // 12 + 2))]
        metres[hole], height[hole], shows[hole] = 0.0, np.nan, np.nan
    height = height + np.float32(rng.normal(0.0, config.floor_error))
    if rng.random() < config.floor_unknown:
        height[:] = np.nan
    return replace(sample, depth=np.stack([metres, height, shows]).astype(np.float32))


def moved_labels(labels: Float32[np.ndarray, "k 8"], sector: Sector, grid: SweepGrid) -> Float32[np.ndarray, "n 8"]:
    """Return the labels that a sector shows, with what is left of their boxes and points."""
    labels = labels.copy()
    centre, half = (labels[:, 0] + labels[:, 2]) / 2.0, (labels[:, 2] - labels[:, 0]) / 2.0 * sector.zoom
    along = grid.apart(centre, np.full_like(centre, sector.middle)) / sector.step + sector.width / 2.0
    labels[:, 0], labels[:, 2] = along - half, along + half
    labels[:, [1, 3]] = grid.horizon + (labels[:, [1, 3]] - grid.horizon) * sector.zoom + sector.shift
    return _cut(labels, 0.0, float(sector.width), grid.config.rows)


def _seen(
    arrays: Arrays, index: int, sector: Sector, grid: SweepGrid, wanted: Collection[int]
) -> Float32[np.ndarray, "3 h w"]:
    """Return the planes of a sector: what is enlarged seems nearer, its height stays."""
    rows, columns = grid.config.rows, grid.config.columns
    u = sector.middle + (np.arange(sector.width) + 0.5 - sector.width / 2.0) * sector.step
    v = np.floor(grid.horizon + (np.arange(rows) + 0.5 - sector.shift - grid.horizon) / sector.zoom).astype(int)
    inside = (v >= 0) & (v < rows)
    place = np.ix_(np.clip(v, 0, rows - 1), np.floor(u).astype(int) % columns)
    steps, height = arrays["range_mm"][index][place], arrays["height_mm"][index][place]
    metres = np.where(inside[:, None], steps, 0) / np.float32(1000.0 * sector.zoom)
    known = inside[:, None] & (height != UNKNOWN_MM) & (steps > 0)
    shows = np.where(metres > 0, np.isin(arrays["obj_id"][index][place], list(wanted)), np.nan)
    return np.stack([metres, np.where(known, height / np.float32(1000.0), np.nan), shows]).astype(np.float32)


def _labels(arrays: Arrays, index: int) -> Float32[np.ndarray, "k 8"]:
    labels = np.asarray(arrays["labels"][index])
    return np.array(labels[np.isfinite(labels[:, 0])])


def _cut(labels: Float32[np.ndarray, "k 8"], left: float, right: float, rows: int) -> Float32[np.ndarray, "n 8"]:
    """Return the labels with boxes cut at the borders, and their points and shares less by what is gone."""
    boxes = labels[:, :4].astype(float)
    cut = np.clip(boxes, [left, 0.0] * 2, [right, rows] * 2)
    fraction = box_areas(cut) / np.maximum(box_areas(boxes), 1e-9)
    labels[:, :4] = cut
    labels[:, 5] *= fraction
    labels[:, 6] *= fraction
    kept: Float32[np.ndarray, "n 8"] = labels[box_areas(cut) > 1.0]
    return kept
