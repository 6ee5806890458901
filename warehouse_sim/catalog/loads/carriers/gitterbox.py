"""The EUR box pallet of UIC 435-3, in German "Gitterbox": steel frame on four feet, walls of mesh, a floor of boards.

Outer 1,240 x 835 x 970 mm, inner 1,200 x 800 x 800 mm, tare 70 kg, payload 1,500 kg (EPAL); mesh of 50 x 50 mm; the
upper half of the front is two flaps. Corners reach over the frame, so that the feet of the next box stand inside them.
"""

import numpy as np

from warehouse_sim.catalog.loads.artwork import barcode, moved, on_side, rectangle, text_lines
from warehouse_sim.catalog.loads.carriers.filling import stacked_cartons
from warehouse_sim.catalog.loads.carriers.wire import bar, ring, wire_panel
from warehouse_sim.catalog.parts import box_part, fused, model_of
from warehouse_sim.schema import ObjectModel, Part

LENGTH, WIDTH, HEIGHT = 1.240, 0.835, 0.970
"""Outer edges (m)."""
TARE = 70.0
GITTERBOXES = {"gitterbox_empty": 301, "gitterbox_cartons": 302, "gitterbox_castings": 303}
"""Catalog name -> obj_id."""
_STEEL = "steel_grey"
_FOOT, _FRAME_LOW, _FRAME_HIGH, _TOP = 0.10, 0.10, 0.155, 0.90
"""Heights of the feet, the lower frame and the upper frame's top (m)."""
_TUBE, _WIRE, _PITCH = 0.04, 0.006, 0.05
_CASTING, _CASTINGS = (0.17, 0.14, 0.11), (6, 4, 4)


def gitterbox(name: str) -> ObjectModel:
    """Build the box called ``name`` ("gitterbox_cartons")."""
    goods, mass = _contents(name)
    size = (LENGTH, WIDTH, HEIGHT)
    return model_of(
        name, "gitterbox", GITTERBOXES[name], size, fused([*_frame(), *_walls(), *_plate(), *goods]), mass=TARE + mass
    )


def _frame() -> list[Part]:
    """Return feet, the two frames, posts, stacking corners and the floor."""
    low = -HEIGHT / 2
    pieces = []
    for x in (-1, 1):
        for y in (-1, 1):
            foot = (x * (LENGTH / 2 - 0.06), y * (WIDTH / 2 - 0.05), low + _FOOT / 2)
            pieces.append(box_part((0.12, 0.10, _FOOT), foot, _STEEL))
            post = (x * (LENGTH / 2 - _TUBE / 2), y * (WIDTH / 2 - _TUBE / 2), low + (_FRAME_LOW + _TOP) / 2)
            pieces.append(box_part((_TUBE, _TUBE, _TOP - _FRAME_LOW), post, _STEEL))
            rise, middle = HEIGHT - _TOP, low + (_TOP + HEIGHT) / 2
            pieces.append(
                box_part((0.12, 0.008, rise), (x * (LENGTH / 2 - 0.06), y * (WIDTH / 2 - 0.004), middle), _STEEL)
            )
            pieces.append(
                box_part((0.008, 0.10, rise), (x * (LENGTH / 2 - 0.004), y * (WIDTH / 2 - 0.05), middle), _STEEL)
            )
    pieces += ring(LENGTH, WIDTH, low + _FRAME_LOW, low + _FRAME_HIGH, _TUBE, _STEEL)
    pieces += ring(LENGTH, WIDTH, low + _TOP - _TUBE, low + _TOP, _TUBE, _STEEL)
    board = (LENGTH - 2 * _TUBE, (WIDTH - 2 * _TUBE) / 5 - 0.008, 0.02)
    for y in (np.arange(5) - 2) * (WIDTH - 2 * _TUBE) / 5:
        pieces.append(box_part(board, (0.0, float(y), low + _FRAME_HIGH - 0.02), "pallet_wood_grey"))
    return pieces


def _walls() -> list[Part]:
    """Return mesh on all sides and the bars of the flaps on the front (-y)."""
    low, high = -HEIGHT / 2 + _FRAME_HIGH, -HEIGHT / 2 + _TOP - _TUBE
    long, short = LENGTH / 2 - _TUBE, WIDTH / 2 - _TUBE
    pieces = []
    for s in (-1, 1):
        pieces += wire_panel(1, s * (WIDTH / 2 - 0.02), (-long, long), (low, high), (_PITCH, _PITCH), _WIRE, _STEEL)
        pieces += wire_panel(0, s * (LENGTH / 2 - 0.02), (-short, short), (low, high), (_PITCH, _PITCH), _WIRE, _STEEL)
    middle, front = (low + high) / 2, -WIDTH / 2 + 0.0125
    pieces += [bar(1, front, (0.0, level), (2 * long, 0.03), 0.025, _STEEL) for level in (middle - 0.02, middle + 0.02)]
    return [
        *pieces,
        *(
            bar(1, front, (s * 0.35 * LENGTH, (middle + high) / 2), (0.03, high - middle), 0.025, _STEEL)
            for s in (-1, 1)
        ),
    ]


def _plate() -> list[Part]:
    """Return the plate of the front with its marks, and a paper label below it."""
    size = (LENGTH, WIDTH, HEIGHT)
    plate = on_side((rectangle(-0.16, 0.10, 0.16, 0.30),), "-y", size, "steel_grey", 0.001, 0.008)
    marks = moved(text_lines(0.26, 0.15, (0.9, 0.7, 0.8, 0.4)), 0.0, 0.2)
    paper = on_side((rectangle(-0.30, -0.22, -0.09, -0.07),), "-y", size, "label_paper", 0.001, 0.008)
    code = moved(barcode(301, 0.17, 0.06), -0.195, -0.16)
    return [
        *plate,
        *paper,
        *on_side(marks, "-y", size, "stencil_white", 0.0, 0.001),
        *on_side(
            (*code, *moved(text_lines(0.17, 0.05, (0.9, 0.6)), -0.195, -0.095)), "-y", size, "print_dark", 0.0, 0.001
        ),
    ]


def _contents(name: str) -> tuple[list[Part], float]:
    """Return what lies in the box and its mass (kg): nothing, cartons, or parts of cast steel."""
    floor = -HEIGHT / 2 + _FRAME_HIGH - 0.01
    if name == "gitterbox_cartons":
        return stacked_cartons((1.14, 0.74, 0.70), floor + 0.002, GITTERBOXES[name])
    if name == "gitterbox_empty":
        return [], 0.0
    rng = np.random.default_rng(GITTERBOXES[name])
    pieces, (columns, rows, layers) = [], _CASTINGS
    for i in range(columns):
        for j in range(rows):
            for k in range(layers if rng.random() < 0.7 else layers - 1):
                centre = ((i - (columns - 1) / 2) * 0.185, (j - (rows - 1) / 2) * 0.18, floor + (k + 0.5) * 0.112)
                turn, size = rng.uniform(-0.12, 0.12), np.array(_CASTING) * rng.uniform(0.85, 1.0)
                c, s = np.cos(turn), np.sin(turn)
                pieces.append(box_part(size, centre, "truck_grey", np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])))
    return pieces, 7.0 * len(pieces)
