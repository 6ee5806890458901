"""Geometry as glTF meshes: one for each look, whose vertices are stored once for all looks of a model."""

import numpy as np
from jaxtyping import Float

from warehouse_sim.interchange.glb.container import GlbContainer
from warehouse_sim.interchange.glb.materials import GlbMaterials
from warehouse_sim.render.painted_mesh import PaintedMesh, painted_meshes
from warehouse_sim.schema import ObjectInstance, SceneSpec


class GlbMeshes:
    """The meshes of a scene in a file, each added when it is first requested."""

    def __init__(self, container: GlbContainer, scene: SceneSpec, materials: GlbMaterials) -> None:
        self._container, self._scene, self._materials = container, scene, materials
        self._made: dict[object, int | None] = {}

    def index(self, instance: ObjectInstance) -> int | None:
        """Return the index in the file of what ``instance`` looks like; None where nothing is to be seen of it."""
        if instance.look not in self._made:
            self._made[instance.look] = self._add(instance)
        return self._made[instance.look]

    def _add(self, instance: ObjectInstance) -> int | None:
        model = self._scene.model_of(instance)
        # Grouped by the model's own materials and laid out by the painted ones: positions are the same in any paint.
        painted = {part.material: instance.material_of(part) for part in model.parts}
        looks = {own: self._scene.materials[name] for own, name in painted.items()}
        pieces = painted_meshes(model, looks)
        primitives = [self._primitive(_renderable(mesh), painted[own]) for own, mesh in pieces.items()]
        present = [item for item in primitives if item is not None]
        return self._container.add("meshes", {"name": instance.model, "primitives": present}) if present else None

    def _primitive(self, mesh: PaintedMesh, name: str) -> dict[str, object] | None:
        if len(mesh.faces) == 0:
            return None
        surface, container = self._materials.surface(name), self._container
        attributes = {
            "POSITION": container.add_vectors(mesh.positions, bounds=True),
            "NORMAL": container.add_vectors(mesh.normals),
        }
        if surface.normal is not None:
            attributes["TANGENT"] = container.add_vectors(tangents(mesh))
        if surface.albedo is not None:
            attributes["TEXCOORD_0"] = container.add_vectors(mesh.tiles)
        indices, material = container.add_indices(mesh.faces), self._materials.index(name)
        return {"attributes": attributes, "indices": indices, "material": material}


def tangents(mesh: PaintedMesh) -> Float[np.ndarray, "n 4"]:
    """Return unit tangents along growing u, and -1: the third axis, up the image, points against v.

    The gradient of u over each triangle, from its edges e and their steps in u:
    (du1 e2 x n + du2 n x e1) / (n . e1 x e2).
    """
    a, b, c = (mesh.positions[mesh.faces[:, corner]] for corner in range(3))
    u = mesh.tiles[mesh.faces, 0]
    normal = mesh.normals[mesh.faces[:, 0]]
    first, second = (u[:, 1] - u[:, 0])[:, None], (u[:, 2] - u[:, 0])[:, None]
    gradient = first * np.cross(c - a, normal) + second * np.cross(normal, b - a)
    found = np.zeros_like(mesh.positions)
    for corner in range(3):
        np.add.at(found, mesh.faces[:, corner], gradient)  # weighted by area; all of a vertex point the same way
    length = np.linalg.norm(found, axis=1, keepdims=True)
    # Where the picture lies with one texel on a face, u does not grow: any direction across the normal will do.
    spare = np.cross(mesh.normals, np.eye(3)[np.abs(mesh.normals).argmin(axis=1)])
    spare /= np.linalg.norm(spare, axis=1, keepdims=True)
    along = np.where(length > 1e-12, found / np.maximum(length, 1e-12), spare)
    return np.concatenate([along, np.full((len(along), 1), -1.0)], axis=1)


def _renderable(mesh: PaintedMesh) -> PaintedMesh:
    """Return ``mesh`` with unit normals: triangles without area, which have none, are left out."""
    length = np.linalg.norm(mesh.normals, axis=1)
    faces = mesh.faces[length[mesh.faces].min(axis=1) > 0.5]
    used, renumbered = np.unique(faces, return_inverse=True)
    if len(used) == len(mesh.positions):
        return mesh
    numbers = renumbered.reshape(-1, 3).astype(np.int32)
    return PaintedMesh(mesh.positions[used], mesh.normals[used], mesh.tiles[used], numbers)
