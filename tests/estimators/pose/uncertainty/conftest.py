"""A box of 1.0 x 0.8 x 0.4 m."""

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from warehouse_sim.estimators.pose.icp.surface import CadSurface, build_surface
from warehouse_sim.geometry.boxes import box_corners
from warehouse_sim.geometry.mesh import TriangleMesh


@pytest.fixture(scope="session")
def surface_mesh() -> TriangleMesh:
    corners = box_corners(np.array([1.0, 0.8, 0.4]))
    faces = ConvexHull(corners).simplices
    normals = np.cross(corners[faces[:, 1]] - corners[faces[:, 0]], corners[faces[:, 2]] - corners[faces[:, 0]])
    inward = (normals * corners[faces].mean(axis=1)).sum(axis=1) < 0
    faces[inward] = faces[inward][:, ::-1]
    return TriangleMesh(corners, faces)


@pytest.fixture(scope="session")
def surface(surface_mesh: TriangleMesh) -> CadSurface:
    return build_surface(surface_mesh, 8000, np.random.default_rng(0))
