"""A scene inside Mitsuba: triangles by material, what the camera sees through, lights, sky, and objects alone."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import mitsuba as mi
import numpy as np
from jaxtyping import Float32, Int32

from warehouse_sim.catalog.textures import stretch
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.mesh import TriangleMesh, merge
from warehouse_sim.geometry.pose import Transform, invert, transform_points
from warehouse_sim.render.painted_mesh import require_renderable
from warehouse_sim.render.pathtrace.lights import LightSampler, Sky
from warehouse_sim.render.pathtrace.materials import albedo_factor, gloss, scattering
from warehouse_sim.render.renderer import NOTHING_COVERED, AmodalMask
from warehouse_sim.render.textures import (
    WOUND,
    box_projection,
    edge_order,
    picture_coordinates,
    texture_shift,
    veil,
)
from warehouse_sim.schema import Material, ObjectInstance, Part, SceneSpec


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
        order = edge_order(np.ptp(mesh.vertices, axis=0) * scale, material.texture == WOUND)
        shift = texture_shift(ids, np.array([item.number for item in placed]))
        tile = np.array([material.texture_size * stretch(material.texture), material.texture_size])
        texture = box_projection(metres, normals[:, :, None], order[:, None, None]) / tile + shift[:, None, None]
    return (
        corners.reshape(-1, 3, 3).astype(np.float32),
        texture.reshape(-1, 3, 2).astype(np.float32),
        np.repeat(ids, len(mesh.faces)).astype(np.int32),
    )


_NEAR = 0.05  # metres


class AmodalMaskCaster:
    """Each model of a scene in a scene of its own, built when first requested; film has no amodal mask."""

    def __init__(self, spec: SceneSpec) -> None:
        self._spec = spec
        self._built: dict[str, tuple[Any, np.ndarray] | None] = {}

    def of(self, instance: ObjectInstance) -> tuple[Any, np.ndarray] | None:
        """Return the ``mi.Scene`` of the instance's model in the object frame and its corners (n, 3), or None."""
        if instance.model not in self._built:
            materials = self._spec.materials
            parts = [item for item in self._spec.model_of(instance).parts if materials[item.material].opacity >= 1.0]
            self._built[instance.model] = None
            if parts:
                mesh = merge([part.placed() for part in parts])
                shape = mesh_shape(mesh.vertices[mesh.faces])
                self._built[instance.model] = mi.load_dict({"type": "scene", "shape": shape}), mesh.vertices
        return self._built[instance.model]


def cast_amodal_mask(
    shapes: AmodalMaskCaster, camera: PinholeCamera, T_world_camera: Transform, instance: ObjectInstance
) -> AmodalMask:
    """Return the unoccluded amodal mask of ``instance`` on the canvas of three by three images."""
    shape = shapes.of(instance)
    if shape is None:
        return NOTHING_COVERED
    scene, corners = shape
    T_object_camera = invert(instance.T_world_object) @ T_world_camera
    window = _window(camera, transform_points(invert(T_object_camera), corners))
    if window is None:
        return NOTHING_COVERED
    left, top, right, bottom = window
    part = camera.crop(left, top, right - left + 1, bottom - top + 1)
    directions = (part.rays().reshape(-1, 3) @ T_object_camera[:3, :3].T).astype(np.float32)
    origin = T_object_camera[:3, 3]
    ray = mi.Ray3f(mi.Point3f(*map(float, origin)), mi.Vector3f(*(mi.Float(column) for column in directions.T)))
    mask = scene.ray_test(ray).numpy().reshape(part.height, part.width)
    return AmodalMask.of(mask, left, top)


def _window(camera: PinholeCamera, corners: np.ndarray) -> tuple[int, int, int, int] | None:
    """Return first column, first row, last column, last row that can be covered, or None; ``corners`` in the camera."""
    low = np.array([-camera.width, -camera.height])
    high = np.array([2 * camera.width - 1, 2 * camera.height - 1])
    if corners[:, 2].max() < _NEAR:
        return None
    if corners[:, 2].min() >= _NEAR:  # else anything may be covered: the object reaches behind the camera
        pixels = camera.project(corners)
        low = np.maximum(low, np.floor(pixels.min(axis=0)).astype(int) - 1)
        high = np.minimum(high, np.ceil(pixels.max(axis=0)).astype(int) + 1)
    if (low > high).any():
        return None
    return int(low[0]), int(low[1]), int(high[0]), int(high[1])


@dataclass(frozen=True, eq=False)
class FilmSurface:
    """What the path tracer asks of one film material beside its scattering."""

    opacity: float
    gloss: Any
    """``mi.BSDF`` of what it mirrors where it is clear."""
    factor: Any
    """``mi.Texture`` of the local thickness, or None."""


class LoadedScene:
    """One scene, ready for rays.

    Args:
        spec: The scene; later changes to it are not seen.

    Raises:
        RenderError: The scene names something that it does not hold, or a texture that is not shipped.
    """

    def __init__(self, spec: SceneSpec) -> None:
        groups = scene_triangles(spec)
        solid = [group for group in groups if group.material.opacity >= 1.0]
        film = [group for group in groups if group.material.opacity < 1.0]
        self.solid = _mitsuba_scene(solid)
        self.film = _mitsuba_scene(film) if film else None
        self.film_surfaces = [
            FilmSurface(veil(item.material), gloss(item.material), albedo_factor(item.material)) for item in film
        ]
        self.take_light(spec)
        glow = [np.array(group.material.base_color) * group.material.emission for group in solid]
        self.emission = mi.Float(np.concatenate([*glow, np.zeros(3)]).astype(np.float32))
        """Luminance (cd/m^2) of each solid material, three values each."""
        self.amodal_mask_caster = AmodalMaskCaster(spec)
        counts = [len(group.instance_ids) for group in solid]
        self._first_triangle = np.cumsum([0, *counts])
        self._owner = np.concatenate([*(group.instance_ids for group in solid), np.zeros(1, np.int32)])

    def take_light(self, spec: SceneSpec) -> None:
        """Put the scene into the lights, even light and exposure of ``spec``, which has the same objects."""
        self.lights = LightSampler(spec.lights)
        self.sky = Sky(spec.ambient)
        self.exposure = spec.exposure

    def instance_ids(
        self, shape: Int32[np.ndarray, " n"], triangle: Int32[np.ndarray, " n"], hit: np.ndarray
    ) -> Int32[np.ndarray, " n"]:
        """Return whose triangle each ray has met, 0 where ``hit`` is false.

        Args:
            shape: Number of the solid shape.
            triangle: Number of the triangle in it.
            hit: Whether the ray has met anything.
        """
        row = self._first_triangle[np.where(hit, shape, -1)] + np.where(hit, triangle, 0)
        return self._owner[row]


def _mitsuba_scene(groups: Sequence[MaterialTriangles]) -> Any:
    shapes = {
        f"shape{number:05d}": mesh_shape(group.corners, group.texture, scattering(group.material))
        for number, group in enumerate(groups)
    }
    # Unoptimised: merged shapes would lose their numbers.
    return mi.load_dict({"type": "scene", **shapes}, optimize=False)
