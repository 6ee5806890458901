"""A scene as triangles in the world, one list a material, with box projection, as meshes of Mitsuba."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import mitsuba as mi
import numpy as np
from jaxtyping import Float32, Int32

from warehouse_sim.catalog.textures import stretch
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.render.painted_mesh import require_renderable
from warehouse_sim.render.texture_layout import box_projection, edge_order, picture_coordinates, texture_shift
from warehouse_sim.schema import Material, Part, SceneSpec


def mesh_shape(corners: np.ndarray, texture: np.ndarray | None = None, surface: Any = None) -> Any:
    """Return a flat-shaded ``mi.Mesh``.

    Args:
        corners: World positions (m, 3, 3) of triangles, counter-clockwise seen from outside (m).
        texture: Texture coordinates (m, 3, 2) of the corners.
        surface: Its ``mi.BSDF``.
    """
    properties = mi.Properties()
    if surface is not None:
        properties["bsdf"] = surface
    count = 3 * len(corners)
    mesh = mi.Mesh("triangles", count, len(corners), props=properties, has_vertex_texcoords=texture is not None)
    values = mi.traverse(mesh)
    values["vertex_positions"] = np.ascontiguousarray(corners, np.float32).ravel()
    values["faces"] = np.arange(count, dtype=np.uint32)
    if texture is not None:
        values["vertex_texcoords"] = np.ascontiguousarray(texture, np.float32).ravel()
    values.update()
    return mesh


@dataclass(frozen=True, eq=False)
class MaterialTriangles:
    """All triangles of one material."""

    material: Material
    corners: Float32[np.ndarray, "m 3 3"]
    """World positions (m), counter-clockwise seen from outside."""
    texture: Float32[np.ndarray, "m 3 2"]
    """Texture coordinates, one tile a unit; v grows with the rows of the image."""
    instance_ids: Int32[np.ndarray, " m"]


@dataclass(frozen=True, eq=False)
class _Placed:
    instance_id: int
    number: int
    """Of the part in its model."""
    part: Part
    material: str
    T_world_object: Transform


def scene_triangles(scene: SceneSpec) -> list[MaterialTriangles]:
    """Return the triangles of ``scene`` by material, in the order of first use.

    Raises:
        RenderError: The scene is empty, two objects share an id, or one names a model or material that is not there.
    """
    require_renderable(scene)
    groups: dict[str, dict[TriangleMesh, list[_Placed]]] = {}
    for placed in _placed_parts(scene):
        groups.setdefault(placed.material, {}).setdefault(placed.part.mesh, []).append(placed)
    return [_join(scene.materials[name], by_mesh) for name, by_mesh in groups.items()]


def _placed_parts(scene: SceneSpec) -> Iterator[_Placed]:
    for instance in scene.instances:
        for number, part in enumerate(scene.model_of(instance).parts):
            yield _Placed(instance.instance_id, number, part, instance.material_of(part), instance.T_world_object)


def _join(material: Material, by_mesh: dict[TriangleMesh, list[_Placed]]) -> MaterialTriangles:
    pieces = [_mesh_triangles(material, mesh, placed) for mesh, placed in by_mesh.items()]
    corners, texture, ids = (np.concatenate(columns) for columns in zip(*pieces, strict=True))
    return MaterialTriangles(material, corners, texture, ids)


def _mesh_triangles(
    material: Material, mesh: TriangleMesh, placed: list[_Placed]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return corners (m, 3, 3), texture coordinates (m, 3, 2) and instance ids (m,) of all uses of one mesh."""
    scale = np.stack([item.part.scale for item in placed]).astype(float)
    T = np.stack([item.T_world_object @ item.part.T_object_part for item in placed])
    metres = mesh.vertices[mesh.faces] * scale[:, None, None]
    corners = np.einsum("pij,pfcj->pfci", T[:, :3, :3], metres) + T[:, None, None, :3, 3]
    ids = np.array([item.instance_id for item in placed])
    normals = np.round(mesh.face_normals(), 6) / scale[:, None]
    normals /= np.maximum(np.linalg.norm(normals, axis=-1, keepdims=True), 1e-12)
    if material.picture is not None:
        every = np.broadcast_to(normals[:, :, None], metres.shape)
        texture = np.stack([picture_coordinates(*pair) for pair in zip(metres, every, strict=True)])
    elif material.texture is None:
        texture = np.zeros((*metres.shape[:-1], 2))
    else:
        order = edge_order(np.ptp(mesh.vertices, axis=0) * scale)
        shift = texture_shift(ids, np.array([item.number for item in placed]))
        tile = np.array([material.texture_size * stretch(material.texture), material.texture_size])
        texture = box_projection(metres, normals[:, :, None], order[:, None, None]) / tile + shift[:, None, None]
    return (
        corners.reshape(-1, 3, 3).astype(np.float32),
        texture.reshape(-1, 3, 2).astype(np.float32),
        np.repeat(ids, len(mesh.faces)).astype(np.int32),
    )
