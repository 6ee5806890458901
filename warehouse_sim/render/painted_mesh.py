"""The parts of a model that share a material as one flat-shaded, textured mesh: what other renderers take in."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from jaxtyping import Float64, Int32

from warehouse_sim.catalog.textures import stretch
from warehouse_sim.errors import RenderError
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.geometry.pose import transform_points
from warehouse_sim.render.textures import WOUND, box_projection, edge_order, picture_coordinates, texture_shift
from warehouse_sim.schema import Material, ObjectModel, Part, SceneSpec


@dataclass(frozen=True, eq=False)
class PaintedMesh:
    """Triangles of one material in the object frame; vertices are split where faces differ in their normal."""

    positions: Float64[np.ndarray, "n 3"]
    """Metres."""
    normals: Float64[np.ndarray, "n 3"]
    tiles: Float64[np.ndarray, "n 2"]
    """Texture coordinates in tiles; v grows with the rows of the texture."""
    faces: Int32[np.ndarray, "m 3"]


def painted_meshes(model: ObjectModel, materials: Mapping[str, Material]) -> dict[str, PaintedMesh]:
    """Return the geometry of ``model`` by the name of the material that it is painted with."""
    pieces: dict[str, list[PaintedMesh]] = {}
    for number, part in enumerate(model.parts):
        pieces.setdefault(part.material, []).append(_painted_part(part, materials[part.material], number))
    return {name: _merge(group) for name, group in pieces.items()}


def require_renderable(scene: SceneSpec) -> None:
    """Check what every backend needs of a scene.

    Raises:
        RenderError: The scene is empty, two objects share an id, one names a model or material that is not there, or
            paint makes film of what is solid, or the other way round.
    """
    seen: set[int] = set()
    for instance in scene.instances:
        where = f"scene {scene.scene_index}: object {instance.instance_id}"
        if instance.instance_id in seen:
            raise RenderError(f"{where} occurs twice; every object needs an id of its own")
        seen.add(instance.instance_id)
        if instance.model not in scene.models:
            raise RenderError(f"{where} is of model {instance.model!r}; add it to SceneSpec.models")
        for part in scene.model_of(instance).parts:
            painted = instance.material_of(part)
            for name in (part.material, painted):
                if name not in scene.materials:
                    raise RenderError(f"{where} has the material {name!r}; add it to SceneSpec.materials")
            if (scene.materials[part.material].opacity < 1.0) != (scene.materials[painted].opacity < 1.0):
                raise RenderError(f"{where}: paint puts {painted!r} in place of {part.material!r}; film must stay film")
    if not any(scene.model_of(instance).parts for instance in scene.instances):
        raise RenderError(f"scene {scene.scene_index} holds nothing to render; add objects with parts")


def _painted_part(part: Part, material: Material, number: int) -> PaintedMesh:
    corners, normals, faces = _split(part.mesh)
    metres = corners * part.scale
    local = normals / part.scale
    local = local / np.maximum(np.linalg.norm(local, axis=1, keepdims=True), 1e-12)
    return PaintedMesh(
        positions=transform_points(part.T_object_part, metres),
        normals=local @ part.T_object_part[:3, :3].T,
        tiles=_tiles(metres, local, material, number),
        faces=faces,
    )


def corner_tiles(part: Part, material: Material, number: int) -> Float64[np.ndarray, "m 3 2"]:
    """Return the texture coordinates of ``PaintedMesh.tiles`` for each corner of each face of a part's mesh.

    Args:
        part: The part.
        material: What it is painted with.
        number: Of the part in its model.
    """
    metres = part.mesh.vertices[part.mesh.faces] * part.scale
    normals = part.mesh.face_normals() / part.scale
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    flat = np.repeat(normals, 3, axis=0)
    return _tiles(metres.reshape(-1, 3), flat, material, number).reshape(-1, 3, 2)


def _tiles(
    metres: Float64[np.ndarray, "n 3"], normals: Float64[np.ndarray, "n 3"], material: Material, number: int
) -> Float64[np.ndarray, "n 2"]:
    if material.picture is not None:
        return picture_coordinates(metres, normals)
    along = material.texture_size * (stretch(material.texture) if material.texture is not None else 1)
    metres_of_a_tile = np.array([along, material.texture_size])
    order = edge_order(np.ptp(metres, axis=0), material.texture == WOUND)
    tiles: Float64[np.ndarray, "n 2"] = box_projection(metres, normals, order) / metres_of_a_tile
    return tiles + texture_shift(np.array(0), np.array(number))


@lru_cache(maxsize=512)
def _split(
    mesh: TriangleMesh,
) -> tuple[Float64[np.ndarray, "n 3"], Float64[np.ndarray, "n 3"], Int32[np.ndarray, "m 3"]]:
    """Return positions and normals of corners, equal ones once, and triangles of them."""
    normals = np.round(np.repeat(mesh.face_normals()[:, None], 3, axis=1), 6)
    corners = np.concatenate([mesh.vertices[mesh.faces], normals], axis=2).reshape(-1, 6)
    rows, indices = np.unique(corners, axis=0, return_inverse=True)
    return rows[:, :3], rows[:, 3:], indices.reshape(-1, 3).astype(np.int32)


def _merge(pieces: list[PaintedMesh]) -> PaintedMesh:
    starts = np.cumsum([0] + [len(piece.positions) for piece in pieces[:-1]])
    return PaintedMesh(
        positions=np.concatenate([piece.positions for piece in pieces]),
        normals=np.concatenate([piece.normals for piece in pieces]),
        tiles=np.concatenate([piece.tiles for piece in pieces]),
        faces=np.concatenate([piece.faces + start for piece, start in zip(pieces, starts, strict=True)]),
    )
