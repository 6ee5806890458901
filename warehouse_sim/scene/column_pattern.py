"""Cartons in a column pattern: equal layers, each carton straight above the one below."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float

from warehouse_sim.errors import PlacementError
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import Transform, make_transform, rotation_z
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.scene.distribution import Distribution

_TRIES, _LAYER_TRIES = 30, 20
_HALF_MILLIMETRE = 0.0005


@dataclass(frozen=True)
class StackingConfig:
    """How carefully cartons are stacked."""

    gap_mm: float = 8.0
    """Gap between neighbouring cartons of a layer (mm), 1-30."""
    shift_mm: Distribution = field(default=Distribution.normal(0.0, 1.5, -4.0, 4.0))
    """How far a carton stands off its cell, along each axis (mm)."""
    yaw_deg: Distribution = field(default=Distribution.normal(0.0, 0.4, -1.5, 1.5))
    """How far a carton is turned about the vertical (deg)."""
    top_layer_share: Distribution = field(default=Distribution.uniform(0.4, 1.0))
    """Share of the top layer's cells that are taken, 0-1; at least one cell is."""

    def __post_init__(self) -> None:
        if not 1.0 <= self.gap_mm <= 30.0:
            raise ValueError(f"gap_mm must be 1-30, found {self.gap_mm}")
        if self.top_layer_share.low < 0.0 or self.top_layer_share.high > 1.0:
            raise ValueError("top_layer_share must stay within 0-1")


def column_cells(
    size: Float[np.ndarray, " 3"], area: tuple[float, float], gap: float
) -> tuple[Float[np.ndarray, "n 2"], float]:
    """Return the cell centres (m) of one layer on ``area`` (m by m, centred) and the cartons' yaw (rad).

    Cells lie on a grid, cartons all along x or all along y, whichever holds more. Cells touch the nominal area without
    gaps, as modular cartons do; the gaps make the layer grow beyond it.
    """
    options = []
    for yaw, (length, width) in ((0.0, size[:2]), (np.pi / 2, size[1::-1])):
        columns, rows = int(area[0] / length + 1e-6), int(area[1] / width + 1e-6)
        x = (np.arange(columns) - (columns - 1) / 2) * (length + gap)
        y = (np.arange(rows) - (rows - 1) / 2) * (width + gap)
        options.append((np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2), yaw))
    return max(options, key=lambda option: len(option[0]))


def stack_cartons(
    size: Float[np.ndarray, " 3"],
    layers: int,
    area: tuple[float, float],
    config: StackingConfig,
    rng: np.random.Generator,
) -> list[Transform]:
    """Return the poses of the cartons' centres over a surface at z = 0, layer by layer, 0.5 mm of air under each.

    Raises:
        PlacementError: A carton cannot be shifted and turned without touching its neighbours.
    """
    cells, yaw = column_cells(size, area, config.gap_mm / 1000)
    poses: list[Transform] = []
    for layer in range(layers):
        chosen = np.arange(len(cells))
        if layer == layers - 1:
            count = max(1, round(config.top_layer_share.draw(rng) * len(cells)))
            chosen = np.sort(rng.permutation(len(cells))[:count])
        z = layer * (size[2] + _HALF_MILLIMETRE) + size[2] / 2 + _HALF_MILLIMETRE
        centres = np.column_stack([cells[chosen], np.full(len(chosen), z)])
        poses += _place_layer(centres, yaw, size, config, rng)
    return poses


def _place_layer(
    centres: Float[np.ndarray, "n 3"],
    yaw: float,
    size: Float[np.ndarray, " 3"],
    config: StackingConfig,
    rng: np.random.Generator,
) -> list[Transform]:
    """Draw shift and turn of each carton; a dead end starts the whole layer again."""
    for _ in range(_LAYER_TRIES):
        placed: list[OrientedBox] = []
        for centre in centres:
            box = _place(BoxStack.of(placed), centre, yaw, size, config, rng)
            if box is None:
                break
            placed.append(box)
        if len(placed) == len(centres):
            return [box.T_parent_box for box in placed]
    raise PlacementError("cartons touch their neighbours in every try; lower shift_mm or yaw_deg or raise gap_mm")


def _place(
    others: BoxStack,
    centre: Float[np.ndarray, " 3"],
    yaw: float,
    size: Float[np.ndarray, " 3"],
    config: StackingConfig,
    rng: np.random.Generator,
) -> OrientedBox | None:
    """Draw shift and turn until the carton is at least 0.5 mm away from ``others``; None after too many tries."""
    for _ in range(_TRIES):
        shift = np.array([config.shift_mm.draw(rng), config.shift_mm.draw(rng), 0.0]) / 1000
        turn = np.deg2rad(config.yaw_deg.draw(rng))
        box = OrientedBox(make_transform(rotation_z(yaw + turn), centre + shift), size)
        if others.clear_of(box, _HALF_MILLIMETRE):
            return box
    return None
