"""The things that light comes out of: luminaires over the aisle, and two big doors at one end of the hall.

They are there whatever the light is. Each has a material of its own for the face that glows, so that a lamp that is
switched on, or a door that is opened, changes nothing but that material.
"""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from jaxtyping import Float

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.building import GATE_SIZE, LEAF_MATERIAL, LEAF_SIZE, LUMINAIRE_SIZE
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import Transform, make_transform, rotation_z
from warehouse_sim.scene.draft import Area, SceneDraft
from warehouse_sim.schema import ObjectModel, SceneSpec

_GLOWS = {"highbay_luminaire": "led_panel", "drive_in_door": LEAF_MATERIAL}
"""Catalog name of a fixture -> material of its face that can glow."""
_BESIDE = 0.8
"""Free wall between what stands along the front and the door beside it (m)."""
_TRUSS_CLEARANCE = 0.9
"""Least distance of a luminaire's middle from the middle of a truss, along the aisle (m)."""
_STEP = 0.2
_LOW = 0.011
"""Paint and dock plates up to this height (m) are no obstacle."""


@dataclass(frozen=True, eq=False)
class Fixture:
    """A face that can glow, as it is found in a scene."""

    kind: Literal["luminaire", "door"]
    material: str
    """Name of the glowing face's own material."""
    position: Float[np.ndarray, " 3"]
    """Just before the middle of the face, in the world (m)."""
    direction: Float[np.ndarray, " 3"]
    """Unit normal of the face."""
    area: float
    """Of the face (m^2)."""

    @property
    def catalog_material(self) -> str:
        """Name of the catalog's material that its own is made from."""
        return self.material.rpartition(" ")[0]


def hang_luminaires(draft: SceneDraft, rows: int, count: int, height: float, aisle: Area) -> None:
    """Add ``rows`` of ``count`` luminaires over the ``aisle``, their middles at ``height`` (m), beside roof trusses."""
    trusses = np.array([item.T_world_object[0, 3] for item in draft.instances if item.model == "roof_truss"])
    pitch, spacing = (aisle.x_max - aisle.x_min) / count, (aisle.y_max - aisle.y_min) / rows
    for number in range(rows * count):
        row, column = divmod(number, count)
        x = aisle.x_min + (column + 0.5) * pitch
        for truss in trusses[np.abs(trusses - x) < _TRUSS_CLEARANCE]:
            x = truss + np.copysign(_TRUSS_CLEARANCE, x - truss)
        place = np.array([x, aisle.y_max - (row + 0.5) * spacing, height])
        draft.add(_own_glow("highbay_luminaire", number + 1), make_transform(translation=place))


def add_doors(draft: SceneDraft, aisle: Area, hall: Area) -> None:
    """Add a drive-in door to the end wall that the aisle leads to, and one beside what stands along the front wall.

    The second is left out where the wall has no free place for it.
    """
    middle = GATE_SIZE[2] / 2
    y = (aisle.y_min + aisle.y_max) / 2
    end = make_transform(rotation_z(-np.pi / 2), np.array([hall.x_max - GATE_SIZE[1] / 2, y, middle]))
    draft.add(_own_glow("drive_in_door", 1), end)
    blocked = [(box.corners()[:, 0].min(), box.corners()[:, 0].max()) for box in _along_wall(draft, hall)]
    for x in np.arange(aisle.x_max + _BESIDE + GATE_SIZE[0] / 2, hall.x_max - GATE_SIZE[0] / 2 - _BESIDE, _STEP):
        if all(right < x - GATE_SIZE[0] / 2 or left > x + GATE_SIZE[0] / 2 for left, right in blocked):
            place = make_transform(translation=np.array([x, hall.y_max - GATE_SIZE[1] / 2, middle]))
            draft.add(_own_glow("drive_in_door", 2), place)
            return


def fixtures_of(scene: SceneSpec) -> list[Fixture]:
    """Return the fixtures of a scene, in order of instance id."""
    found = []
    for instance in sorted(scene.instances, key=lambda item: item.instance_id):
        kind, _, number = instance.model.rpartition(" ")
        if kind not in _GLOWS or not number.isdigit():
            continue
        T, material = instance.T_world_object, _glow_name(kind, int(number))
        if kind == "highbay_luminaire":
            face, area = LUMINAIRE_SIZE[2] / 2, LUMINAIRE_SIZE[0] * LUMINAIRE_SIZE[1]
            found.append(Fixture("luminaire", material, _before(T, -T[:3, 2], face), -T[:3, 2], area))
        else:
            face, area = GATE_SIZE[1] / 2, LEAF_SIZE[0] * LEAF_SIZE[1]
            found.append(Fixture("door", material, _before(T, -T[:3, 1], face), -T[:3, 1], area))
    return found


def _before(T: Transform, normal: Float[np.ndarray, " 3"], face: float) -> Float[np.ndarray, " 3"]:
    """Return the point (m) just before a face that lies ``face`` from the origin along ``normal``."""
    return T[:3, 3] + (face + 0.02) * normal


def _own_glow(name: str, number: int) -> ObjectModel:
    """Return the catalog's fixture with a glowing face of its own material."""
    model, glow = catalog_object(name), _glow_name(name, number)
    parts = tuple(replace(part, material=glow) if part.material == _GLOWS[name] else part for part in model.parts)
    return replace(model, name=f"{name} {number}", parts=parts)


def _glow_name(name: str, number: int) -> str:
    return f"{_GLOWS[name]} {number}"


def _along_wall(draft: SceneDraft, hall: Area) -> list[OrientedBox]:
    """Return the boxes that stand, lower than a door, in the way of one along the front wall."""
    found = []
    for _, box in draft.solids():
        corners = box.corners()
        near = hall.y_max - GATE_SIZE[1] - 0.05 < corners[:, 1].max() and corners[:, 1].min() < hall.y_max - 1e-6
        if near and corners[:, 2].min() < GATE_SIZE[2] and corners[:, 2].max() > _LOW and box.size.max() < 20.0:
            found.append(box)
    return found
