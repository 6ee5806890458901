"""The EPAL 1 pallet, board by board.

Pieces and order follow EPAL's published construction (11 boards, 9 blocks, 78 nails, about 25 kg); the gaps between
deck boards and the fork windows follow from them. Frame: origin at the centre of the 1200 x 800 x 144 mm bounding box,
x along 1200, y along 800, z up.
"""

import numpy as np
from jaxtyping import Float

from warehouse_sim.catalog.parts import box_part, collision_boxes, solid_box
from warehouse_sim.errors import UnknownNameError
from warehouse_sim.geometry.pose import make_transform
from warehouse_sim.geometry.symmetry import SymmetryGroup
from warehouse_sim.schema import ObjectModel, Part, Pocket

LENGTH, WIDTH, HEIGHT = 1.2, 0.8, 0.144
BOARD, BLOCK = 0.022, 0.078
"""Thickness of a board and height of a block (m)."""
WIDE, NARROW = 0.145, 0.100
"""The two widths of boards and blocks (m)."""

_BOTTOM_TOP = BOARD
_BLOCK_TOP = BOARD + BLOCK
_CROSS_TOP = _BLOCK_TOP + BOARD

_LOOKS = {
    "epal1": ("pallet_wood", "pallet_block"),
    "epal1_new": ("pallet_wood_new", "pallet_block"),
    "epal1_grey": ("pallet_wood_grey", "pallet_block_grey"),
}
"""One geometry in three ages: used, new, weathered."""


def epal1(name: str = "epal1") -> ObjectModel:
    """Build the EPAL 1 pallet; its three looks ("epal1", "epal1_new", "epal1_grey") are one geometry, obj_id 1.

    Raises:
        UnknownNameError: ``name`` is none of the three looks.
    """
    if name not in _LOOKS:
        raise UnknownNameError("look of the EPAL 1 pallet", name, list(_LOOKS))
    board, block = _LOOKS[name]
    deck = _deck_boards(board)
    frame = [*_cross_boards(board), *_blocks(block), *_bottom_boards(board)]
    # Physics sees the deck as one plate: nothing that stands on it is small enough to feel the 41 mm gaps.
    plate = solid_box((LENGTH, WIDTH, BOARD), (0.0, 0.0, _centre_z(_CROSS_TOP, HEIGHT)))
    return ObjectModel(
        name=name,
        class_name="pallet",
        obj_id=1,
        size=np.array([LENGTH, WIDTH, HEIGHT]),
        parts=(*deck, *frame),
        collision=(plate, *collision_boxes(frame)),
        mass=25.0,
        symmetry=SymmetryGroup.turns("z", 2),
        pockets=_pockets(),
    )


def _centre_z(bottom: float, top: float) -> float:
    """Return the z in the object frame midway between two heights above the ground (m)."""
    return (bottom + top) / 2.0 - HEIGHT / 2.0


def _lanes() -> tuple[tuple[float, float], ...]:
    """Return (y, width) of the three rows of blocks that run along x."""
    edge = (WIDTH - NARROW) / 2.0
    return (-edge, NARROW), (0.0, WIDE), (edge, NARROW)


def _columns() -> tuple[float, ...]:
    """Return x of the three rows of blocks that run along y, all 145 mm long."""
    edge = (LENGTH - WIDE) / 2.0
    return -edge, 0.0, edge


def _deck_boards(material: str) -> list[Part]:
    """Return the five top boards along x, in the order 145-100-145-100-145 with equal gaps of 41.25 mm."""
    widths = (WIDE, NARROW, WIDE, NARROW, WIDE)
    gap = (WIDTH - sum(widths)) / 4.0
    starts = np.cumsum([0.0, *(width + gap for width in widths[:-1])]) - WIDTH / 2.0
    z = _centre_z(_CROSS_TOP, HEIGHT)
    return [
        box_part((LENGTH, width, BOARD), (0.0, start + width / 2.0, z), material)
        for start, width in zip(starts, widths, strict=True)
    ]


def _cross_boards(material: str) -> list[Part]:
    """Return the three boards along y that carry the deck."""
    z = _centre_z(_BLOCK_TOP, _CROSS_TOP)
    return [box_part((WIDE, WIDTH, BOARD), (x, 0.0, z), material) for x in _columns()]


def _blocks(material: str) -> list[Part]:
    """Return the nine blocks: six of 145 x 100 mm outside and three of 145 x 145 mm in the middle lane."""
    z = _centre_z(_BOTTOM_TOP, _BLOCK_TOP)
    return [box_part((WIDE, width, BLOCK), (x, y, z), material) for x in _columns() for y, width in _lanes()]


def _bottom_boards(material: str) -> list[Part]:
    """Return the three boards along x on the ground, one under each lane of blocks."""
    z = _centre_z(0.0, _BOTTOM_TOP)
    return [box_part((LENGTH, width, BOARD), (0.0, y, z), material) for y, width in _lanes()]


def _pockets() -> tuple[Pocket, ...]:
    """Return the two pockets of each of the four faces.

    Between the lanes nothing lies on the ground, so the 800 mm faces open from the ground to the cross boards; between
    the columns the bottom boards lie across, so the 1200 mm faces open from their top to the deck.
    """
    narrow = (WIDTH - 2 * NARROW - WIDE) / 2.0
    wide = (LENGTH - 3 * WIDE) / 2.0
    ends = [
        (face, sign * np.array([LENGTH / 2, 0, 0]), np.array([-sign, 0.0]), (LENGTH, narrow), (0.0, _BLOCK_TOP), WIDE)
        for face, sign in (("-x", -1.0), ("+x", 1.0))
    ]
    sides = [
        (face, sign * np.array([0, WIDTH / 2, 0]), np.array([0.0, -sign]), (WIDTH, wide), (BOARD, _CROSS_TOP), WIDE)
        for face, sign in (("-y", -1.0), ("+y", 1.0))
    ]
    pockets = []
    for face, face_centre, inwards, (depth, width), (bottom, top), middle in ends + sides:
        for side in (-1.0, 1.0):
            rotation = _facing(inwards)
            centre = face_centre + side * (middle + width) / 2.0 * rotation[:, 1]
            centre[2] = _centre_z(bottom, top)
            size = np.array([depth, width, top - bottom])
            pockets.append(Pocket(face, make_transform(rotation, centre), size))
    return tuple(pockets)


def _facing(inwards: Float[np.ndarray, " 2"]) -> Float[np.ndarray, "3 3"]:
    """Return the rotation whose x axis is the horizontal unit vector ``inwards`` and whose z axis is up."""
    x, y = inwards
    return np.array([[x, -y, 0.0], [y, x, 0.0], [0.0, 0.0, 1.0]])
