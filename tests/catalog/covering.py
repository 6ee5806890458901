"""How well an object's collision boxes cover what is sampled of it."""

import numpy as np
from jaxtyping import Float

from warehouse_sim.geometry.mesh import sample_surface
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.schema import ObjectModel


def bare_distances(model: ObjectModel) -> Float[np.ndarray, " n"]:
    """Return the distance (m) of points all over the surface from the nearest collision box, 0 inside one."""
    mesh, boxes = model.mesh(), BoxStack.of(model.collision)
    points, _ = sample_surface(mesh, 1500, np.random.default_rng(0))
    points = np.concatenate([points, mesh.vertices[:: max(1, len(mesh.vertices) // 1000)]])
    local = np.einsum("nij,nmi->nmj", boxes.rotation, points[None] - boxes.centre[:, None])
    return np.linalg.norm(np.maximum(np.abs(local) - boxes.half[:, None], 0.0), axis=2).min(axis=0)


def filled_fraction(model: ObjectModel) -> float:
    """Return the fraction of the bounding box that collision boxes fill, at random points."""
    boxes = BoxStack.of(model.collision)
    points = (np.random.default_rng(1).random((2000, 3)) - 0.5) * model.size
    local = np.einsum("nij,nmi->nmj", boxes.rotation, points[None] - boxes.centre[:, None])
    return float((np.abs(local) <= boxes.half[:, None]).all(axis=2).any(axis=0).mean())
