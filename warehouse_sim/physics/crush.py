"""Does anything stand on what cannot bear it? Judged from a settled scene alone.

The rule of goods on goods: nothing bears more than its strength, and what is fragile nothing; what is heavy stands low;
what stands on a layer rests on most of it; stacks of three loads and more are secured.
"""

from collections import defaultdict
from dataclasses import asdict, dataclass
from typing import Any, Literal

from warehouse_sim.catalog.loads.strength import RIGID, bears, is_goods
from warehouse_sim.geometry.convex import area, shared
from warehouse_sim.physics.weights import Contact, Standing, Weights, weights_of
from warehouse_sim.schema import SceneSpec

FaultKind = Literal["overload", "heavy on light", "layer not full", "not secured"]
LEAST_LAYER = 0.85
"""Least fraction of the base of a load, or of a layer, that rests on the layer below it."""
HIGH_STACK = 3
"""Stacks of so many loads are wrapped or strapped."""
_ROUNDING, _HEAVIER = 1.01, 1.05
"""Weights that exceed a strength, and masses that exceed the one below, by less than these factors are equal to it."""
_SAME_LEVEL = 0.01
"""Bases that differ by less than this (m) are of one layer."""
_IN_LINE = 0.9
"""Two pieces are in line where their contact is at least this fraction of the larger outline."""
_SLIVER = 0.05
"""A neighbour that reaches over by less than this fraction of itself, a little off its cell, is no joint."""
_BONDS = ("wrap", "strap")


@dataclass(frozen=True)
class CrushFault:
    """One breach of the rule."""

    kind: FaultKind
    upper: int
    """Instance id of what stands above; of a layer its first piece."""
    lower: int
    """Instance id of what bears it; of a layer the first piece below."""
    value: float
    """What was found: kg carried, mass ratio, fraction of the base, loads in the stack."""
    limit: float
    """What it must keep to, in the same unit."""
    text: str
    """One line that names both."""


@dataclass(frozen=True)
class CrushState:
    """How a scene keeps to the rule."""

    contacts: int
    """Contacts of goods or loads with goods below them."""
    layers: int
    """Layers and loads that stand on goods."""
    highest: float
    """Largest fraction of its strength that a piece carries, 0 where nothing carries anything."""
    faults: tuple[CrushFault, ...]

    def to_plain(self) -> dict[str, Any]:
        """Return what JSON can hold."""
        return asdict(self)


def crush_state(scene: SceneSpec, struck: tuple[int, ...] = ()) -> CrushState:
    """Ask the rule of every contact in a settled ``scene``, but those in loads that were ``struck`` (their groups)."""
    weights = weights_of(scene, frozenset(struck))
    on_goods = [contact for contact in weights.contacts if is_goods(contact.lower.model)]
    overloads, highest = _overloads(on_goods, weights)
    layers = _layers(on_goods)
    faults = [
        *overloads,
        *_heavy_on_light(scene, on_goods),
        *_thin_layers(layers, weights),
        *_unsecured(scene, weights),
    ]
    return CrushState(len(on_goods), len(layers), highest, tuple(faults))


def _overloads(contacts: list[Contact], weights: Weights) -> tuple[list[CrushFault], float]:
    """Return pieces that carry more than they bear, and the largest fraction of its strength that one carries."""
    by_lower: dict[int, list[Contact]] = defaultdict(list)
    for contact in contacts:
        by_lower[contact.lower.item.instance_id].append(contact)
    faults, highest = [], 0.0
    for number, mine in by_lower.items():
        limit = bears(mine[0].lower.model, across=any(map(_is_across, mine)))
        carried = weights.carried[number]
        highest = max(highest, carried / limit if limit > 0.0 else 1.0)
        if carried > limit * _ROUNDING:
            upper = max(mine, key=lambda contact: contact.area).upper
            what = f"carries {carried:.1f} kg and bears {limit:.1f} kg"
            faults.append(_fault("overload", upper, mine[0].lower, carried, limit, what))
    return faults, highest


def _is_across(contact: Contact) -> bool:
    """Return whether goods stand on goods out of line."""
    if not is_goods(contact.upper.model):
        return False
    smaller, larger = sorted((area(contact.upper.outline), area(contact.lower.outline)))
    return _SLIVER * smaller < contact.area < _IN_LINE * larger


def _heavy_on_light(scene: SceneSpec, contacts: list[Contact]) -> list[CrushFault]:
    """Return contacts where a piece stands on a lighter one, or a load on a lighter one, or drums on softer goods."""
    masses: dict[int, float] = defaultdict(float)
    with_drums = set()
    for item in scene.instances:
        model = scene.model_of(item)
        masses[item.group] += model.mass
        if model.class_name == "drum":
            with_drums.add(item.group)
    faults = []
    for contact in contacts:
        upper, lower = contact.upper, contact.lower
        same = upper.item.group == lower.item.group
        above, below = (
            (upper.model.mass, lower.model.mass) if same else (masses[upper.item.group], masses[lower.item.group])
        )
        soft = lower.model.class_name not in ("drum", *RIGID)
        if above > below * _HEAVIER:
            what = f"is lighter ({below:.1f} kg) than what stands on it ({above:.1f} kg)"
            faults.append(_fault("heavy on light", upper, lower, above / below, 1.0, what))
        elif soft and not same and upper.item.group in with_drums:
            faults.append(_fault("heavy on light", upper, lower, above / below, 1.0, "stands under drums"))
    return faults


def _layers(contacts: list[Contact]) -> list[list[Contact]]:
    """Return the contacts of each layer, and of each load, that stands on goods."""
    layers: dict[tuple[int, int, bool], list[Contact]] = defaultdict(list)
    for contact in contacts:
        level = round(contact.upper.low / _SAME_LEVEL)
        layers[contact.upper.item.group, level, is_goods(contact.upper.model)].append(contact)
    return list(layers.values())


def _thin_layers(layers: list[list[Contact]], weights: Weights) -> list[CrushFault]:
    """Return layers and loads that rest on too little of what is below them."""
    faults = []
    for layer in layers:
        uppers = {contact.upper.item.instance_id: contact for contact in layer}
        base = sum(area(contact.upper.outline) for contact in uppers.values())
        resting = sum(_area_under(contact, weights) for contact in uppers.values())
        if resting < LEAST_LAYER * base:
            what = f"and its layer carry {100 * resting / base:.0f} % of a base"
            faults.append(_fault("layer not full", layer[0].upper, layer[0].lower, resting / base, LEAST_LAYER, what))
    return faults


def _area_under(contact: Contact, weights: Weights) -> float:
    """Return the area (m^2) of goods under an upper object, level with the piece that it stands on."""
    parts = [
        shared(contact.upper.outline, lower.outline) for lower in weights.level_with(contact) if is_goods(lower.model)
    ]
    return sum(area(part) for part in parts if len(part))


def _unsecured(scene: SceneSpec, weights: Weights) -> list[CrushFault]:
    """Return the loads in stacks of ``HIGH_STACK`` and more that nothing holds together."""
    goods: dict[int, bool] = defaultdict(bool)
    held = set()
    for item in scene.instances:
        model = scene.model_of(item)
        goods[item.group] |= is_goods(model) and model.class_name not in RIGID
        if model.class_name in _BONDS:
            held.add(item.group)
    under: dict[int, Contact] = {}
    for contact in weights.contacts:
        if contact.upper.item.group != contact.lower.item.group:
            under[contact.upper.item.group] = contact
    faults = []
    for top in sorted(set(under) - {contact.lower.item.group for contact in under.values()}):
        stack = [top]
        while stack[-1] in under and len(stack) <= len(under):
            stack.append(under[stack[-1]].lower.item.group)
        loads = [group for group in stack if goods[group]]
        if len(loads) < HIGH_STACK:
            continue
        for group in loads:
            if group not in held:
                contact = under.get(group) or next(c for c in under.values() if c.lower.item.group == group)
                what = f"is in a stack of {len(loads)} loads, of which load {group} is neither wrapped nor strapped"
                faults.append(_fault("not secured", contact.upper, contact.lower, len(loads), HIGH_STACK - 1, what))
    return faults


def _fault(kind: FaultKind, upper: Standing, lower: Standing, value: float, limit: float, what: str) -> CrushFault:
    above, below = upper.item, lower.item
    text = f"{kind}: {lower.model.name} ({below.instance_id}) under {upper.model.name} ({above.instance_id}) {what}"
    return CrushFault(kind, above.instance_id, below.instance_id, float(value), float(limit), text)
