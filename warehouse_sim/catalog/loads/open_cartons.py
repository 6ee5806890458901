"""Cartons that pickers take from: their flaps stand open or ajar over what is left in them.

A regular slotted carton has four flaps as deep as half its width (FEFCO 0201). They stay within the carton's outline,
so that nothing beside it is in their way. The origin is the centre of the box around body and flaps.
"""

import numpy as np

from warehouse_sim.catalog.loads.cartons import ALL_SKUS, PRINT_SKIN, TAPE_DROP, TAPE_WIDTH, CartonSku, carton_prints
from warehouse_sim.catalog.parts import box_part, fused, model_of
from warehouse_sim.geometry.pose import make_transform, rotation_x
from warehouse_sim.schema import ObjectModel, Part

_FIRST_ID = 930
_LEANS = {"open": (9.0, 21.0), "ajar": (58.0, 44.0)}
"""Way in the catalog name -> how far the flaps of both long sides lean inwards from upright (deg)."""
OPEN_CARTONS = {f"{sku}_{way}": (sku, way) for sku in ALL_SKUS for way in _LEANS}
"""Catalog name -> SKU and how it stands open."""
_BOARD = {1: 0.004, 2: 0.007}
"""Walls -> thickness of the board (m)."""
_LEFT = 0.78
"""Height to which an open carton is still filled, as a fraction of its own."""
_MASS_LEFT = 0.75
_PACK = 0.11
"""Edge of the packs in it (m), about."""


def open_carton_of(name: str) -> ObjectModel:
    """Build the open carton called ``name`` ("carton_600x400x300_open", "carton_600x400x300_ajar")."""
    sku, way = OPEN_CARTONS[name]
    item = ALL_SKUS[sku]
    loose = [*_body(item), *_packs(item), *_flaps(item, way)]
    low, high = np.min([_low(part) for part in loose], axis=0), np.max([_high(part) for part in loose], axis=0)
    size = np.array([item.length, item.width, high[2] - low[2]])
    T_box_body = make_transform(translation=np.array([0.0, 0.0, -(low[2] + high[2]) / 2]))
    parts = fused([*loose, *carton_prints(item)])
    return model_of(
        name,
        "carton",
        _FIRST_ID + list(OPEN_CARTONS).index(name),
        size,
        tuple(Part(part.mesh, part.scale, T_box_body @ part.T_object_part, part.material) for part in parts),
        mass=_MASS_LEFT * item.density * item.length * item.width * item.height,
        bears=0.0,
    )


def _body(item: CartonSku) -> list[Part]:
    """Return bottom, four walls and what is left of the tape; print lies on them up to the outer size."""
    board, height = _BOARD[item.walls], item.height
    length, width = item.length - 2 * PRINT_SKIN, item.width - 2 * PRINT_SKIN
    parts = [box_part((length, width, board), (0.0, 0.0, (board - height) / 2), item.board)]
    for side in (-1.0, 1.0):
        parts.append(box_part((board, width, height), (side * (length - board) / 2, 0.0, 0.0), item.board))
        tape = (side * (item.length - PRINT_SKIN) / 2, 0.0, (height - TAPE_DROP) / 2)
        parts.append(box_part((PRINT_SKIN, TAPE_WIDTH, TAPE_DROP), tape, "tape"))
        parts.append(box_part((length - 2 * board, board, height), (0.0, side * (width - board) / 2, 0.0), item.board))
    return parts


def _packs(item: CartonSku) -> list[Part]:
    """Return what is left in it: packs side by side, a few of them taken out of the upper layer."""
    board = _BOARD[item.walls]
    inner = np.array([item.length, item.width]) - 2 * (PRINT_SKIN + board) - 0.004
    count = np.maximum(np.round(inner / _PACK), 1).astype(int)
    edge = inner / count
    rng = np.random.default_rng(item.obj_id)
    paint = ("board_white", "print_blue", "print_red", "kraft_light", "print_green")[item.obj_id % 5]
    parts = []
    for x in range(count[0]):
        for y in range(count[1]):
            tall = item.height * (_LEFT if rng.random() > 0.25 else 0.5 * _LEFT) - board
            at = (np.array([x, y]) - (count - 1) / 2) * edge
            middle = (float(at[0]), float(at[1]), board + tall / 2 - item.height / 2)
            parts.append(box_part((edge[0] - 0.003, edge[1] - 0.003, tall), middle, paint))
    return parts


def _flaps(item: CartonSku, way: str) -> list[Part]:
    """Return the flaps: those of the short sides upright or folded in, those of the long sides leaning inwards."""
    board, depth, top = _BOARD[item.walls], item.width / 2, item.height / 2
    length, width = item.length - 2 * PRINT_SKIN, item.width - 2 * PRINT_SKIN
    parts = []
    for side, lean in zip((-1.0, 1.0), np.deg2rad(_LEANS[way]), strict=True):
        turn = rotation_x(side * lean)
        hinge = np.array([0.0, side * (width / 2 - board), top + board * np.sin(lean)])
        middle = hinge + turn @ np.array([0.0, 0.0, depth / 2])
        parts.append(box_part((length - 2 * board - 0.004, board, depth), middle, item.board, turn))
        if way == "open":
            at = (side * (length - board) / 2, 0.0, top + depth / 2)
            parts.append(box_part((board, width - 2 * board, depth), at, item.board))
        else:
            reach = min(depth, length / 2 - board - 0.002)
            at = (side * (length / 2 - board - reach / 2), 0.0, top - board / 2 - 0.001)
            parts.append(box_part((reach, width - 2 * board - 0.002, board), at, item.board))
    return parts


def _low(part: Part) -> np.ndarray:
    return part.placed().vertices.min(axis=0)


def _high(part: Part) -> np.ndarray:
    return part.placed().vertices.max(axis=0)
