"""A scene as triangles in the world, one list a material, with box projection, as meshes of Mitsuba."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import mitsuba as mi
import numpy as np
from jaxtyping import Float, Float32, Int, Int32

from warehouse_sim.catalog.textures import stretch
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.render.painted_mesh import require_renderable
from warehouse_sim.render.picture_layout import picture_coordinates
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


def tile_coordinates(
    metres: Float[np.ndarray, "p f 3 3"], normals: Float[np.ndarray, "p f 3"], order: Int[np.ndarray, "p 3"]
) -> Float[np.ndarray, "p f 3 2"]:
    """Return how far along u and v (m) each corner lies.

    Args:
        metres: Corners of the faces of each part in the part's own frame (m).
        normals: Unit normals of the faces in that frame.
        order: Axes of each part from the longest edge to the shortest.
    """
    size = np.abs(normals)
    # As the shader compares: x wins ties, then y.
    facing = np.where(
        (size[..., 0] >= size[..., 1]) & (size[..., 0] >= size[..., 2]), 0, np.where(size[..., 1] >= size[..., 2], 1, 2)
    )
    u = np.where(order[:, None, 0] == facing, order[:, None, 1], order[:, None, 0])
    v = 3 - u - facing
    handed = np.where((u + 1) % 3 == v, 1.0, -1.0)
    towards = np.take_along_axis(normals, facing[..., None], axis=-1)[..., 0]
    along_u = np.take_along_axis(metres, u[..., None, None], axis=-1)[..., 0]
    along_v = np.take_along_axis(metres, v[..., None, None], axis=-1)[..., 0]
    return np.stack([along_u, along_v * np.where(towards < 0, -handed, handed)[..., None]], axis=-1)


def edge_order(extent: Float[np.ndarray, "p 3"]) -> Int[np.ndarray, "p 3"]:
    """Return the axes from the longest edge (m) to the shortest; edges equal to the centimetre keep x, y, z."""
    return np.argsort(-np.round(extent, 2), axis=1, kind="stable")


def texture_shift(instance_ids: Int[np.ndarray, " p"], numbers: Int[np.ndarray, " p"]) -> Float[np.ndarray, "p 2"]:
    """Return where in its tile each part starts: the R2 sequence (Roberts 2018) over object and part number."""
    return ((instance_ids * 131 + numbers)[:, None] * np.array([0.7548776662466927, 0.5698402909980532])) % 1.0


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
    if material.picture is not None:
        normals = np.round(mesh.face_normals(), 6) / scale[:, None]
        normals /= np.maximum(np.linalg.norm(normals, axis=-1, keepdims=True), 1e-12)
        every = np.broadcast_to(normals[:, :, None], metres.shape)
        texture = np.stack([picture_coordinates(*pair) for pair in zip(metres, every, strict=True)])
    elif material.texture is None:
        texture = np.zeros((*metres.shape[:-1], 2))
    else:
        normals = np.round(mesh.face_normals(), 6) / scale[:, None]
        normals /= np.maximum(np.linalg.norm(normals, axis=-1, keepdims=True), 1e-12)
        order = edge_order(np.ptp(mesh.vertices, axis=0) * scale)
        shift = texture_shift(ids, np.array([item.number for item in placed]))
        tile = np.array([material.texture_size * stretch(material.texture), material.texture_size])
        texture = tile_coordinates(metres, normals, order) / tile + shift[:, None, None]
    return (
        corners.reshape(-1, 3, 3).astype(np.float32),
        texture.reshape(-1, 3, 2).astype(np.float32),
        np.repeat(ids, len(mesh.faces)).astype(np.int32),
    )
