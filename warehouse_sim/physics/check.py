"""Is a scene physically possible, and what settling did to it? Answered from boxes, without the physics engine."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from warehouse_sim.errors import SettleError
from warehouse_sim.scene.solids import Solids
from warehouse_sim.schema import SceneSpec


@dataclass(frozen=True)
class SettleReport:
    """Numbers of one settled scene; it is good when ``problems`` is empty."""

    scene_index: int
    seed: int
    stacks: int
    """Stacks of loose objects that were settled, each in a model of its own."""
    duration: float
    """Longest simulated time of a stack until rest (s)."""
    max_speed: float
    """Largest speed of a body at the end (m/s)."""
    max_drift: float
    """Largest distance between a body's first and last place (m), before impulses."""
    max_tilt: float
    """Largest angle between a body's z axis before and after (rad), before impulses."""
    max_overlap: float
    """Largest depth of one object in another (m)."""
    max_gap: float
    """Largest gap between a loose object and the nearest thing under it (m)."""
    lowest: float
    """Lowest point of a loose object over the floor (m); negative is below it."""
    toppled: tuple[int, ...]
    """Instance ids of the bodies that tilted too far, before impulses."""
    struck: tuple[int, ...]
    """Groups of the unit loads that got an impulse."""
    shifted: tuple[int, ...]
    """Instance ids of the pieces that an impulse pushed aside by more than 20 mm, and no further."""
    leaning: tuple[int, ...]
    """Instance ids of the pieces that an impulse left leaning."""
    fallen: tuple[int, ...]
    """Instance ids of the pieces that an impulse brought down."""
    problems: tuple[str, ...]
    """One line each, naming the instances; empty = good."""

    def require_ok(self) -> None:
        """Do nothing for a good scene.

        Raises:
            SettleError: The scene has problems.
        """
        if self.problems:
            shown = "; ".join(self.problems[:3]) + (" ..." if len(self.problems) > 3 else "")
            raise SettleError(
                f"scene {self.scene_index} of seed {self.seed} is not at rest as it should be: {shown}; "
                "take another attempt, or lower the jitter of the recipe"
            )


_SEARCH = 0.03
"""Boxes further apart than this (m) are not looked at; a gap that large is reported as this."""
_LEAST_CLEARANCE = 0.2
"""Least distance from a camera to any object (m)."""
_UPRIGHT = 0.7
"""Least vertical fraction of the axis between two boxes for the lower one to carry the upper one."""


@dataclass(frozen=True, eq=False)
class ContactState:
    """How the objects of a scene touch; arrays over its loose objects and over touching pairs."""

    loose: Int[np.ndarray, " n"]
    """Instance ids of the loose objects."""
    gap: Float[np.ndarray, " n"]
    """Gap (m) between each of them and the nearest thing under it; negative when it sinks in."""
    pairs: Int[np.ndarray, "k 2"]
    """Instance ids of each two objects, one of them loose, that overlap."""
    overlap: Float[np.ndarray, " k"]
    """Depth of each overlap (m), > 0."""
    bottom: Float[np.ndarray, " n"]
    """Lowest point of each loose object over the floor (m)."""
    blocked_viewpoints: tuple[int, ...]
    """Viewpoints, by number, with an object so near that it would fill the image."""

    @property
    def max_gap(self) -> float:
        """The largest gap under a loose object (m), at least 0."""
        return max(0.0, float(self.gap.max(initial=0.0)))

    @property
    def max_overlap(self) -> float:
        """The depth of the deepest overlap (m), 0 when nothing overlaps."""
        return float(self.overlap.max(initial=0.0))

    @property
    def lowest(self) -> float:
        """The lowest point of a loose object over the floor (m), 0 when there is none."""
        return float(self.bottom.min()) if self.bottom.size else 0.0

    def problems(self, max_overlap_mm: float, max_gap_mm: float) -> list[str]:
        """Return one line for each breach of the limits (mm); nothing may be below the floor by the first of them."""
        deep = 1000 * self.overlap > max_overlap_mm
        lines = [
            f"objects {a} and {b} overlap by {1000 * depth:.1f} mm"
            for (a, b), depth in zip(self.pairs[deep], self.overlap[deep], strict=True)
        ]
        lines += [
            f"object {i} floats {1000 * gap:.1f} mm or more above its support"
            for i, gap in zip(self.loose, self.gap, strict=True)
            if 1000 * gap > max_gap_mm
        ]
        lines += [
            f"object {i} is {-1000 * bottom:.1f} mm below the floor"
            for i, bottom in zip(self.loose, self.bottom, strict=True)
            if -1000 * bottom > max_overlap_mm
        ]
        return lines + [
            f"an object is within {_LEAST_CLEARANCE} m of viewpoint {index}" for index in self.blocked_viewpoints
        ]


def contact_state(scene: SceneSpec) -> ContactState:
    """Test the collision boxes of ``scene`` against each other by the separating axis test."""
    solids = Solids.of(scene.instances, scene.models)
    owner, stack = solids.owner, solids.boxes
    loose = solids.of_objects([item.instance_id for item in scene.instances if item.dynamic])
    moving = np.flatnonzero(loose)
    pairs = stack.subset(loose).pairs(stack, _SEARCH)
    pairs[:, 0] = moving[pairs[:, 0]]
    pairs = pairs[owner[pairs[:, 0]] != owner[pairs[:, 1]]]
    result = stack.separation(stack, pairs)
    upper, lower = owner[pairs[:, 0]], owner[pairs[:, 1]]

    ids = np.unique(owner[moving])
    gap = np.full(ids.size, _SEARCH)
    below = result.axis[:, 2] < -_UPRIGHT
    np.minimum.at(gap, np.searchsorted(ids, upper[below]), result.distance[below])

    deep = result.distance < 0.0
    touching = np.sort(np.stack([upper, lower], axis=1)[deep], axis=1)
    unique, which = np.unique(touching, axis=0, return_inverse=True)
    overlap = np.zeros(len(unique))
    np.maximum.at(overlap, which.reshape(-1), -result.distance[deep])
    bottom = np.full(ids.size, np.inf)
    np.minimum.at(bottom, np.searchsorted(ids, owner[moving]), solids.extents[0][moving, 2])
    near = [stack.distances_to(view.T_world_camera[:3, 3]).min(initial=np.inf) for view in scene.viewpoints]
    blocked_viewpoints = tuple(index for index, distance in enumerate(near) if distance < _LEAST_CLEARANCE)
    return ContactState(ids, gap, unique, overlap, bottom, blocked_viewpoints)
