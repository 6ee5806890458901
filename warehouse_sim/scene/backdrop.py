"""What stands in racks behind the ones along the aisle: seen, labelled, and fixed, since nothing there can move it.

A few loads are drawn a scene and stand in many slots, so that their geometry is shared. They rest by construction:
every piece is lowered onto what carries it, and the pallet onto its slot.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from warehouse_sim.geometry.pose import Transform, make_transform, rotation_z
from warehouse_sim.scene.draft import SceneDraft
from warehouse_sim.scene.layouts.site import Slot
from warehouse_sim.scene.resting import lowered_load
from warehouse_sim.scene.shelving import ShelvingConfig
from warehouse_sim.scene.unit_load import UnitLoad, UnitLoadConfig, build_unit_load
from warehouse_sim.schema import ObjectInstance, ObjectModel

_KINDS = 10
"""Different loads a scene."""
_MOST_PIECES = 30
"""Pieces on one pallet."""
_OBJ_ID = 510
"""Of the goods of a load as one object, whatever they are."""
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
    """Put fixed loads into a share of the slots, of which there may be none.

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
    kinds = [_draw(min(slot.headroom for slot in slots), loads, apart, number, rng) for number in range(_KINDS)]
    taken = rng.random(len(slots)) >= config.empty_slot_share
    for slot in (slot for slot, is_taken in zip(slots, taken, strict=True) if is_taken):
        pieces = kinds[int(rng.integers(_KINDS))]
        shift = np.array([*rng.uniform(-_SLACK, _SLACK, 2), 0.0])
        T_world_load = slot.T_world_slot @ make_transform(rotation_z(np.pi * rng.integers(2)), shift)
        group = draft.new_group()
        for model, T_load_piece in pieces:
            _add_fixed(draft, model, T_world_load @ T_load_piece, group)


def is_backdrop(item: ObjectInstance) -> bool:
    """Return whether an object is part of a load that nothing can move."""
    return item.group > 0 and not item.dynamic


def _add_fixed(draft: SceneDraft, model: ObjectModel, T_world_object: Transform, group: int) -> None:
    instance = draft.add(model, T_world_object, group)
    draft.instances[-1] = replace(instance, dynamic=False)


def _draw(headroom: float, loads: UnitLoadConfig, apart: bool, number: int, rng: np.random.Generator) -> Pieces:
    """Draw a load at rest, its goods one object unless they stay ``apart``."""
    config = replace(loads, max_cartons=min(loads.max_cartons, _MOST_PIECES), worn_share=0.0, mixed_share=0.0)
    pieces = lowered_load(build_unit_load(headroom, config, rng).pieces)
    return pieces if apart else _joined(pieces, number)


def _joined(pieces: Pieces, number: int) -> Pieces:
    """Return pallet, goods as one object, and what has no collision boxes (film, posts)."""
    goods = [(model, T) for model, T in pieces[1:] if model.collision]
    rest = [(model, T) for model, T in pieces[1:] if not model.collision]
    if not goods:
        return [pieces[0], *rest]
    box = UnitLoad(tuple(goods)).envelope
    T_goods_load = make_transform(translation=-box.T_parent_box[:3, 3])
    parts = tuple(
        replace(part, T_object_part=T_goods_load @ T @ part.T_object_part) for model, T in goods for part in model.parts
    )
    whole = ObjectModel(
        name=f"goods of load kind {number + 1}",
        class_name="goods",
        obj_id=_OBJ_ID,
        size=box.size,
        parts=parts,
        collision=(replace(box, T_parent_box=np.eye(4)),),
        mass=float(sum(model.mass for model, _ in goods)),
        materials=tuple({item.name: item for model, _ in goods for item in model.materials}.values()),
    )
    return [pieces[0], (whole, box.T_parent_box), *rest]
