"""Segments of driven roller conveyor, for cartons and for pallets.

Frame of both: x along the flow, z up, origin at the centre of the bounding box. Rollers of 50 mm at 100 mm, so that a
carton of 300 mm lies on three, and for pallets of 89 mm (3 1/2 in tube) at 150 mm; the side profiles end below the
rollers, so that a load may overhang.
"""

from dataclasses import dataclass

import numpy as np

from warehouse_sim.catalog.parts import box_part, collision_boxes, fused, model_of, solid_box, solid_part
from warehouse_sim.geometry.pose import rotation_x
from warehouse_sim.geometry.solids import unit_cylinder
from warehouse_sim.schema import ObjectModel, Part


@dataclass(frozen=True)
class ConveyorKind:
    """Measures of one kind of segment (m)."""

    obj_id: int
    """Number of the geometry."""
    length: float
    """Along the flow; segments in a row join without a gap."""
    lane: float
    """Clear width between the side profiles."""
    height: float
    """Top of the rollers above the floor."""
    roller: float
    """Diameter of a roller."""
    pitch: float
    """Distance from roller to roller."""
    profile: tuple[float, float]
    """Thickness and height of a side profile."""

    @property
    def width(self) -> float:
        """Outer width (m)."""
        return self.lane + 2 * self.profile[0]


CONVEYORS = {
    "roller_conveyor": ConveyorKind(156, 2.0, 0.56, 0.75, 0.05, 0.10, (0.04, 0.12)),
    "pallet_conveyor": ConveyorKind(157, 2.4, 0.90, 0.50, 0.089, 0.15, (0.06, 0.18)),
}
"""Catalog name -> measures; the pallet conveyor carries EPAL 1 lengthwise."""

_BELOW_ROLLERS = 0.005
_LEG = 0.06


def conveyor(name: str) -> ObjectModel:
    """Build a segment: side profiles with a coloured cover, rollers, the drive's cover below, and two pairs of legs."""
    kind = CONVEYORS[name]
    frame = _frame(kind)
    rollers = _rollers(kind)
    top = kind.height / 2
    bed = solid_box((kind.length, kind.lane, kind.roller), (0.0, 0.0, top - kind.roller / 2))
    size = (kind.length, kind.width, kind.height)
    parts = (*fused(frame), *rollers)
    return model_of(name, "conveyor", kind.obj_id, size, parts, [bed, *collision_boxes(frame)], turns=2)


def _rollers(kind: ConveyorKind) -> list[Part]:
    count = round(kind.length / kind.pitch)
    z = (kind.height - kind.roller) / 2
    size, across = (kind.roller, kind.roller, kind.lane), rotation_x(np.pi / 2)
    places = (np.arange(count) - (count - 1) / 2) * kind.pitch
    return [solid_part(unit_cylinder(16), size, (x, 0.0, z), "galvanised", across) for x in places]


def _frame(kind: ConveyorKind) -> list[Part]:
    """Return everything but the rollers, all of it boxes."""
    thick, high = kind.profile
    top, floor = kind.height / 2, -kind.height / 2
    profile_z = top - _BELOW_ROLLERS - high / 2
    foot, leg_top = 0.012, profile_z - high / 2
    parts = [box_part((kind.length - 0.2, 0.18, 0.10), (0.0, 0.0, top - kind.roller - 0.09), "steel_grey")]
    for side in (-1.0, 1.0):
        y = side * (kind.width - thick) / 2
        parts.append(box_part((kind.length, thick, high), (0.0, y, profile_z), "print_blue"))
        for x in (-0.35 * kind.length, 0.35 * kind.length):
            leg = leg_top - floor - foot
            parts.append(box_part((_LEG, thick, leg), (x, y, floor + foot + leg / 2), "galvanised"))
            inwards = y - side * (0.12 - thick) / 2
            parts.append(box_part((0.12, 0.12, foot), (x, inwards, floor + foot / 2), "galvanised"))
    for x in (-0.35 * kind.length, 0.35 * kind.length):
        parts.append(box_part((0.04, kind.lane, 0.04), (x, 0.0, leg_top - 0.06), "galvanised"))
        parts.append(box_part((0.04, kind.lane, 0.04), (x, 0.0, floor + 0.12), "galvanised"))
    return parts
