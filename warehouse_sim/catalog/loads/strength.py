"""How much goods bear on top of them while they are stored.

Cartons follow McKee, Gander and Wachuta, "Compression strength formula for corrugated boxes" (Paperboard Packaging
48(8), 1963): BCT = 5.87 ECT sqrt(caliper x perimeter), whose constant has no unit. The board is single wall C flute of
32 lb/in, the carriers' grade for contents up to 65 lb (Item 222 of the National Motor Freight Classification); for
dense goods it is double wall BC flute of 61 lb/in, the grade up to 140 lb. What is left of it in a warehouse are the
Fibre Box Association's multipliers (Fibre Box Handbook).

Drums bear what the stacking test of ADR 6.1.5.6 puts on them: their like, up to 3 m. Sacks lie at most ten high (IS
4082:1996, so that cement does not lump). Makers give 250-600 kg for euro containers; the number here is common and
unverified.

Carriers bear what their makers put on a stack: a Gitterbox 4,400 kg (UIC 435-3; 4,400-6,500 kg after the maker), an IBC
of 1,000 l three of its like (4,056 kg on the lowest, for liquids of 1.2 kg/l), an octabin of heavy board one more like
it. Nothing stands on a big bag (free stacks of them need walls on two sides), or on a roll container.

What bears the mark "fragile" of ISO 780 on its sides, or is a user's own article that does not say what it bears, has
nothing on top where the crush rule holds.
"""

import math

from warehouse_sim.catalog.loads.cartons import ALL_SKUS
from warehouse_sim.schema import ObjectModel

_BOARDS = {1: (5604.0, 0.004), 2: (10683.0, 0.0065)}
"""Walls -> edge crush test of the board (N/m), 32 and 61 lb/in, and its thickness (m)."""
_GRAVITY = 9.81
_KEPT = 0.60 * 0.80 * 0.90
"""What is left after 30 days, at 70 % humidity, on a pallet with gaps between its boards."""
_IN_LINE, _ACROSS = 0.90, 0.50
"""What is left where edges stand on edges, a little off, and where they stand across joints (0.6 to 0.4)."""
_TOTE = 300.0
"""What a euro container bears (kg)."""
_SACKS_HIGH, _DRUMS_HIGH = 10, 3.0
"""Sacks on each other, the lowest included, and the height of a stack of drums (m)."""
_CARRIERS = {"gitterbox": 4400.0, "ibc": 3 * 1264.0, "octabin": 700.0, "big_bag": 0.0, "roll_container": 0.0}
"""What stands on carriers, by class (kg)."""
RIGID = ("gitterbox", "ibc")
"""Classes of carriers that stack on each other without film or straps: feet and corners of steel engage."""
GOODS = ("carton", "tote", "drum", "sack", *_CARRIERS)
"""Classes of goods."""
_FIRST_OWN = 1000
"""Numbers of geometries from here on are not the package's own."""
_DOUBLE_WALL = frozenset(sku.obj_id for sku in ALL_SKUS.values() if sku.walls == 2)
_FRAGILE = frozenset(sku.obj_id for sku in ALL_SKUS.values() if sku.artwork and "fragile" in sku.artwork.marks)


def stacking_strength(model: ObjectModel, *, across: bool = False) -> float:
    """Return what may stand on a piece of goods (kg), infinite for what is no goods.

    Args:
        model: The piece.
        across: Whether what stands on it is not in line with it, edge on edge.
    """
    if model.class_name == "carton":
        perimeter = 2.0 * float(model.size[0] + model.size[1])
        edge_crush, caliper = _BOARDS[2 if model.obj_id in _DOUBLE_WALL else 1]
        crush = 5.87 * edge_crush * math.sqrt(caliper * perimeter)
        return crush * _KEPT * (_ACROSS if across else _IN_LINE) / _GRAVITY
    if model.class_name == "tote":
        return _TOTE
    if model.class_name == "sack":
        return (_SACKS_HIGH - 1) * model.mass
    if model.class_name == "drum":
        return (_DRUMS_HIGH / float(model.size[2]) - 1.0) * model.mass
    return _CARRIERS.get(model.class_name, math.inf)


def is_fragile(model: ObjectModel) -> bool:
    """Return whether a piece is marked as fragile, so that nothing may stand on it."""
    return model.class_name == "carton" and model.obj_id in _FRAGILE


def is_goods(model: ObjectModel) -> bool:
    """Return whether a piece is goods and no pallet, sheet, post or film; a user's own article is goods."""
    own = model.obj_id >= _FIRST_OWN and model.mass > 0.0 and model.class_name != "pallet"
    return own or model.class_name in GOODS


def bears(model: ObjectModel, *, across: bool = False) -> float:
    """Return what may stand on a piece under the crush rule (kg), infinite for what is no goods.

    That is what the model says of itself, nothing if it is fragile, else the stacking strength of its class.

    Args:
        model: The piece.
        across: Whether what stands on it is not in line with it, edge on edge.
    """
    if model.bears is not None:
        return model.bears
    unknown = is_goods(model) and model.class_name not in GOODS
    return 0.0 if unknown or is_fragile(model) else stacking_strength(model, across=across)
