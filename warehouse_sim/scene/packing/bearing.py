"""What pieces on each other bear: the weight on each of them, and how much more may stand on all.

Weight goes down in proportion to the areas of contact. Pieces are taken as they lie in their cells: a turn by a degree
or two takes as much from one contact as it gives to the next.
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Bool, Float

from warehouse_sim.catalog.loads.strength import bears, is_goods, stacking_strength
from warehouse_sim.geometry.convex import area, convex_hull
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.scene.packing.patterns import Layer
from warehouse_sim.schema import ObjectModel

Pieces = Sequence[tuple[ObjectModel, Transform]]
"""Models and their upright poses in a common frame, z up; those without collision boxes bear and weigh nothing."""

LEAST_SUPPORT = 0.87
"""Least fraction of a pallet's base that must rest on what it stands on."""
LEAST_LAYER = 0.9
"""Least fraction of a layer that must rest on the layer below it under the crush rule, which requires 0.85: pieces
stand a little off their cells."""
_USED_ACROSS, _USED_BY_LOADS = 0.9, 0.75
"""Fractions of the strength that are used under the crush rule where pieces lie across joints, and by loads on top:
weights go down unevenly where what presses is off centre, and a load stands some centimetres off the one below."""
_TOUCH = 0.002
"""A base and a top that differ by less than this (m) are in contact."""
_IN_LINE = 0.9
"""Two pieces are in line where their contact is at least this fraction of the larger base."""


def without_overload(pieces: Pieces, *, crush_rule: bool = False) -> list[tuple[ObjectModel, Transform]]:
    """Return pieces without the uppermost ones that those below would not bear, level by level."""
    left = list(pieces)
    while left and np.any(_burdens(left)[:, 0] > _allowed(left, crush_rule)):
        bottoms = np.array([_bottom(piece) for piece in left])
        left = [piece for piece, bottom in zip(left, bottoms, strict=True) if bottom < bottoms.max() - _TOUCH]
    return left


def bearing(pieces: Pieces, deck: Sequence[float]) -> float:
    """Return what may stand on pieces (kg), on a pallet of edges ``deck`` (m) of which ``LEAST_SUPPORT`` rests."""
    solid = [piece for piece in pieces if piece[0].collision]
    low, high = _extents(solid)
    bases = np.prod(high[:, :2] - low[:, :2], axis=1)
    on_top = np.where(_uppermost(high), bases / (LEAST_SUPPORT * deck[0] * deck[1]), 0.0)
    return _spare(solid, on_top, _strengths(solid))


def bearing_under_boards(pieces: Pieces, pallet: ObjectModel) -> float:
    """Return what may stand on pieces (kg) under the crush rule, on a ``pallet`` whose base boards press on them."""
    solid = [piece for piece in pieces if piece[0].collision]
    low, high = _extents(solid)
    top = _uppermost(high)
    boxes = np.array([[box.corners().min(axis=0), box.corners().max(axis=0)] for box in pallet.collision])
    feet = boxes[boxes[:, 0, 2] < boxes[:, 0, 2].min() + _TOUCH]
    pressed = np.where(top, _shared(low, high, feet[:, 0], feet[:, 1]).sum(axis=1), 0.0)
    if not pressed.any():
        return 0.0
    strengths = np.array([bears(model) for model, _ in solid])
    goods = np.array([is_goods(model) for model, _ in solid])
    if np.any((strengths <= 0.0) & top & goods):
        return 0.0
    return _spare(solid, pressed / pressed.sum(), _USED_BY_LOADS * _allowed(solid, crush_rule=True))


def layer_fraction(lower: Layer, upper: Layer, size: Float[np.ndarray, " k"]) -> float:
    """Return the fraction of a layer of equal pieces that rests on the layer below it, 0-1."""
    (low, high), (below_low, below_high) = upper.rectangles(size), lower.rectangles(size)
    return float(_shared(low, high, below_low, below_high).sum() / np.prod(high - low, axis=1).sum())


def supported_fraction(pieces: Pieces, deck: Sequence[float], T_pieces_deck: Transform) -> float:
    """Return the fraction, 0-1, of a pallet's base of edges ``deck`` (m) that rests on the uppermost pieces."""
    solid = [piece for piece in pieces if piece[0].collision]
    low, high = _extents(solid)
    top = _uppermost(high)
    centre, half = T_pieces_deck[:2, 3], np.array(deck) / 2
    shared = _shared(low[top], high[top], (centre - half)[None], (centre + half)[None])[:, 0]
    fill = np.array([_fill(model) for model, _ in solid])[top]
    return float(np.sum(fill * shared) / (deck[0] * deck[1]))


def _spare(pieces: Pieces, on_top: Float[np.ndarray, " n"], strengths: Float[np.ndarray, " n"]) -> float:
    """Return what may stand on pieces (kg) of which each gets the fraction ``on_top`` of it directly."""
    burden, fraction = _burdens(pieces, on_top).T
    loaded = fraction > 0.0
    return float(np.min((strengths - burden)[loaded] / fraction[loaded], initial=np.inf))


def _burdens(pieces: Pieces, on_top: Float[np.ndarray, " n"] | None = None) -> Float[np.ndarray, "n 2"]:
    """Return what stands on each piece (kg), and what each gets of a kilogram of which ``on_top`` goes to each.

    With S[i, j] the fraction of piece i that rests on piece j, burdens b solve b = S'(m + b) + t.
    """
    contact = _contacts(pieces)
    resting = contact.sum(axis=1, keepdims=True)
    fractions = np.divide(contact, resting, out=np.zeros_like(contact), where=resting > 0.0)
    masses = np.array([model.mass for model, _ in pieces])
    direct = np.zeros(len(pieces)) if on_top is None else on_top
    return np.linalg.solve(np.eye(len(pieces)) - fractions.T, np.column_stack([fractions.T @ masses, direct]))


def _contacts(pieces: Pieces) -> Float[np.ndarray, "n n"]:
    """Return the area (m^2) with which each piece (row) rests on each other (column)."""
    low, high = _extents(pieces)
    touch = np.abs(low[:, None, 2] - high[None, :, 2]) < _TOUCH
    return np.where(touch, _shared(low, high, low, high), 0.0)


def _shared(
    low: Float[np.ndarray, "n k"],
    high: Float[np.ndarray, "n k"],
    other_low: Float[np.ndarray, "m k"],
    other_high: Float[np.ndarray, "m k"],
) -> Float[np.ndarray, "n m"]:
    """Return the area (m^2) that each rectangle, given by its corners, shares with each other one, seen from above."""
    low, high = low[:, None, :2], high[:, None, :2]
    edges = np.minimum(high, other_high[None, :, :2]) - np.maximum(low, other_low[None, :, :2])
    return np.asarray(np.prod(np.maximum(edges, 0.0), axis=2))


def _allowed(pieces: Pieces, crush_rule: bool) -> Float[np.ndarray, " n"]:
    """Return what each piece may carry (kg)."""
    if not crush_rule:
        return _strengths(pieces)
    across = _across(pieces)
    strengths = [bears(model, across=bool(x)) for (model, _), x in zip(pieces, across, strict=True)]
    return np.array(strengths) * np.where(across, _USED_ACROSS, 1.0)


def _strengths(pieces: Pieces) -> Float[np.ndarray, " n"]:
    """Return what each piece bears (kg) under what stands on it."""
    across = _across(pieces)
    return np.array([stacking_strength(model, across=bool(x)) for (model, _), x in zip(pieces, across, strict=True)])


def _across(pieces: Pieces) -> Bool[np.ndarray, " n"]:
    """Return on which pieces goods stand that are not in line with them."""
    low, high = _extents(pieces)
    bases = np.prod(high[:, :2] - low[:, :2], axis=1)
    contact = _contacts(pieces)
    goods = np.isfinite([stacking_strength(model) for model, _ in pieces])
    off = (contact > 0.0) & (contact < _IN_LINE * np.maximum(bases[:, None], bases[None])) & goods[:, None]
    return np.asarray(off.any(axis=0))


def _extents(pieces: Pieces) -> tuple[Float[np.ndarray, "n 3"], Float[np.ndarray, "n 3"]]:
    """Return the lower and upper corners (m) of the pieces, each along the axis that it is nearest to."""
    centres = np.array([T[:3, 3] for _, T in pieces])
    sizes = [model.size[[1, 0, 2]] if abs(T[1, 0]) > abs(T[0, 0]) else model.size for model, T in pieces]
    half = np.array(sizes) / 2
    return centres - half, centres + half


def _uppermost(high: Float[np.ndarray, "n 3"]) -> Bool[np.ndarray, " n"]:
    """Return which pieces reach the common top."""
    return np.asarray(high[:, 2] > high[:, 2].max() - _TOUCH)


def _bottom(piece: tuple[ObjectModel, Transform]) -> float:
    model, T = piece
    return float(T[2, 3] - model.size[2] / 2)


def _fill(model: ObjectModel) -> float:
    """Return the fraction of its rectangle that a piece takes seen from above: less than one for what is round."""
    corners = np.concatenate([box.corners() for box in model.collision])
    return area(convex_hull(corners[:, :2])) / float(np.prod(model.size[:2]))
