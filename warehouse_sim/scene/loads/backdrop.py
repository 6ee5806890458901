"""What stands in racks behind the ones along the aisle: seen, labelled, and fixed, since nothing there can move it.

A few loads are sampled a scene and stand in many slots, so that their geometry is shared. They rest by construction:
every piece is lowered onto what carries it, and the pallet onto its slot.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from warehouse_sim.catalog.loads.cartons import SKUS
from warehouse_sim.catalog.loads.sacks import SACK_SHAPES, SACKS, sack
from warehouse_sim.catalog.loads.stuck import BOARD_FACE, LABEL_FACE, stuck_carton
from warehouse_sim.catalog.parts import fused
from warehouse_sim.geometry.pose import Transform, invert, make_transform, rotation_z
from warehouse_sim.scene.draft import SceneDraft
from warehouse_sim.scene.layouts.site import Slot
from warehouse_sim.scene.loads.resting import lowered_load
from warehouse_sim.scene.loads.shelving import ShelvingConfig
from warehouse_sim.scene.loads.unit_load import UnitLoad, UnitLoadConfig, build_unit_load
from warehouse_sim.schema import ObjectInstance, ObjectModel

_KINDS = 10
"""Different loads a scene."""
_MOST_PIECES = 30
"""Pieces on one pallet."""
_OBJ_ID = 510
"""Of the goods of a load as one object, whatever they are."""
_WAYS = 3
"""Ways in which the cartons of a load are labelled."""
_OUTSIDE = 0.03
"""How far below the outside of a load (m) print is still seen."""
_SLACK = 0.02
"""How far a load may be off its slot, along the beams and across (m)."""

Pieces = list[tuple[ObjectModel, Transform]]
"""Models and their poses on the slot."""


def fill_backdrop(
    draft: SceneDraft,
    slots: Sequence[Slot],
    config: ShelvingConfig,
    loads: UnitLoadConfig,
    apart: bool,
    rng: np.random.Generator,
) -> None:
    """Put fixed loads into a fraction of the slots, of which there may be none.

    Args:
        draft: Where to add them.
        slots: Places behind the aisle's.
        config: How full the racks are.
        loads: What the recipe says of loads.
        apart: Whether goods stay objects of their own, as they must where their class is a target.
        rng: Stream to draw from.
    """
    if not slots:
        return
    looks = rng.spawn(1)[0]
    headroom, most_mass = min(slot.headroom for slot in slots), min(slot.most_mass for slot in slots)
    kinds = [_draw(headroom, most_mass, loads, apart, number, rng, looks) for number in range(_KINDS)]
    taken = rng.random(len(slots)) >= config.empty_slot_fraction
    for slot in (slot for slot, is_taken in zip(slots, taken, strict=True) if is_taken):
        pieces = kinds[int(rng.integers(_KINDS))]
        shift = np.array([*rng.uniform(-_SLACK, _SLACK, 2), 0.0])
        T_world_load = slot.T_world_slot @ make_transform(rotation_z(np.pi * rng.integers(2)), shift)
        group = draft.new_group()
        for model, T_load_piece in pieces:
            draft.add(model, T_world_load @ T_load_piece, group, fixed=True)


def is_backdrop(item: ObjectInstance) -> bool:
    """Return whether an object is part of a load that nothing can move."""
    return item.group > 0 and not item.dynamic


def _draw(
    headroom: float,
    most_mass: float,
    loads: UnitLoadConfig,
    apart: bool,
    number: int,
    rng: np.random.Generator,
    looks: np.random.Generator,
) -> Pieces:
    """Draw a load at rest, its goods one object unless they stay ``apart``; ``looks`` sticks labels on its cartons."""
    config = replace(loads, max_cartons=min(loads.max_cartons, _MOST_PIECES), damaged_fraction=0.0, mixed_fraction=0.0)
    pieces = lowered_load(build_unit_load(headroom, config, rng, most_mass=most_mass).pieces)
    if apart:
        return pieces
    pieces = [(sack(model.name, every=2) if model.name in SACKS | SACK_SHAPES else model, T) for model, T in pieces]
    return _joined(_stuck(pieces, looks) if loads.prints == "sampled" else pieces, number)


def _stuck(pieces: Pieces, rng: np.random.Generator) -> Pieces:
    """Return ``pieces`` with labels and prints on the sides of cartons that lie on the outside of the load.

    A scene lays pictures on them, which need no triangles for letters.
    """
    cartons = [(model, T) for model, T in pieces if model.name in SKUS]
    if not cartons:
        return pieces
    box = UnitLoad(tuple(cartons)).envelope
    half, T_box_load = box.size / 2, invert(box.T_parent_box)
    ways = {name: [stuck_carton(name, rng) for _ in range(_WAYS)] for name in sorted({m.name for m, _ in cartons})}

    def outside(T_load_part: Transform) -> bool:
        place = (T_box_load @ T_load_part)[:3, 3]
        return bool((np.abs(place) > half - _OUTSIDE).any())

    def dressed(model: ObjectModel, T: Transform) -> ObjectModel:
        if model.name not in SKUS:
            return model
        way = ways[model.name][rng.integers(_WAYS)]
        faces = (LABEL_FACE, BOARD_FACE)
        parts = (part for part in way.parts if part.material not in faces or outside(T @ part.T_object_part))
        return replace(way, parts=tuple(parts))

    return [(dressed(model, T), T) for model, T in pieces]


def _joined(pieces: Pieces, number: int) -> Pieces:
    """Return pallet, goods as one object, and what has no collision boxes (film, posts)."""
    goods = [(model, T) for model, T in pieces[1:] if model.collision]
    rest = [(model, T) for model, T in pieces[1:] if not model.collision]
    if not goods:
        return [pieces[0], *rest]
    box = UnitLoad(tuple(goods)).envelope
    T_goods_load = make_transform(translation=-box.T_parent_box[:3, 3])
    parts = [
        replace(part, T_object_part=T_goods_load @ T @ part.T_object_part) for model, T in goods for part in model.parts
    ]
    pictured = tuple(part for part in parts if part.material in (LABEL_FACE, BOARD_FACE))
    whole = ObjectModel(
        name=f"goods of load kind {number + 1}",
        class_name="goods",
        obj_id=_OBJ_ID,
        size=box.size,
        parts=(*fused([part for part in parts if part not in pictured]), *pictured),
        collision=(replace(box, T_parent_box=np.eye(4)),),
        mass=float(sum(model.mass for model, _ in goods)),
        materials=tuple({item.name: item for model, _ in goods for item in model.materials}.values()),
    )
    return [pieces[0], (whole, box.T_parent_box), *rest]
