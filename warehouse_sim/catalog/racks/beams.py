"""Beams with end connectors: plain box beams and step beams, whose inner edge carries decks and bars.

Frame of both: x along the beam, y into the rack, z up, origin at the centre of the bounding box. Clear bay widths for
EPAL 1 pallets short side out, with 75 mm at every gap (EN 15620 class 400, X3-X6 up to 9 m): two pallets 1.825 m,
three 2.7 m, four 3.6 m (3.575 rounded up to the makers' catalogs).
"""

import numpy as np

from warehouse_sim.catalog.parts import box_part, collision_boxes, fused, mesh_part, model_of, solid_box
from warehouse_sim.geometry.solids import prism
from warehouse_sim.schema import ObjectModel, Part

BAY_WIDTH = 2.7
"""Clear width between two frames (m) of the bay for three pallets."""
RACK_BEAMS = {"rack_beam_1825": (112, 1.825), "rack_beam_2700": (111, BAY_WIDTH), "rack_beam_3600": (113, 3.6)}
STEP_BEAMS = {"step_beam_1825": (114, 1.825), "step_beam_2700": (115, BAY_WIDTH), "step_beam_3600": (116, 3.6)}
"""Catalog name -> obj_id and clear width between two frames (m)."""
BAY_WIDTHS = tuple(width for _, width in RACK_BEAMS.values())
"""Clear widths between two frames (m), rising."""
BEAM_HEIGHT, BEAM_DEPTH = 0.12, 0.05
"""Section of a beam along z and y (m)."""
CONNECTOR_HEIGHT = 0.19
"""Height of the plate at a beam's end, flush with the beam's top (m)."""
STEP_HEIGHT, STEP_DEPTH = 0.041, 0.022
"""How far a step beam's ledge lies under its top (1 5/8 in, the usual drop) and how wide it is (m)."""
CONNECTOR_SHEET = 0.004
"""Thickness of a connector (m); on a step beam it stands this far proud of the upright's front."""
CONNECTOR_LEG = 0.045
"""Width of the connector's leg on the front of an upright (m); the beams of both sides fit on 100 mm."""
STEP_BEAM_DEPTH = BEAM_DEPTH + CONNECTOR_SHEET
"""Depth of a step beam along y with its connectors' legs (m)."""

_LEG_SHEET = 0.003
_PAINT = "rack_orange"
_ALONG_X = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])


def rack_beam(name: str) -> ObjectModel:
    """Build a box beam that fits between two uprights; z of the top is half the end plates' height."""
    obj_id, length = RACK_BEAMS[name]
    top = CONNECTOR_HEIGHT / 2
    lower = CONNECTOR_HEIGHT - BEAM_HEIGHT
    body = box_part((length, BEAM_DEPTH, BEAM_HEIGHT), (0.0, 0.0, top - BEAM_HEIGHT / 2), _PAINT)
    ends: list[Part] = []
    for side in (-1.0, 1.0):
        plate_x, leg_x = side * (length - CONNECTOR_SHEET) / 2, side * (length - CONNECTOR_LEG) / 2
        ends.append(box_part((CONNECTOR_SHEET, BEAM_DEPTH, lower), (plate_x, 0.0, -top + lower / 2), _PAINT))
        for face in (-1.0, 1.0):
            y = face * (BEAM_DEPTH - CONNECTOR_SHEET) / 2
            ends.append(box_part((CONNECTOR_LEG, CONNECTOR_SHEET, lower), (leg_x, y, -top + lower / 2), _PAINT))
    solid = [solid_box((length, BEAM_DEPTH, BEAM_HEIGHT), (0.0, 0.0, top - BEAM_HEIGHT / 2))]
    for side in (-1.0, 1.0):
        at = (side * (length - CONNECTOR_LEG) / 2, 0.0, -top + lower / 2)
        solid.append(solid_box((CONNECTOR_LEG, BEAM_DEPTH, lower), at))
    size = (length, BEAM_DEPTH, CONNECTOR_HEIGHT)
    return model_of(name, "rack", obj_id, size, fused([body, *ends]), solid, turns=2)


def step_beam(name: str) -> ObjectModel:
    """Build a step beam: front at -y, ledge at +y, connectors over the uprights' fronts.

    Its body lies between the uprights, ``CONNECTOR_SHEET`` behind the bounding box's front; the connectors' legs reach
    ``CONNECTOR_LEG`` over the uprights on both sides. The back beam of a level is the same one, turned by half.
    """
    obj_id, length = STEP_BEAMS[name]
    top, lower = CONNECTOR_HEIGHT / 2, CONNECTOR_HEIGHT - BEAM_HEIGHT
    middle, back = CONNECTOR_SHEET / 2, STEP_BEAM_DEPTH / 2
    front = back - BEAM_DEPTH
    bottom, step = top - BEAM_HEIGHT, top - STEP_HEIGHT
    # The section is sampled in (y, z) and extruded along its own z, which is then laid along x.
    section = ((front, bottom), (back, bottom), (back, step), (back - STEP_DEPTH, step), (back - STEP_DEPTH, top))
    body = mesh_part(prism((*section, (front, top)), length), _PAINT, rotation=_ALONG_X)
    plates: list[Part] = []
    pins: list[Part] = []
    for side in (-1.0, 1.0):
        x = side * (length - CONNECTOR_SHEET) / 2
        plates.append(box_part((CONNECTOR_SHEET, BEAM_DEPTH, lower), (x, middle, -top + lower / 2), _PAINT))
        leg = (side * (length + CONNECTOR_LEG) / 2, front - _LEG_SHEET / 2, 0.0)
        plates.append(box_part((CONNECTOR_LEG, _LEG_SHEET, CONNECTOR_HEIGHT), leg, _PAINT))
        # The lock that keeps a lifted beam on its upright (EN 15512); its head lies on the leg.
        pin = (side * (length / 2 + 0.028), front - CONNECTOR_SHEET / 2, 0.02)
        pins.append(box_part((0.012, CONNECTOR_SHEET, 0.03), pin, "galvanised"))
    lower_solid = solid_box((length, BEAM_DEPTH, BEAM_HEIGHT - STEP_HEIGHT), (0.0, middle, (bottom + step) / 2))
    upper_depth = BEAM_DEPTH - STEP_DEPTH
    upper_solid = solid_box((length, upper_depth, STEP_HEIGHT), (0.0, front + upper_depth / 2, top - STEP_HEIGHT / 2))
    solid = (lower_solid, upper_solid, *collision_boxes(plates))
    size = (length + 2 * CONNECTOR_LEG, STEP_BEAM_DEPTH, CONNECTOR_HEIGHT)
    return model_of(name, "rack", obj_id, size, fused([body, *plates, *pins]), solid)
