"""What each loose object of a scene carries, from where the objects touch and where their weights act.

Each object is a stiff body on an elastic bed (Winkler, "Die Lehre von der Elasticitaet und Festigkeit", 1867): the
pressure under it is a plane over its contact patches, held by the balance of force and of both moments. Patches that
would have to pull are left out. Weights go from the uppermost objects down.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from warehouse_sim.catalog.loads.strength import is_goods
from warehouse_sim.geometry.convex import area, centroid, convex_hull, shared
from warehouse_sim.schema import ObjectInstance, ObjectModel, SceneSpec

Outline = Float[np.ndarray, "n 2"]
_TOUCH = 0.003
"""Faces that differ by less than this (m) in height are in contact."""
LEVEL = 0.006
"""Tops that differ by less than this (m) are one level: boards of damaged pallets and sacks give way."""
_UPRIGHT = 0.998
"""Least vertical fraction of an object's z axis; what leans more than this is not stacked."""
_LEAST_PATCH = 1e-5
"""Contacts smaller than this (m^2) carry nothing."""


@dataclass(frozen=True, eq=False)
class Standing:
    """An upright object with its horizontal faces."""

    item: ObjectInstance
    model: ObjectModel
    low: float
    """Height of its lowest face (m)."""
    high: float
    """Height of its highest face (m)."""
    feet: tuple[Outline, ...]
    """Outlines of what it stands on (m, world)."""
    tops: tuple[Outline, ...]
    """Outlines of what can stand on it (m, world)."""
    outline: Outline
    """Around all of it, seen from above (m, world)."""


@dataclass(frozen=True, eq=False)
class Contact:
    """One object on another."""

    upper: Standing
    lower: Standing
    patches: tuple[Outline, ...]

    @property
    def area(self) -> float:
        """The area of contact (m^2)."""
        return sum(map(area, self.patches))


@dataclass(frozen=True, eq=False)
class Weights:
    """Who stands on whom, and what each carries."""

    standing: tuple[Standing, ...]
    contacts: tuple[Contact, ...]
    carried: dict[int, float]
    """What stands on each object by instance id (kg)."""

    def level_with(self, contact: Contact) -> list[Standing]:
        """Return what is under the upper object of ``contact`` and as high as the lower one, touched or not."""
        return [
            one
            for one in self.standing
            if abs(one.high - contact.lower.high) < LEVEL and one.item.group == contact.lower.item.group
        ]


def weights_of(scene: SceneSpec, left_out: frozenset[int] = frozenset()) -> Weights:
    """Return contacts and weights of the upright loose objects of ``scene``, but those of the groups ``left_out``."""
    standing = [
        _standing(item, scene.model_of(item))
        for item in scene.instances
        if item.dynamic and item.group not in left_out and scene.model_of(item).collision
    ]
    upright = sorted((one for one in standing if one is not None), key=lambda one: -one.low)
    contacts = _contacts(upright)
    carried = {one.item.instance_id: 0.0 for one in upright}
    forces: dict[int, list[tuple[float, np.ndarray]]] = {one.item.instance_id: [] for one in upright}
    below: dict[int, list[Contact]] = {one.item.instance_id: [] for one in upright}
    for contact in contacts:
        below[contact.upper.item.instance_id].append(contact)
    for one in upright:
        number = one.item.instance_id
        loads = [(one.model.mass, one.item.T_world_object[:2, 3]), *forces[number]]
        for contact, kilograms, place in _reactions(below[number], loads):
            carried[contact.lower.item.instance_id] += kilograms
            forces[contact.lower.item.instance_id].append((kilograms, place))
    return Weights(tuple(upright), tuple(contacts), carried)


def _standing(item: ObjectInstance, model: ObjectModel) -> Standing | None:
    """Return an object's faces; None for what leans."""
    if item.T_world_object[2, 2] < _UPRIGHT:
        return None
    corners = [box.placed(item.T_world_object).corners() for box in model.collision]
    lows, highs = (np.array([getattr(points[:, 2], side)() for points in corners]) for side in ("min", "max"))
    outlines = [convex_hull(points[:, :2]) for points in corners]
    whole = convex_hull(np.concatenate(corners)[:, :2])
    feet = tuple(outlines[i] for i in np.flatnonzero(lows < lows.min() + _TOUCH))
    tops = tuple(outlines[i] for i in np.flatnonzero(highs > highs.max() - _TOUCH))
    if is_goods(model):
        # The boxes of one piece of goods overlap (those of a drum), so that the piece counts as a whole.
        feet = tops = (whole,)
    return Standing(item, model, float(lows.min()), float(highs.max()), feet, tops, whole)


def _contacts(standing: list[Standing]) -> list[Contact]:
    """Return which objects stand on which."""
    tops = np.array([one.high for one in standing])
    low = np.array([one.outline.min(axis=0) for one in standing]).reshape(-1, 2)
    high = np.array([one.outline.max(axis=0) for one in standing]).reshape(-1, 2)
    contacts = []
    for number, upper in enumerate(standing):
        near = (np.abs(tops - upper.low) < _TOUCH) & np.all((low < high[number]) & (high > low[number]), axis=1)
        near[number] = False
        for index in np.flatnonzero(near):
            pairs = [shared(foot, top) for foot in upper.feet for top in standing[index].tops]
            patches = tuple(patch for patch in pairs if len(patch) and area(patch) > _LEAST_PATCH)
            if patches:
                contacts.append(Contact(upper, standing[index], patches))
    return contacts


def _reactions(
    contacts: list[Contact], loads: list[tuple[float, np.ndarray]]
) -> list[tuple[Contact, float, Float[np.ndarray, " 2"]]]:
    """Return what each patch under one object carries (kg) and where (m), given what acts on the object and where."""
    patches = [(contact, patch) for contact in contacts for patch in contact.patches]
    total = sum(kilograms for kilograms, _ in loads)
    point = sum((kilograms * place for kilograms, place in loads), np.zeros(2)) / total if total > 0.0 else np.zeros(2)
    while patches:
        areas = np.array([area(patch) for _, patch in patches])
        places = np.array([centroid(patch) for _, patch in patches])
        fraction = _pressures(areas, places, np.array([_second_moments(patch) for _, patch in patches]), point) * areas
        if fraction.min() >= 0.0 or len(patches) == 1:
            return [
                (contact, total * float(part), place)
                for (contact, _), part, place in zip(patches, fraction / fraction.sum(), places, strict=True)
            ]
        patches = [patch for patch, part in zip(patches, fraction, strict=True) if part >= 0.0]
    return []


def _pressures(areas: np.ndarray, places: np.ndarray, moments: np.ndarray, point: np.ndarray) -> np.ndarray:
    """Return the mean pressure (1/m^2) on each patch of a unit force at ``point`` (m)."""
    whole = areas.sum()
    middle = areas @ places / whole
    arms = places - middle
    inertia = moments.sum(axis=0) + np.einsum("n,ni,nj->ij", areas, arms, arms)
    slope = np.linalg.lstsq(inertia, point - middle, rcond=1e-9)[0]
    return np.asarray(1.0 / whole + arms @ slope)


def _second_moments(outline: Outline) -> Float[np.ndarray, "2 2"]:
    """Return the second moments of area (m^4) of a convex outline about its own centre."""
    relative = outline - centroid(outline)
    after = np.roll(relative, -1, axis=0)
    cross = relative[:, 0] * after[:, 1] - relative[:, 1] * after[:, 0]
    both = relative + after
    sums = np.einsum("ni,nj->nij", relative, relative) + np.einsum("ni,nj->nij", after, after)
    return np.asarray(np.einsum("n,nij->ij", cross, sums + np.einsum("ni,nj->nij", both, both)) / 24.0)
