"""The notice of safe loads that EN 15635 wants at every rack: a white plate that says what may stand there.

Frame: x along the plate, its face at -y, z up, origin at the centre of the bounding box.
"""

from functools import cache

import numpy as np

from warehouse_sim.catalog.loads.artwork import moved, on_side, word
from warehouse_sim.catalog.parts import box_part, fused, solid_box
from warehouse_sim.schema import ObjectModel

MOST_PALLET = 1600
"""What a pallet with its load may weigh (kg) where a rack's drawing sets no limit: a little more than the largest safe
working load of a pallet with the pallet."""
_SIZE = (0.6, 0.004, 0.4)
_INK = 0.0005
_LETTERS = 0.046
"""Height of letters and figures (m), to be read from the driver's seat."""


def load_notice(name: str = "load_notice") -> ObjectModel:
    """Build the notice of a rack whose drawing sets no limit: what a pallet may weigh."""
    return _notice(name, (f"PALLET {MOST_PALLET} KG",))


@cache
def load_notice_of(level: int, levels: int, places: int) -> ObjectModel:
    """Build the notice of a rack.

    Args:
        level: What may stand on a level of a bay (kg).
        levels: Levels of beams in a bay.
        places: Pallets on a level.
    """
    lines = (f"LEVEL {level} KG", f"BAY {level * levels} KG", f"PALLET {level // places} KG")
    return _notice(f"load_notice_{level}x{levels}x{places}", lines)


def _notice(name: str, lines: tuple[str, ...]) -> ObjectModel:
    plate = box_part((_SIZE[0], _SIZE[1] - _INK, _SIZE[2]), (0.0, _INK / 2, 0.0), "sign_white")
    face = -_SIZE[1] / 2 + _INK / 2
    parts = [box_part((0.56, _INK, 0.06), (0.0, face, 0.15), "print_blue")]
    parts.append(box_part((0.56, _INK, 0.012), (0.0, face, -0.185), "print_red"))
    for line, height in zip(lines, np.linspace(0.07, 0.07 - 0.1 * (len(lines) - 1), len(lines)), strict=True):
        parts += on_side(moved(word(line, _LETTERS), 0.0, float(height)), "-y", _SIZE, "print_dark", 0.0, _INK)
    return ObjectModel(
        name=name,
        class_name="sign",
        obj_id=121,
        size=np.array(_SIZE),
        parts=(plate, *fused(parts)),
        collision=(solid_box(_SIZE),),
        mass=1.3,
    )
