"""Composite IBC of 1,000 l: a bottle of HDPE in a cage of galvanised tube, with lid, valve and plate; on its pallet.

1,200 x 1,000 x 1,160 mm over all with the pallet, of which the catalog's 1,200 x 1,000 ones are 144 mm; about 60 kg
empty; a maker lets three more of 1,264 kg stand on one (4,056 kg).
"""

import numpy as np

from warehouse_sim.catalog.loads.artwork import barcode, moved, on_side, rectangle, text_lines
from warehouse_sim.catalog.loads.carriers.wire import bar, stations
from warehouse_sim.catalog.parts import box_part, fused, model_of, slab_part, solid_part
from warehouse_sim.geometry.solids import Outline, unit_cylinder
from warehouse_sim.schema import ObjectModel, Part

LENGTH, WIDTH, HEIGHT = 1.200, 1.000, 1.016
"""Outer edges without the pallet (m)."""
IBCS = {"ibc_1000": (341, "plastic_white", 1040.0), "ibc_1000_black": (342, "plastic_black", 1040.0)}
"""Catalog name -> obj_id, material of the bottle, mass without the pallet (kg)."""
_TUBE, _STEEL = 0.018, "galvanised"


def ibc(name: str) -> ObjectModel:
    """Build the container called ``name`` ("ibc_1000")."""
    obj_id, material, mass = IBCS[name]
    size = (LENGTH, WIDTH, HEIGHT)
    return model_of(name, "ibc", obj_id, size, fused([*_bottle(material), *_cage(), *_plates(obj_id)]), mass=mass)


def _bottle(material: str) -> list[Part]:
    """Return the bottle with a rounded outline and shoulder, the lid on top and the valve low on the front (-x)."""
    low, high = -HEIGHT / 2 + 0.02, HEIGHT / 2 - 0.045
    pieces = [
        slab_part(_rounded(1.14, 0.94, 0.12), low, high - 0.05, material),
        slab_part(_rounded(1.08, 0.88, 0.12), high - 0.05, high - 0.02, material),
        slab_part(_rounded(0.98, 0.78, 0.12), high - 0.02, high, material),
        solid_part(unit_cylinder(20), (0.20, 0.20, 0.03), (0.0, 0.0, high + 0.015), "plastic_black"),
        solid_part(unit_cylinder(20), (0.15, 0.15, 0.012), (0.0, 0.0, high + 0.036), "plastic_red"),
    ]
    lying = np.array([[0, 0, 1.0], [0, 1.0, 0], [-1.0, 0, 0]])
    valve = np.array([-LENGTH / 2 + 0.055, 0.0, low + 0.06])
    pieces.append(solid_part(unit_cylinder(16), (0.09, 0.09, 0.10), valve, "plastic_black", lying))
    pieces.append(box_part((0.02, 0.03, 0.11), valve + np.array([-0.03, 0.0, 0.06]), "plastic_red"))
    return pieces


def _cage() -> list[Part]:
    """Return tubes around the bottle, a tray under it and two tubes over it."""
    low, high = -HEIGHT / 2, HEIGHT / 2
    half_x, half_y, tube = LENGTH / 2 - _TUBE / 2, WIDTH / 2 - _TUBE / 2, _TUBE
    pieces = [box_part((LENGTH, WIDTH, 0.012), (0.0, 0.0, low + 0.006), _STEEL)]
    for s in (-1, 1):
        for y in stations(-half_y, half_y, 0.125):
            # The valve stands in a gap of the front.
            start = 0.24 if s < 0 and abs(y) < 0.10 else 0.0
            pieces.append(bar(0, s * half_x, (y, (low + start + high) / 2), (tube, high - low - start), tube, _STEEL))
        for x in stations(-half_x, half_x, 0.13)[1:-1]:
            pieces.append(bar(1, s * half_y, (x, 0.0), (tube, high - low), tube, _STEEL))
        for z in (low + 0.10, low + 0.34, low + 0.58, low + 0.82, high - tube / 2):
            open_front = s < 0 and z < low + 0.2
            edges = ((-half_y, -0.1), (0.1, half_y)) if open_front else ((-half_y, half_y),)
            pieces += [bar(0, s * half_x, ((a + b) / 2, z), (b - a, tube), tube, _STEEL) for a, b in edges]
            pieces.append(bar(1, s * half_y, (0.0, z), (2 * half_x, tube), tube, _STEEL))
    for x in (-0.27, 0.27):
        pieces.append(box_part((tube, WIDTH - tube, tube), (x, 0.0, high - tube / 2), _STEEL))
    return pieces


def _plates(obj_id: int) -> list[Part]:
    """Return a steel plate with a label on the front and on one long side."""
    size = (LENGTH, WIDTH, HEIGHT)
    plate, paper = rectangle(-0.21, -0.02, 0.21, 0.30), rectangle(-0.15, 0.02, 0.15, 0.23)
    ink = (
        *moved(text_lines(0.26, 0.08, (0.9, 0.6, 0.75, 0.5)), 0.0, 0.18),
        *moved(barcode(obj_id, 0.22, 0.06), 0.0, 0.07),
    )
    pieces: list[Part] = []
    for side in ("-x", "-y"):
        pieces += on_side((plate,), side, size, _STEEL, 0.002, 0.004)
        pieces += on_side((paper,), side, size, "label_paper", 0.001, 0.003)
        pieces += on_side(ink, side, size, "print_dark", 0.0, 0.002)
    return pieces


def _rounded(length: float, width: float, radius: float) -> Outline:
    """Return a rectangle with round corners, counter-clockwise (m)."""
    turns = np.linspace(0.0, np.pi / 2, 6)
    corners = ((1, 1, 0.0), (-1, 1, np.pi / 2), (-1, -1, np.pi), (1, -1, 1.5 * np.pi))
    return tuple(
        (
            float(sx * (length / 2 - radius) + radius * np.cos(start + turn)),
            float(sy * (width / 2 - radius) + radius * np.sin(start + turn)),
        )
        for sx, sy, start in corners
        for turn in turns
    )
