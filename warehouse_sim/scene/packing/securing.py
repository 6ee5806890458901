"""What secures a load: posts at its corners, film around it. Both follow the goods; physics does not move them."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import pairwise
from typing import Annotated, Literal

import numpy as np
from jaxtyping import Float

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.loads.securing import CORNER_POSTS, POST_BOARD, POST_LEG, stretch_wrap
from warehouse_sim.catalog.loads.securing.film_skin import Level
from warehouse_sim.catalog.loads.securing.film_winding import wound_film
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.convex import area, convex_hull, grown
from warehouse_sim.geometry.pose import Transform, make_transform, rotation_z, transform_points
from warehouse_sim.ranges import Range, ranged
from warehouse_sim.scene.distribution import Distribution
from warehouse_sim.scene.packing.bearing import Pieces
from warehouse_sim.schema import ObjectModel

_SLACK = 0.003
"""Distance of film and posts from the goods (m), which slip a little when they settle."""
_SKIRT, _SEAM = 0.07, 0.04
"""How far the film reaches down the pallet and how far that turn reaches up the goods (m)."""
_LEVEL = 0.01
"""Tops that differ by less than this (m) are level."""
_STEP_FRACTION = 0.08
"""A level whose outline is smaller than the one below by more than this fraction has its own turns of film."""

_LEAST_LAYER = 0.06
"""Tops nearer to each other than this (m) are one for the film around each layer."""


@dataclass(frozen=True)
@ranged
class FilmConfig:
    """How film goes around a load."""

    style: Literal["bands", "wound"] = "bands"
    """"bands": level turns of even film around where the load gets smaller. "wound": a spiral around the outline of
    each layer, denser at foot and top, with folds, roped edges and a loose end."""
    slack: Annotated[Distribution, Range(0, 1)] = field(default=Distribution.constant(0.2))
    """How loose wound film is, 0-1: its waves, and how far its turns sag."""


def corner_posts(goods: Pieces, floor: float) -> list[tuple[ObjectModel, Transform]]:
    """Return four posts at the corners of a block of goods, from ``floor`` (m) up.

    There are none where the block is too low for the shortest post or its uppermost layer has no corners to hold.
    """
    boxes = [_corners(item) for item in goods]
    if len(_levels(boxes, floor)) > 1:
        return []
    corners = np.concatenate(boxes)
    low, high = corners.min(axis=0) - _SLACK - POST_BOARD, corners.max(axis=0) + _SLACK + POST_BOARD
    heights = [(height, name) for name, (_, height) in CORNER_POSTS.items() if height <= high[2] - floor]
    if not heights:
        return []
    height, name = max(heights)
    half = POST_LEG / 2
    left, right, front, back = low[0] + half, high[0] - half, low[1] + half, high[1] - half
    places = ((left, front), (right, front), (right, back), (left, back))
    # The angle of a post's own frame is at -x -y; a quarter turn brings it to the next corner.
    return [
        (catalog_object(name), make_transform(rotation_z(turn * np.pi / 2), np.array([*place, floor + height / 2])))
        for turn, place in enumerate(places)
    ]


def film_around(
    goods: Pieces, deck: Sequence[float], floor: float, config: FilmConfig, rng: np.random.Generator
) -> tuple[ObjectModel, Transform]:
    """Return film around ``goods`` and the upper edge of their pallet, with its pose in the load's frame.

    Args:
        goods: Pieces and posts in the load's frame.
        deck: Edges of the pallet along x and y (m).
        floor: Height of the pallet's top (m).
        config: How it goes around.
        rng: Stream to draw from; level bands need none of it.
    """
    wound = config.style == "wound"
    corners = [_rims(item) if wound else _corners(item) for item in goods]
    levels = _layers(corners, floor) if wound else _levels(corners, floor)
    sides = np.array([[sx * deck[0], sy * deck[1]] for sx in (-0.5, 0.5) for sy in (-0.5, 0.5)])
    foot = convex_hull(np.concatenate([levels[0].outline, sides]))
    # Around a load that stands far from the pallet's edge the film starts on the pallet.
    flush = area(foot) <= 1.1 * area(levels[0].outline)
    if wound:
        skirt = [Level(foot, floor - _SKIRT, floor)] if flush else []
        model, centre = wound_film([*skirt, *levels], config.slack.sample(rng))
        return model, make_transform(translation=centre)
    slices = [Level(grown(foot, _SLACK), floor - _SKIRT, floor + _SEAM)] if flush else []
    slices += [Level(grown(level.outline, _SLACK), level.low, level.high) for level in levels]
    model, centre = stretch_wrap(slices)
    return model, make_transform(translation=centre)


def _levels(corners: Sequence[Float[np.ndarray, "_ 3"]], floor: float) -> list[Level]:
    """Cut the load where its outline gets clearly smaller; pieces are given by their corners (m)."""
    lows, tops = (np.array([getattr(box[:, 2], side)() for box in corners]) for side in ("min", "max"))
    bounds = [floor]
    outline = _outline(corners, tops > floor)
    for top in np.unique(tops[tops < tops.max() - _LEVEL]):
        above = _outline(corners, tops > top + _LEVEL)
        if area(above) < (1.0 - _STEP_FRACTION) * area(outline) and top - bounds[-1] > 0.05:
            bounds.append(float(top))
            outline = above
    bounds.append(float(tops.max()))
    return [
        Level(_outline(corners, (tops > low + _LEVEL) & (lows < high - _LEVEL)), low, high)
        for low, high in pairwise(bounds)
    ]


def _layers(corners: Sequence[Float[np.ndarray, "_ 3"]], floor: float) -> list[Level]:
    """Cut the load at the tops of its pieces; what reaches up through several layers is part of each."""
    lows, tops = (np.array([getattr(box[:, 2], side)() for box in corners]) for side in ("min", "max"))
    bounds = [floor]
    for top in np.unique(tops):
        if top - bounds[-1] >= _LEAST_LAYER and tops.max() - top >= _LEAST_LAYER:
            bounds.append(float(top))
    bounds.append(float(tops.max()))
    return [
        Level(_outline(corners, (tops > low + _LEVEL) & (lows < high - _LEVEL)), low, high)
        for low, high in pairwise(bounds)
    ]


def _outline(corners: Sequence[Float[np.ndarray, "_ 3"]], chosen: np.ndarray) -> Float[np.ndarray, "n 2"]:
    return convex_hull(
        np.concatenate([box[:, :2] for box, is_chosen in zip(corners, chosen, strict=True) if is_chosen])
    )


def _corners(item: tuple[ObjectModel, Transform]) -> Float[np.ndarray, "8 3"]:
    model, T_load_piece = item
    return OrientedBox(T_load_piece, model.size).corners()


def _rims(item: tuple[ObjectModel, Transform]) -> Float[np.ndarray, "n 3"]:
    """Return the outline of an upright piece seen from above, at its lower and its upper edge (m)."""
    model, T_load_piece = item
    outline = _outline_of(model)
    half = model.size[2] / 2
    rims = [np.column_stack([outline, np.full(len(outline), z)]) for z in (-half, half)]
    return transform_points(T_load_piece, np.concatenate(rims))


@lru_cache(maxsize=256)
def _outline_of(model: ObjectModel) -> Float[np.ndarray, "n 2"]:
    return convex_hull(model.mesh().vertices[:, :2])
