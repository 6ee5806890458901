"""Shipped objects by folder, the volume of a mesh, and how well collision boxes cover what is sampled of an object."""

import numpy as np
from jaxtyping import Float

from warehouse_sim.catalog.shipped import SHIPPED
from warehouse_sim.geometry.mesh import TriangleMesh, sample_surface
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.schema import ObjectModel


def shipped(folder: str) -> tuple[str, ...]:
    """Return the names of the package's objects that a folder of the catalog builds."""
    return tuple(name for name, builder in SHIPPED.items() if f".{folder}." in builder)


def volume(mesh: TriangleMesh) -> float:
    """Return the volume (m^3) that a closed mesh encloses."""
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces], 1, 0)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


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
