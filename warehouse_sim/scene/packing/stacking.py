"""Layers above each other: each piece a little off its cell and a little turned, but never into its neighbours."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Annotated, Literal

import numpy as np
from jaxtyping import Float

from warehouse_sim.errors import PlacementError
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import Transform, make_transform, rotation_z
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.ranges import Fraction, Range, ranged
from warehouse_sim.scene.distribution import Distribution
from warehouse_sim.scene.packing.patterns import Layer

AIR = 0.0005
"""Gap (m) under every piece and the least gap beside it, before settling."""
_TRIES, _LAYER_TRIES = 30, 20


@dataclass(frozen=True)
@ranged
class StackingConfig:
    """How carefully pieces are stacked."""

    gap_mm: Annotated[float, Range(1, 30, "mm")] = 8.0
    """Gap between neighbouring pieces of a layer (mm), 1-30."""
    shift_mm: Annotated[Distribution, Range(-50, 50, "mm")] = field(default=Distribution.normal(0.0, 1.5, -4.0, 4.0))
    """How far a piece stands off its cell, along each axis (mm), -50 to 50."""
    yaw_deg: Annotated[Distribution, Range(-45, 45, "deg")] = field(default=Distribution.normal(0.0, 0.4, -1.5, 1.5))
    """How far a piece is turned about the vertical (deg), -45 to 45."""
    top_layer_fraction: Annotated[Distribution, Range(0, 1)] = field(default=Distribution.uniform(0.4, 1.0))
    """Fraction of the top layer's cells that are taken, 0-1; at least one cell is."""
    top_layer_order: Literal["scattered", "rows"] = "scattered"
    """Whether the cells taken in the top layer are any, or row by row from one side, as pickers leave them."""
    half_turn_fraction: Fraction = 0.0
    """Fraction of the pieces that are turned by 180 degrees, so that labels and marks face all ways, 0-1."""
    crush_rule: bool = True
    """Whether fragile goods carry nothing, heavy goods and loads stand low, what stands on a layer rests on 85 % of it,
    and stacks of three loads and more are wrapped or strapped; no piece bears more than its strength in any case."""


@dataclass(frozen=True, eq=False)
class Tier:
    """Equal pieces that stand on one level."""

    size: Float[np.ndarray, " 3"]
    """Edges of a piece (m)."""
    cells: Layer
    is_round: bool = False
    """Whether a piece looks the same from all sides, so that any turn fits its cell."""


def stack_tiers(tiers: Sequence[Tier], config: StackingConfig, rng: np.random.Generator) -> list[list[Transform]]:
    """Return the poses of the pieces' centres over a surface at z = 0, tier by tier, 0.5 mm of air under each.

    The top tier is taken in part. No two pieces come nearer than half a millimetre: each is tested by its separating
    axes against those placed before it.

    Raises:
        PlacementError: A piece cannot be shifted and turned without touching its neighbours.
    """
    poses: list[list[Transform]] = []
    floor = 0.0
    for number, tier in enumerate(tiers):
        cells = tier.cells
        if number == len(tiers) - 1:
            cells = _part_of(cells, config, rng)
        centres = np.column_stack([cells.centres, np.full(len(cells), floor + tier.size[2] / 2 + AIR)])
        poses.append(_place_layer(centres, cells.turned, tier, config, rng))
        floor += tier.size[2] + AIR
    return poses


def _part_of(cells: Layer, config: StackingConfig, rng: np.random.Generator) -> Layer:
    """Draw which cells of the top tier are taken."""
    count = max(1, round(config.top_layer_fraction.sample(rng) * len(cells)))
    if config.top_layer_order == "scattered":
        return cells.subset(np.sort(rng.permutation(len(cells))[:count]))
    # From one of the four sides, the row at that side first and each row from one end.
    axis, sign = int(rng.integers(2)), rng.choice([-1.0, 1.0])
    keys = np.round(cells.centres * sign, 3)
    return cells.subset(np.lexsort((keys[:, 1 - axis], keys[:, axis]))[:count])


def _place_layer(
    centres: Float[np.ndarray, "n 3"],
    turned: np.ndarray,
    tier: Tier,
    config: StackingConfig,
    rng: np.random.Generator,
) -> list[Transform]:
    """Draw shift and turn of each piece; a dead end starts the whole layer again."""
    for _ in range(_LAYER_TRIES):
        placed: list[OrientedBox] = []
        for centre, quarter in zip(centres, turned, strict=True):
            box = _place(BoxStack.of(placed), centre, np.pi / 2 if quarter else 0.0, tier, config, rng)
            if box is None:
                break
            placed.append(box)
        if len(placed) == len(centres):
            return [_randomly_turned(box.T_parent_box, tier, config, rng) for box in placed]
    raise PlacementError("pieces touch their neighbours in every try; lower shift_mm or yaw_deg or raise gap_mm")


def _place(
    others: BoxStack,
    centre: Float[np.ndarray, " 3"],
    yaw: float,
    tier: Tier,
    config: StackingConfig,
    rng: np.random.Generator,
) -> OrientedBox | None:
    """Draw shift and turn until the piece is at least 0.5 mm away from ``others``; None after too many tries."""
    for _ in range(_TRIES):
        shift = np.array([config.shift_mm.sample(rng), config.shift_mm.sample(rng), 0.0]) / 1000
        turn = 0.0 if tier.is_round else np.deg2rad(config.yaw_deg.sample(rng))
        box = OrientedBox(make_transform(rotation_z(yaw + turn), centre + shift), tier.size)
        if others.clear_of(box, AIR):
            return box
    return None


def _randomly_turned(T: Transform, tier: Tier, config: StackingConfig, rng: np.random.Generator) -> Transform:
    """Turn a piece in ways that its cell does not feel: a round one by any angle, another by half a turn."""
    if tier.is_round:
        return T @ make_transform(rotation_z(rng.uniform(0.0, 2 * np.pi)))
    if config.half_turn_fraction > 0.0 and rng.random() < config.half_turn_fraction:
        return T @ make_transform(rotation_z(np.pi))
    return T
