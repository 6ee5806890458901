"""Cartons: a finite list of SKUs on the ISO 3394 modules, so that sizes are exact and BOP models few."""

from dataclasses import dataclass

import numpy as np

from warehouse_sim.catalog.parts import box_part, solid_box
from warehouse_sim.errors import UnknownNameError
from warehouse_sim.geometry.symmetry import SymmetryGroup
from warehouse_sim.schema import ObjectModel

TAPE_WIDTH, TAPE_DROP = 0.05, 0.07
"""Width of the closing tape and how far it reaches down the two ends (m)."""
SKIN = 0.0005
"""How far tape and labels stand proud of the board (m); the outer size includes it."""


@dataclass(frozen=True)
class CartonSku:
    """One stock-keeping unit."""

    obj_id: int
    """Number of the geometry, fixed for ever."""
    length: float
    """Outer edge along x (m)."""
    width: float
    """Outer edge along y (m)."""
    height: float
    """Outer edge along z (m)."""
    density: float
    """Mass over outer volume (kg/m^3); filled consumer cartons weigh 80-250."""
    board: str
    """Material of the body."""
    label: tuple[float, float]
    """Width and height (m) of the label on both long sides."""
    label_material: str = "label_paper"
    """Material of the label."""

    @property
    def name(self) -> str:
        """The catalog name, from the size in millimetres."""
        return "carton_" + "x".join(str(round(1000 * edge)) for edge in (self.length, self.width, self.height))


SKUS = {
    sku.name: sku
    for sku in (
        CartonSku(11, 0.6, 0.4, 0.40, 120.0, "kraft", (0.148, 0.105)),
        CartonSku(12, 0.6, 0.4, 0.30, 150.0, "kraft_light", (0.30, 0.12), "print_blue"),
        CartonSku(13, 0.6, 0.4, 0.22, 180.0, "kraft_dark", (0.148, 0.105)),
        CartonSku(14, 0.4, 0.3, 0.30, 160.0, "kraft", (0.20, 0.14), "print_dark"),
        CartonSku(15, 0.4, 0.3, 0.20, 200.0, "board_white", (0.26, 0.08), "print_red"),
        CartonSku(16, 0.3, 0.2, 0.20, 220.0, "kraft_light", (0.105, 0.074)),
    )
}


def carton(sku: str) -> ObjectModel:
    """Build the carton called ``sku`` ("carton_600x400x300").

    Three boxes make it: the body, the tape that closes it along x, and a band that shows as a label or print on both
    long sides. Its look repeats after a half turn about z; the tape tells top from bottom.

    Raises:
        UnknownNameError: ``sku`` is not in ``SKUS``.
    """
    if sku not in SKUS:
        raise UnknownNameError("carton SKU", sku, list(SKUS))
    item = SKUS[sku]
    length, width, height = item.length, item.width, item.height
    body = box_part((length - 2 * SKIN, width - 2 * SKIN, height - SKIN), (0.0, 0.0, -SKIN / 2), item.board)
    tape = box_part((length, TAPE_WIDTH, TAPE_DROP), (0.0, 0.0, (height - TAPE_DROP) / 2), "tape")
    label = box_part((item.label[0], width, item.label[1]), (0.0, 0.0, -0.1 * height), item.label_material)
    return ObjectModel(
        name=sku,
        class_name="carton",
        obj_id=item.obj_id,
        size=np.array([length, width, height]),
        parts=(body, tape, label),
        collision=(solid_box((length, width, height)),),
        mass=item.density * length * width * height,
        symmetry=SymmetryGroup.turns("z", 2),
    )
