"""Cartons as people label them: one label stuck a little askew, a print on the board, no two alike.

Paper and print are thin slabs under the outer size, as on the catalog's cartons; what they show is a picture, which the
scene chooses through the paint of each carton.
"""

import zlib
from dataclasses import replace

import numpy as np

from warehouse_sim.catalog.loads.cartons import (
    ALL_SKUS,
    PRINT_SKIN,
    STRAP_WIDTH,
    TAPE_DROP,
    TAPE_WIDTH,
    CartonSku,
    carton,
)
from warehouse_sim.catalog.parts import box_part
from warehouse_sim.geometry.pose import make_transform, rotation_z
from warehouse_sim.schema import Material, ObjectModel, Part

LABEL_FACE, BOARD_FACE = "label_face", "board_face"
"""Materials that stand for the label's and the print's picture until a scene chooses them."""
_FACES = (
    Material(LABEL_FACE, (0.80, 0.80, 0.78), 0.6, remission=0.80),
    Material(BOARD_FACE, (0.44, 0.30, 0.175), 0.85, texture="kraft", texture_size=0.4, remission=0.30),
)
_MARGIN = 0.02
_ASPECT = 2**0.5
_SLAB = 0.3 * PRINT_SKIN
_PRINT_RECESS, _LABEL_RECESS = 0.6 * PRINT_SKIN, 0.2 * PRINT_SKIN
_ASKEW = 0.035
"""Standard deviation of a label's angle (rad)."""


def stuck_carton(sku: str, rng: np.random.Generator) -> ObjectModel:
    """Return the carton called ``sku`` with its label and print where ``rng`` puts them; its meaning is unchanged."""
    model, item = carton(sku), ALL_SKUS[sku]
    parts = (*_body(item), *_prints(item, rng), *_label(item, rng))
    tag = zlib.crc32(b"".join(part.T_object_part.tobytes() + part.scale.tobytes() for part in parts))
    return replace(model, name=f"{sku}~{tag:08x}", parts=parts, materials=_FACES)


def board_of(sku: str) -> str:
    """Return the material of the board of the carton called ``sku``."""
    return ALL_SKUS[sku].board


def _body(item: CartonSku) -> list[Part]:
    """Return board, closing tape and what straps the carton has."""
    length, width, height = item.length, item.width, item.height
    skin = 2 * PRINT_SKIN
    body = box_part((length - skin, width - skin, height - PRINT_SKIN), (0.0, 0.0, -PRINT_SKIN / 2), item.board)
    tape = box_part((length, TAPE_WIDTH, TAPE_DROP), (0.0, 0.0, (height - TAPE_DROP) / 2), "tape")
    if item.artwork is None or not item.artwork.straps:
        return [body, tape]
    places = (-0.27 * length, 0.27 * length)
    return [body, tape, *(box_part((STRAP_WIDTH, width, height), (x, 0.0, 0.0), "strap") for x in places)]


def _prints(item: CartonSku, rng: np.random.Generator) -> list[Part]:
    """Return the print on both long sides, in the left half; on both short sides, too, of some cartons."""
    sides = ("-y", "+y", "-x", "+x") if rng.random() < 0.4 else ("-y", "+y")
    parts = []
    for side in sides:
        edge = item.length if side[1] == "y" else item.width
        room = edge - 2 * _MARGIN - (0.9 * item.label[0] if side[1] == "y" and edge > 0.5 else 0.0)
        high = min(0.8 * item.height, room / _ASPECT)
        x = (edge - 2 * _MARGIN - high * _ASPECT) / -2
        parts.append(_slab(item, side, (x, 0.0), (high * _ASPECT, high), _PRINT_RECESS, 0.0, BOARD_FACE))
    return parts


def _label(item: CartonSku, rng: np.random.Generator) -> list[Part]:
    """Return the label where a hand or an applicator puts it: on one side or two, near the right or the middle."""
    high = min(item.label[0] / _ASPECT, 0.15, 0.8 * item.height, (item.width - 2 * _MARGIN) / _ASPECT)
    sides = ("+y", "+x") if rng.random() < 0.5 else (str(rng.choice(["+y", "-y", "+x", "-x"])),)
    parts = []
    for side in sides:
        edge = item.length if side[1] == "y" else item.width
        turn = float(rng.normal(0.0, _ASKEW))
        bound = np.abs([[np.cos(turn), np.sin(turn)], [np.sin(turn), np.cos(turn)]]) @ [high * _ASPECT, high] / 2
        free = np.maximum(np.array([edge, item.height]) / 2 - bound - _MARGIN / 2, 0.0)
        at = np.clip([free[0] - abs(rng.normal(0.0, 0.03)), rng.normal(-0.1 * item.height, 0.03)], -free, free)
        parts.append(
            _slab(item, side, (float(at[0]), float(at[1])), (high * _ASPECT, high), _LABEL_RECESS, turn, LABEL_FACE)
        )
    return parts


def _slab(
    item: CartonSku,
    side: str,
    at: tuple[float, float],
    size: tuple[float, float],
    recess: float,
    turn: float,
    material: str,
) -> Part:
    """Return a slab on a side of the carton, its outer face ``recess`` (m) inside the outer size.

    Args:
        item: The carton.
        side: Which side.
        at: Centre in the side's plane, x to the right and y up seen from outside (m).
        size: Width and height (m).
        recess: Distance from the outer size (m).
        turn: Angle counter-clockwise in the side's plane (rad).
        material: Its material.
    """
    axis, sign = "xy".index(side[1]), -1.0 if side[0] == "-" else 1.0
    out, up = sign * np.eye(3)[axis], np.array([0.0, 0.0, 1.0])
    right = np.cross(up, out)
    half = (item.length, item.width)[axis] / 2
    centre = right * at[0] + up * at[1] + out * (half - recess - _SLAB / 2)
    T_object_part = make_transform(np.column_stack([right, up, out]) @ rotation_z(turn), centre)
    return replace(box_part((*size, _SLAB), (0.0, 0.0, 0.0), material), T_object_part=T_object_part)
