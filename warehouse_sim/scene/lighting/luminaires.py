"""The bodies that light comes out of: luminaires over the aisle, and two big doors at the ends of the hall.

They are there whatever the light is. Each has a luminous face of a material of its own, so that a luminaire that is
switched on, or a door that is opened, changes nothing but that material.
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.building.safety import GATE_SIZE
from warehouse_sim.catalog.building.shell import WALL_SIZE
from warehouse_sim.catalog.building.structure import luminaire_trunking
from warehouse_sim.errors import PlacementError
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import Transform, make_transform, rotation_z
from warehouse_sim.scene.building.services import roof_over
from warehouse_sim.scene.draft import Area, SceneDraft
from warehouse_sim.scene.layouts.site import Site
from warehouse_sim.scene.lighting.config import LightingConfig, LuminaireName
from warehouse_sim.schema import LuminousFace, ObjectInstance, ObjectModel, SceneSpec

_BESIDE = 0.8
"""Free wall between what stands along the front and the door beside it (m)."""
_TRUSS_CLEARANCE = 0.9
"""Least distance of a luminaire's middle from the middle of a truss, along the aisle (m)."""
_BELOW_GIRDERS, _BELOW_ROOF, _HANGER = 0.12, 0.2, 0.11
"""Of a luminaire's middle below the girders, least distance below the roof, and half of its height (m)."""
_STEP = 0.2
_LOW = 0.011
"""Paint and dock plates up to this height (m) are no obstacle."""
_BEFORE = 0.02
"""How far before its face a luminaire's light is put (m)."""


@dataclass(frozen=True, eq=False)
class Luminaire:
    """What light can come out of, as it stands in a scene; an open door is one that the sky shines through."""

    face: LuminousFace
    position: Float[np.ndarray, " 3"]
    """Just before the middle of the face, in the world (m)."""
    direction: Float[np.ndarray, " 3"]
    """Unit normal of the face, out of it."""
    length: Float[np.ndarray, "3"]
    """Unit vector along its length: the x axis of its body."""


def add_luminaires(draft: SceneDraft, config: LightingConfig, site: Site, ceiling: float = WALL_SIZE[2]) -> None:
    """Hang the luminaires and add the doors.

    Args:
        draft: Where to add them; girders are those in it.
        config: How many, which and how high.
        site: The aisle and the hall.
        ceiling: Height of the roof above the floor (m).

    Raises:
        PlacementError: The luminaires would hang in or above the roof.
    """
    height = config.mounting_height
    if height is None:
        height = roof_over(draft, site.hall, ceiling).under_girders - _BELOW_GIRDERS
    elif height > ceiling - _BELOW_ROOF:
        raise PlacementError(
            f"lights.mounting_height: {height:.2f} m is not below the roof at {ceiling:.2f} m; lower it, or give null "
            "to hang luminaires right under the roof"
        )
    hang_luminaires(draft, config.rows, config.luminaires, height, site.aisle, config.luminaire)
    add_doors(draft, site.aisle, site.hall, ceiling)


def hang_luminaires(
    draft: SceneDraft, rows: int, count: int, height: float, aisle: Area, kind: LuminaireName = "highbay"
) -> None:
    """Add ``rows`` of ``count`` luminaires over the ``aisle``, their middles at ``height`` (m), beside roof trusses."""
    girders = [item for item in draft.instances if item.model.startswith(("roof_truss", "roof_beam"))]
    trusses = np.array([item.T_world_object[0, 3] for item in girders if _hits(draft, item, height)])
    pitch, spacing = (aisle.x_max - aisle.x_min) / count, (aisle.y_max - aisle.y_min) / rows
    model = _luminaire(kind, round(min(pitch - 0.02, 6.0), 3))
    for number in range(rows * count):
        row, column = divmod(number, count)
        x = aisle.x_min + (column + 0.5) * pitch
        for truss in trusses[np.abs(trusses - x) < _TRUSS_CLEARANCE]:
            x = truss + np.copysign(_TRUSS_CLEARANCE, x - truss)
        place = np.array([x, aisle.y_max - (row + 0.5) * spacing, height])
        draft.add(_with_own_face(model, number + 1), make_transform(translation=place))


def _luminaire(kind: LuminaireName, length: float) -> ObjectModel:
    """Return a luminaire; trunking is ``length`` m long, so that it makes a row."""
    if kind == "trunking":
        return luminaire_trunking("luminaire_trunking", length)
    return catalog_object({"highbay": "highbay_luminaire", "round": "luminaire_round"}[kind])


def _hits(draft: SceneDraft, girder: ObjectInstance, height: float) -> bool:
    """Return whether luminaires at ``height`` (m) have to keep clear of a girder."""
    low = girder.T_world_object[2, 3] - draft.models[girder.model].size[2] / 2
    return girder.model == "roof_truss" or height + _HANGER > low


def add_doors(draft: SceneDraft, aisle: Area, hall: Area, ceiling: float = WALL_SIZE[2]) -> None:
    """Add a drive-in door to the end wall that the aisle leads to, and one beside what stands along the front wall.

    The second is left out where the wall has no free place for it, both in a hall that is too low for them.
    """
    if hall.y_max - hall.y_min < GATE_SIZE[0] or ceiling < GATE_SIZE[2] + 0.1:
        return
    middle = GATE_SIZE[2] / 2
    y = (aisle.y_min + aisle.y_max) / 2
    end = make_transform(rotation_z(-np.pi / 2), np.array([hall.x_max - GATE_SIZE[1] / 2, y, middle]))
    draft.add(_with_own_face(catalog_object("drive_in_door"), 1), end)
    blocked = [(box.corners()[:, 0].min(), box.corners()[:, 0].max()) for box in _along_wall(draft, hall)]
    for x in np.arange(aisle.x_max + _BESIDE + GATE_SIZE[0] / 2, hall.x_max - GATE_SIZE[0] / 2 - _BESIDE, _STEP):
        if all(right < x - GATE_SIZE[0] / 2 or left > x + GATE_SIZE[0] / 2 for left, right in blocked):
            place = make_transform(translation=np.array([x, hall.y_max - GATE_SIZE[1] / 2, middle]))
            draft.add(_with_own_face(catalog_object("drive_in_door"), 2), place)
            return


def luminaires_of(scene: SceneSpec) -> list[Luminaire]:
    """Return all that light can come out of, in order of instance id."""
    found = []
    for instance in sorted(scene.instances, key=lambda item: item.instance_id):
        face = scene.model_of(instance).luminous_face
        if face is not None:
            found.append(_placed(face, instance.T_world_object))
    return found


def _placed(face: LuminousFace, T_world_object: Transform) -> Luminaire:
    normal = -(T_world_object[:3, :3] @ face.inward)
    return Luminaire(face, T_world_object[:3, 3] + (face.distance + _BEFORE) * normal, normal, T_world_object[:3, 0])


def _with_own_face(model: ObjectModel, number: int) -> ObjectModel:
    """Return ``model`` with a luminous face that has a material of its own."""
    assert model.luminous_face is not None
    face = replace(model.luminous_face, material=f"{model.luminous_face.catalog_material} {number}")
    parts = tuple(
        replace(part, material=face.material) if part.material == model.luminous_face.material else part
        for part in model.parts
    )
    return replace(model, name=f"{model.name} {number}", parts=parts, luminous_face=face)


def _along_wall(draft: SceneDraft, hall: Area) -> list[OrientedBox]:
    """Return the boxes that stand, lower than a door, in the way of one along the front wall."""
    found = []
    solids = draft.solids()
    for box in solids.listed(solids.owner > 0):
        corners = box.corners()
        near = hall.y_max - GATE_SIZE[1] - 0.05 < corners[:, 1].max() and corners[:, 1].min() < hall.y_max - 1e-6
        if near and corners[:, 2].min() < GATE_SIZE[2] and corners[:, 2].max() > _LOW and box.size.max() < 20.0:
            found.append(box)
    return found
