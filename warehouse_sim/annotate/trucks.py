"""Outlines of the trucks that take pallets, as boxes before a face: what must be free when one drives in.

Frame: x into the pallet, y to the left, z up; x = 0 is the plane of the forks' faces (the heel), z = 0 the floor.
Counterbalance and reach truck have the measures of the catalog's (``catalog/traffic``), but for how far the mast of
the reach truck goes out. The others are practical priors, no single maker's.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from warehouse_sim.catalog.traffic.truck_pieces import FORK_LENGTH, FORK_THICKNESS, FORK_WIDTH
from warehouse_sim.catalog.traffic.trucks import FORKLIFT_HEIGHT, REACH_HEIGHT, REACH_WIDTH
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import make_transform

Rising = Literal["stays", "with forks", "up to forks"]
_GROUND = 0.06
"""Trucks begin here (m): thresholds and what lies flat on the floor are driven over."""
_ABOVE_FORKS = 1.19
"""How far backrest and inner mast stand above the middle of the tines (m), as on the catalog's truck."""
_REACH, _SHORT = 0.75, 0.20
"""How far a reach truck pushes its mast out, and how far behind the heel its wheel arms end then (m).

Drawn in, the arms of the catalog's truck end 0.55 m before the heel: what they lack to the guards of uprights, 0.16 m
before the rack, the mast goes out. The way is a practical prior; a turret truck keeps that distance, too.
"""


HEEL_GAP = 0.05
"""How far before the face the heel stops (m)."""
_BEFORE = 0.1
"""From the tips to the face when the truck stands before it (m); from there it drives straight in."""
DRIVE = FORK_LENGTH - HEEL_GAP + _BEFORE
"""How far the truck drives straight in (m), where the pallet is as deep as its tines are long."""


def early_stop(depth: float) -> float:
    """Return how much earlier the truck stops (m), so that its tips do not leave a pallet of this ``depth`` (m)."""
    return max(0.0, FORK_LENGTH - HEEL_GAP - depth)


@dataclass(frozen=True)
class Piece:
    """A box of a truck, symmetric to its middle."""

    rear: float
    """x of its rear side (m), < ``front``."""
    front: float
    width: float
    low: float
    """z of its underside (m); above the middle of the tines for what goes up with them."""
    high: float
    """z of its upper side (m), likewise; of a mast with the forks lowered."""
    rising: Rising = "stays"
    behind: float = 0.0
    """By how much less (m) than the tines it moves, as they are pushed out; inf stands still."""


@dataclass(frozen=True)
class TruckOutline:
    """A truck with its forks, whose tines are those that docking is scored with."""

    mast: tuple[Piece, ...]
    """Carriage with backrest, and mast."""
    body: tuple[Piece, ...]
    lift: float
    """Greatest height of the middle of the tines (m)."""

    @property
    def rear(self) -> float:
        """X of the truck's rear end where it stands before the face (m), the face at 0."""
        return min(piece.rear - self._way(piece, 0.0) for piece in self.body) - HEEL_GAP

    @property
    def enters_lanes(self) -> bool:
        """Whether it can drive farther in than from the aisle's edge."""
        return all(np.isfinite(piece.behind) for piece in self.body)

    def tines(self, height: float, offsets: np.ndarray, from_afar: float, early: float = 0.0) -> Iterator[OrientedBox]:
        """Sweep tines at ``offsets`` (m) beside the middle of the entry; face at x = 0.

        Args:
            height: Of the middle of the tines above the floor (m).
            offsets: To the left of the middle of the entry (m).
            from_afar: How much farther away the truck begins than right before the face (m).
            early: How much earlier it stops (m).
        """
        front, rear = FORK_LENGTH - HEEL_GAP - early, -HEEL_GAP - DRIVE - from_afar
        for offset in offsets:
            yield _box(rear, front, float(offset), FORK_WIDTH, height, FORK_THICKNESS)

    def swept(
        self, pieces: tuple[Piece, ...], height: float, from_afar: float, early: float = 0.0
    ) -> Iterator[OrientedBox]:
        """Sweep ``pieces`` with the tines at ``height`` (m), as ``tines``."""
        for piece in pieces:
            low, high = piece.low, piece.high
            if piece.rising == "with forks":
                low, high = max(low + height, _GROUND), high + height
            elif piece.rising == "up to forks":
                high = max(high, height + _ABOVE_FORKS)
            rear = piece.rear - HEEL_GAP - self._way(piece, from_afar)
            # What stands still is there from the start, wherever the rest stops.
            front = piece.front - HEEL_GAP - min(early, self._way(piece, 0.0))
            yield _box(rear, front, 0.0, piece.width, (low + high) / 2, high - low)

    @staticmethod
    def _way(piece: Piece, from_afar: float) -> float:
        return max(DRIVE - piece.behind, 0.0) + (from_afar if np.isfinite(piece.behind) else 0.0)


def _box(rear: float, front: float, y: float, width: float, z: float, height: float) -> OrientedBox:
    centre = np.array([(rear + front) / 2, y, z])
    return OrientedBox(make_transform(translation=centre), np.array([front - rear, width, height]))


_COUNTERBALANCE = TruckOutline(
    mast=(
        Piece(-0.08, 0.0, 1.0, 0.04, _ABOVE_FORKS, "with forks"),
        Piece(-0.24, -0.08, 0.74, _GROUND, FORKLIFT_HEIGHT, "up to forks"),
    ),
    body=(Piece(-1.99, -0.18, 1.09, _GROUND, 1.02), Piece(-1.75, -0.40, 0.94, 1.02, FORKLIFT_HEIGHT)),
    lift=6.0,
)
TRUCKS: dict[str, TruckOutline] = {
    "counterbalance": _COUNTERBALANCE,
    "any": _COUNTERBALANCE,
    "reach": TruckOutline(
        mast=(
            Piece(-0.08, 0.0, 0.8, 0.04, _ABOVE_FORKS, "with forks"),
            Piece(-0.24, -0.08, 0.74, _GROUND, REACH_HEIGHT, "up to forks"),
        ),
        body=(
            Piece(-1.09, -_SHORT, REACH_WIDTH, _GROUND, 0.30, behind=_REACH),
            Piece(-2.05, -1.09, REACH_WIDTH, _GROUND, 1.12, behind=_REACH),
            Piece(-2.00, -1.13, 1.10, 1.12, 2.19, behind=_REACH),
        ),
        lift=10.0,
    ),
    # It stands along the aisle and pushes its forks out sideways.
    "very_narrow": TruckOutline(
        mast=(Piece(-1.40, -_SHORT, 1.3, -0.1, 2.3, "with forks", behind=np.inf),),
        body=(Piece(-1.40, -_SHORT, 1.3, _GROUND, 3.0, "up to forks", behind=np.inf),),
        lift=13.0,
    ),
    # With the one who pulls it.
    "pallet_jack": TruckOutline(
        mast=(Piece(-0.40, 0.0, 0.55, _GROUND, 1.25),), body=(Piece(-0.80, -0.40, 0.60, _GROUND, 1.80),), lift=0.12
    ),
}
"""Value of ``layout.truck`` in a recipe -> the truck that takes pallets there; "any" is the counterbalance truck."""
