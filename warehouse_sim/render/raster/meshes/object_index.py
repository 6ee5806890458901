"""Which rows of a part table belong to which object, and which objects can be in view."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int

from warehouse_sim.geometry.camera import PinholeCamera, ViewPyramid
from warehouse_sim.geometry.pose import Transform, invert, transform_points
from warehouse_sim.render.raster.meshes.parts import PartTable
from warehouse_sim.render.raster.projection import NEAR


@dataclass(frozen=True, eq=False)
class ObjectIndex:
    """The objects of a part table, and a sphere around each, so that a view need not look at every part."""

    number: dict[int, int]
    """Place in the arrays below of each instance id."""
    rows: Int[np.ndarray, " n"]
    """All rows of the table, those of one object together, rising."""
    starts: Int[np.ndarray, " k1"]
    """Where in ``rows`` each object begins; one more at the end."""
    centre: Float64[np.ndarray, "k 3"]
    """World position of the middle of each sphere (m)."""
    radius: Float64[np.ndarray, " k"]
    """Its radius (m)."""

    @classmethod
    def of(cls, table: PartTable) -> "ObjectIndex":
        """Find the objects of ``table``."""
        ids, owner = np.unique(table.template["identity"][:, 0], return_inverse=True)
        rows = np.argsort(owner, kind="stable")
        starts = np.searchsorted(owner[rows], np.arange(len(ids) + 1))
        centres = (
            np.einsum("nij,nj->ni", table.T_world_part[:, :3, :3], table.local_centre) + table.T_world_part[:, :3, 3]
        )
        first, reach = starts[:-1], table.radius[:, None]
        low = np.minimum.reduceat((centres - reach)[rows], first)
        high = np.maximum.reduceat((centres + reach)[rows], first)
        middle = (low + high) / 2
        distance = np.linalg.norm(centres - middle[owner], axis=1) + table.radius
        radius = np.maximum.reduceat(distance[rows], first)
        return cls({int(key): k for k, key in enumerate(ids)}, rows, starts, middle, radius)

    def in_view(self, camera: PinholeCamera, T_world_camera: Transform) -> Int[np.ndarray, " k"]:
        """Return the rows, rising, of the objects that reach into the image or nearly do."""
        centre = transform_points(invert(T_world_camera), self.centre)
        touched = ViewPyramid.of(camera).touches(centre, self.radius, NEAR)
        return np.sort(self.rows[np.repeat(touched, np.diff(self.starts))])

    def rows_of(self, instance_ids: Sequence[int]) -> tuple[Int[np.ndarray, " k"], Int[np.ndarray, " k"]]:
        """Return the rows of some objects, rising, and for each the place of its owner in ``instance_ids``."""
        chosen = np.array([self.number[instance_id] for instance_id in instance_ids], int)
        counts = np.diff(self.starts)[chosen]
        within = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
        rows = self.rows[np.repeat(self.starts[chosen], counts) + within]
        owner = np.repeat(np.arange(len(chosen)), counts)
        order = np.argsort(rows, kind="stable")
        return rows[order], owner[order]
