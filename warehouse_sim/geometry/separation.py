"""How far apart two boxes are, or how deep one is in the other: the separating axis test."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float, Int

from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.broad_phase import overlapping_pairs


@dataclass(frozen=True, eq=False)
class Separation:
    """Result of the test for n pairs of boxes."""

    distance: Float[np.ndarray, " n"]
    """Gap along the best axis (m), a lower bound of the true distance; negative = depth of the overlap."""
    axis: Float[np.ndarray, "n 3"]
    """That axis in the common frame, unit, pointing from the first box to the second."""


@dataclass(frozen=True, eq=False)
class BoxStack:
    """Boxes of one frame as arrays."""

    centre: Float[np.ndarray, "n 3"]
    """Positions (m)."""
    rotation: Float[np.ndarray, "n 3 3"]
    """Orientations."""
    half: Float[np.ndarray, "n 3"]
    """Half the edge lengths (m)."""

    @classmethod
    def of(cls, boxes: Sequence[OrientedBox]) -> "BoxStack":
        """Stack ``boxes``, which may be none; their parent frame becomes the common frame."""
        T = np.array([box.T_parent_box for box in boxes]).reshape(-1, 4, 4)
        sizes = np.array([box.size for box in boxes], dtype=float).reshape(-1, 3)
        return cls(T[:, :3, 3], T[:, :3, :3], sizes / 2.0)

    def subset(self, chosen: Bool[np.ndarray, " n"]) -> "BoxStack":
        """Return the boxes for which ``chosen`` is set."""
        return BoxStack(self.centre[chosen], self.rotation[chosen], self.half[chosen])

    def distances_to(self, point: Float[np.ndarray, " 3"]) -> Float[np.ndarray, " n"]:
        """Return the distance (m) from ``point`` to each box, 0 inside."""
        local = np.einsum("nij,ni->nj", self.rotation, point - self.centre)
        return np.linalg.norm(np.maximum(np.abs(local) - self.half, 0.0), axis=1)

    def block(self, eye: Float[np.ndarray, " 3"], points: Float[np.ndarray, "m 3"]) -> Bool[np.ndarray, " m"]:
        """Return for each point whether a box lies across the line from ``eye`` to it (slab test)."""
        start = np.einsum("nij,ni->nj", self.rotation, eye - self.centre)[:, None]
        step = np.einsum("nij,nmi->nmj", self.rotation, np.broadcast_to(points - eye, (len(self.half), *points.shape)))
        with np.errstate(divide="ignore", invalid="ignore"):
            one, two = (-self.half[:, None] - start) / step, (self.half[:, None] - start) / step
        # A line parallel to a slab and inside it has one = -inf, two = inf; outside it both have the same sign.
        enter = np.nanmax(np.minimum(one, two), axis=2)
        leave = np.nanmin(np.maximum(one, two), axis=2)
        return np.any((enter < leave) & (leave > 0.0) & (enter < 1.0), axis=0)

    def extents(self) -> tuple[Float[np.ndarray, "n 3"], Float[np.ndarray, "n 3"]]:
        """Return the lower and upper corners (m) of the axis-parallel boxes around each box."""
        return self._extents

    @cached_property
    def _extents(self) -> tuple[Float[np.ndarray, "n 3"], Float[np.ndarray, "n 3"]]:
        reach = np.einsum("nij,nj->ni", np.abs(self.rotation), self.half)
        return self.centre - reach, self.centre + reach

    def near(self, low: Float[np.ndarray, " 3"], high: Float[np.ndarray, " 3"]) -> Bool[np.ndarray, " n"]:
        """Return of each box whether the axis-parallel box around it meets that from ``low`` to ``high`` (m)."""
        lows, highs = self.extents()
        meet = np.ones(len(lows), bool)
        for axis in range(3):
            meet &= (lows[:, axis] <= high[axis]) & (highs[:, axis] >= low[axis])
        return meet

    def pairs(self, other: "BoxStack", margin: float = 0.0) -> Int[np.ndarray, "k 2"]:
        """Return index pairs (self, other) whose axis-parallel boxes come within ``margin`` (m) of each other."""
        (low_a, high_a), (low_b, high_b) = self.extents(), other.extents()
        return overlapping_pairs(low_a - margin, high_a + margin, low_b, high_b)

    def clear_of(self, box: OrientedBox, clearance: float) -> bool:
        """Return whether every box of the stack is at least ``clearance`` (m) away from ``box``."""
        single = BoxStack.of([box])
        pairs = self.pairs(single, clearance)
        return bool(len(pairs) == 0 or self.separation(single, pairs).distance.min() >= clearance)

    def separation(self, other: "BoxStack", pairs: Int[np.ndarray, "k 2"]) -> Separation:
        """Test pairs of boxes over their 15 candidate axes (Gottschalk, Lin and Manocha 1996, section 5)."""
        a, b = pairs[:, 0], pairs[:, 1]
        R_a, R_b = self.rotation[a], other.rotation[b]
        between = other.centre[b] - self.centre[a]
        edges = np.cross(R_a[:, :, :, None], R_b[:, :, None, :], axis=1).reshape(len(pairs), 3, 9)
        axes = np.concatenate([R_a, R_b, edges], axis=2)
        length = np.linalg.norm(axes, axis=1)
        usable = length > 1e-6  # parallel edges span no axis of their own
        axes = axes / np.where(usable, length, 1.0)[:, None, :]
        reach = _reach(axes, R_a, self.half[a]) + _reach(axes, R_b, other.half[b])
        along = np.einsum("kij,ki->kj", axes, between)
        gaps = np.where(usable, np.abs(along) - reach, -np.inf)
        best = np.argmax(gaps, axis=1)
        rows = np.arange(len(pairs))
        sign = np.where(along[rows, best] < 0.0, -1.0, 1.0)
        return Separation(gaps[rows, best], axes[rows, :, best] * sign[:, None])


def _reach(
    axes: Float[np.ndarray, "k 3 j"], rotation: Float[np.ndarray, "k 3 3"], half: Float[np.ndarray, "k 3"]
) -> Float[np.ndarray, "k j"]:
    """Return half the width of each box's shadow on each axis (m)."""
    cosines = np.abs(np.einsum("kij,kil->kjl", axes, rotation))
    return np.einsum("kjl,kl->kj", cosines, half)
