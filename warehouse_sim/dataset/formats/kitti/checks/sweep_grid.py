"""Which beam stands beside which in a sweep: rings over azimuths."""

from typing import Self

import numpy as np
from jaxtyping import Bool, Float, Int, Int32

from warehouse_sim.dataset.formats.kitti.checks.lidar_law import LidarLaw

_NOTHING = np.int32(-1)
_SIDES = ((0, -1), (0, 1), (-1, 0), (1, 0))


class SweepGrid:
    """A sweep's points on a grid of rings and azimuths.

    Args:
        ring: Of each point, 0 = topmost.
        column: Of each point, along the ring.
        ids: Instance id of each point.
    """

    def __init__(
        self, ring: Int[np.ndarray, " n"], column: Int[np.ndarray, " n"], ids: Int32[np.ndarray, " n"]
    ) -> None:
        self._ring, self._column = ring + 1, column
        self._ids = np.full((int(ring.max(initial=0)) + 3, int(column.max(initial=0)) + 1), _NOTHING)
        self._ids[self._ring, column] = ids

    @classmethod
    def of(
        cls,
        points: Float[np.ndarray, "n 3"],
        ids: Int32[np.ndarray, " n"],
        beams: tuple[Int[np.ndarray, " n"], Float[np.ndarray, " n"]],
        law: LidarLaw,
    ) -> Self:
        """Put points of the LiDAR's frame (m) on the grid.

        A ring fires once a cycle, but its laser may look beside the head: by how much shows in its points.

        Args:
            points: In the LiDAR's frame (m).
            ids: Instance id of each.
            beams: Ring and time (s) of each.
            law: The LiDAR's.
        """
        ring, time = beams
        if len(points) == 0:
            return cls(ring, ring, ids)
        count = max(round(360.0 / law.azimuth_step_deg), 1)
        # The first laser of a cycle fires with it, but for rounding.
        cycle = np.floor(time / law.cycle_time + 1e-3).astype(np.int64)
        if law.turns_clockwise:
            cycle = -cycle
        azimuth = np.degrees(np.arctan2(points[:, 1], points[:, 0])) - law.azimuth_range_deg[0]
        ahead = (azimuth / law.azimuth_step_deg - cycle + count / 2) % count - count / 2
        order = np.argsort(ring.astype(np.int16), kind="stable")  # of 16 bits, as those are sorted in one pass
        for chosen in np.split(order, np.flatnonzero(np.diff(ring[order])) + 1):
            cycle[chosen] += round(float(np.median(ahead[chosen])))
        return cls(ring, cycle % count, ids)

    def beside_another(self, points: Int[np.ndarray, " m"], instance_id: int) -> Bool[np.ndarray, " m"]:
        """Return which of an object's points have a beam beside, above or below them that did not meet the object."""
        ring, column = self._ring[points], self._column[points]
        there = [self._ids[ring + down, (column + along) % self._ids.shape[1]] for down, along in _SIDES]
        return (np.array(there) != instance_id).any(axis=0)
