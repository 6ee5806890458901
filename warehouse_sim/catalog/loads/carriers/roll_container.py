"""The roll container of retail: a base on four castors between two side frames of tube and wire, filled with cartons.

724 x 810 mm is the footprint that two of fit across a EUR lorry three abreast (EN 12674 names the styles and leaves the
sizes free); 1,700 mm high, about 35 kg, loaded with up to 500 kg.
"""

import numpy as np

from warehouse_sim.catalog.loads.carriers.filling import stacked_cartons
from warehouse_sim.catalog.loads.carriers.wire import bar, ring, stations, wire_panel
from warehouse_sim.catalog.parts import box_part, fused, model_of, solid_part
from warehouse_sim.geometry.solids import unit_cylinder
from warehouse_sim.schema import ObjectModel, Part

LENGTH, WIDTH, HEIGHT = 0.810, 0.724, 1.700
"""Outer edges (m)."""
TARE = 35.0
ROLL_CONTAINERS = {
    "roll_container_empty": (311, 0.0),
    "roll_container_half": (312, 0.75),
    "roll_container_full": (313, 1.4),
    "roll_container_mixed": (314, 1.15),
}
"""Catalog name -> obj_id and the height up to which it is filled (m)."""
_STEEL, _TUBE, _WIRE = "galvanised", 0.026, 0.005
_WHEEL, _BASE = 0.125, 0.19
"""Diameter of a wheel and height of the base's top (m)."""


def roll_container(name: str) -> ObjectModel:
    """Build the container called ``name`` ("roll_container_full")."""
    obj_id, filled = ROLL_CONTAINERS[name]
    size = (LENGTH, WIDTH, HEIGHT)
    inner = (LENGTH - 0.10, WIDTH - 0.06, filled)
    goods, mass = stacked_cartons(inner, _BASE - HEIGHT / 2, obj_id)
    return model_of(name, "roll_container", obj_id, size, fused([*_base(), *_sides(), *goods]), mass=TARE + mass)


def _base() -> list[Part]:
    """Return the frame with its wires and four castors."""
    low = -HEIGHT / 2
    pieces = ring(LENGTH, WIDTH, low + _BASE - 0.03, low + _BASE, 0.03, _STEEL)
    for y in stations(-WIDTH / 2 + 0.05, WIDTH / 2 - 0.05, 0.06):
        pieces.append(box_part((LENGTH - 0.06, 0.006, 0.006), (0.0, y, low + _BASE - 0.005), _STEEL))
    lying = np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]])
    for x in (-1, 1):
        for y in (-1, 1):
            place = np.array([x * (LENGTH / 2 - 0.10), y * (WIDTH / 2 - 0.08), low + _WHEEL / 2])
            pieces.append(solid_part(unit_cylinder(16), (_WHEEL, _WHEEL, 0.032), place, "rubber", lying))
            pieces.append(solid_part(unit_cylinder(12), (0.07, 0.07, 0.036), place, "plastic_grey", lying))
            pieces.append(box_part((0.07, 0.05, 0.012), place + np.array([0.0, 0.0, _WHEEL / 2 + 0.012]), _STEEL))
            for s in (-1, 1):
                pieces.append(box_part((0.035, 0.005, 0.10), place + np.array([0.0, s * 0.022, 0.03]), _STEEL))
    return pieces


def _sides() -> list[Part]:
    """Return the two side frames (across x), the back (+y) of a few wires and a strap before the front."""
    low, high = _BASE - HEIGHT / 2, HEIGHT / 2
    pieces = []
    for s in (-1, 1):
        x, half = s * (LENGTH / 2 - _TUBE / 2), WIDTH / 2 - _TUBE / 2
        pieces += [bar(0, x, (y, (low + high) / 2), (_TUBE, high - low), _TUBE, _STEEL) for y in (-half, half)]
        pieces += [bar(0, x, (0.0, z), (WIDTH, _TUBE), _TUBE, _STEEL) for z in (high - _TUBE / 2, low + _TUBE / 2)]
        pieces += wire_panel(0, x, (-half + 0.07, half - 0.07), (low, high - _TUBE), (0.1, 0.28), _WIRE, _STEEL)
        pieces.append(bar(0, x, (0.0, low + 0.62), (WIDTH, 0.014), 0.014, _STEEL))
    back = WIDTH / 2 - 0.01
    reach = LENGTH / 2 - _TUBE
    pieces += wire_panel(1, back, (-reach, reach), (low + 0.1, high - 0.3), (0.12, 0.30), _WIRE, _STEEL)
    front = box_part((LENGTH - 2 * _TUBE, 0.004, 0.03), (0.0, -WIDTH / 2 + 0.012, low + 0.70), "strap")
    return [*pieces, front]
