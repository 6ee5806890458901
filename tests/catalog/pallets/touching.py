"""Exact tests of what lies inside a box, and whether a mesh is closed."""

import numpy as np

from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.geometry.pose import invert, make_transform, transform_points
from warehouse_sim.schema import ObjectModel, Pocket


def reaches_into(mesh: TriangleMesh, T_object_box: np.ndarray, size: np.ndarray) -> bool:
    """Return whether a triangle reaches into a box (separating axes: box normals, triangle normal, edge products)."""
    corners = transform_points(invert(T_object_box), mesh.vertices)[mesh.faces]
    half = np.asarray(size) / 2
    near = np.all((corners.min(axis=1) < half) & (corners.max(axis=1) > -half), axis=1)
    corners = corners[near]
    edges = np.roll(corners, -1, axis=1) - corners
    normal = np.cross(edges[:, 0], edges[:, 1])[:, None]
    products = np.cross(edges[:, :, None], np.eye(3)).reshape(-1, 9, 3)
    axes = np.concatenate([normal, products], axis=1)
    along = np.einsum("taj,tcj->tac", axes, corners)
    reach = np.abs(axes) @ half
    usable = np.linalg.norm(axes, axis=2) > 1e-12  # an edge along a box axis spans none with it
    apart = usable & ((along.min(axis=2) >= reach - 1e-12) | (along.max(axis=2) <= -reach + 1e-12))
    return bool(np.any(~apart.any(axis=1)))


def prism_of(pocket: Pocket, grow: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> tuple[np.ndarray, np.ndarray]:
    """Return pose and size of the box that a pocket is, enlarged by ``grow`` (m) in its own frame."""
    middle = make_transform(translation=np.array([pocket.size[0] / 2, 0.0, 0.0]))
    return pocket.T_object_pocket @ middle, pocket.size + grow


def hits(model: ObjectModel, T_object_box: np.ndarray, size: np.ndarray) -> bool:
    """Return whether any part of ``model`` reaches into a box."""
    return reaches_into(model.mesh(), T_object_box, size)


def is_closed(mesh: TriangleMesh) -> bool:
    """Return whether each edge has two faces that run along it in opposite directions."""
    edges = mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    pairs = {tuple(edge) for edge in edges.tolist()}
    return len(pairs) == len(edges) and all((b, a) in pairs for a, b in pairs)


def same_points(a: np.ndarray, b: np.ndarray) -> bool:
    """Return whether two point sets agree to a nanometre."""
    rows = [{tuple(row) for row in np.round(points, 9) + 0.0} for points in (a, b)]
    return rows[0] == rows[1]
