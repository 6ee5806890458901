"""The sides of a pallet that forks can enter, as a truck on the floor sees them."""

from dataclasses import dataclass

import numpy as np

from warehouse_sim.catalog.traffic.truck_pieces import FORK_SPREAD, FORK_WIDTH
from warehouse_sim.geometry.pose import Transform, make_transform, rotation_z
from warehouse_sim.schema import ObjectInstance, Pocket, SceneSpec

_BESIDE = 0.02
"""Room (m) beside each of two tines that share one pocket."""


@dataclass(frozen=True, eq=False)
class Approach:
    """One side of a pallet, and where the tines must be to enter it."""

    face: str
    T_object_dock: Transform
    """Origin at the middle of the openings, x inwards, z up."""
    T_world_floor: Transform
    """Below that origin on the floor (z = 0): level, x inwards."""
    height: float
    """Of the middle of the openings above the floor (m)."""
    spread: float
    """Between the middles of the tines (m)."""
    clear_width: float
    """For each tine (m)."""
    clear_height: float

    @classmethod
    def of(cls, scene: SceneSpec, item: ObjectInstance) -> "list[Approach]":
        """Return the sides of ``item`` that have pockets, the one that a viewpoint is nearest to first."""
        sides: dict[str, list[Pocket]] = {}
        for pocket in scene.model_of(item).pockets:
            sides.setdefault(pocket.face, []).append(pocket)
        eyes = [view.T_world_camera[:3, 3] for view in scene.viewpoints] or [np.zeros(3)]

        def nearness(way: "Approach") -> float:
            before = way.T_world_floor[:3, 3] - 2.0 * way.T_world_floor[:3, 0]
            return min(float(np.linalg.norm((eye - before)[:2])) for eye in eyes)

        return sorted((cls._side(item, face, pockets) for face, pockets in sides.items()), key=nearness)

    @classmethod
    def _side(cls, item: ObjectInstance, face: str, pockets: list[Pocket]) -> "Approach":
        rotation = pockets[0].T_object_pocket[:3, :3]
        places = np.array([pocket.T_object_pocket[:3, 3] for pocket in pockets])
        across = places @ rotation[:, 1]
        outer = pockets[int(across.argmin())], pockets[int(across.argmax())]
        spread, width = float(np.ptp(across)), min(float(pocket.size[1]) for pocket in outer)
        if len(pockets) == 1:  # two tines in one opening
            spread = min(FORK_SPREAD, width - FORK_WIDTH - 2 * _BESIDE)
            width = width / 2 if spread > FORK_WIDTH else 0.0
        middle = (outer[0].T_object_pocket[:3, 3] + outer[1].T_object_pocket[:3, 3]) / 2
        T_object_dock = make_transform(rotation, middle)
        T_world_dock = item.T_world_object @ T_object_dock
        forward, (x, y, z) = T_world_dock[:3, 0], T_world_dock[:3, 3]
        level = make_transform(rotation_z(float(np.arctan2(forward[1], forward[0]))), np.array([x, y, 0.0]))
        clear_height = min(float(pocket.size[2]) for pocket in outer)
        return cls(face, T_object_dock, level, float(z), spread, width, clear_height)
