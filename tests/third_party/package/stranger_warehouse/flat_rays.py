"""A render backend: flat colours, one ray a pixel, through trimesh."""

from collections.abc import Sequence
from dataclasses import dataclass
from types import TracebackType
from typing import Annotated, Self

import numpy as np
import trimesh

from warehouse_sim.errors import RenderError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform, invert, transform_points
from warehouse_sim.ranges import Range, ranged
from warehouse_sim.render.painted_mesh import require_renderable
from warehouse_sim.render.renderer import AmodalMask, Capabilities, require_view
from warehouse_sim.schema import ObjectInstance, RenderBuffers, SceneSpec

_NEAR = 0.05
"""Nearest surface that is drawn (m along the optical axis)."""


@dataclass(frozen=True)
@ranged
class FlatOptions:
    """What the command line may set."""

    shade: Annotated[float, Range(0, 1)] = 0.0
    """How much darker a surface is that is seen at a grazing angle, 0-1."""


class FlatRays:
    """Colours of materials, darker where a surface turns away; no lights, no shadows, no textures.

    Args:
        options: How it draws.
    """

    Options = FlatOptions

    def __init__(self, options: FlatOptions = FlatOptions()) -> None:
        self._options = options
        self._scene: SceneSpec | None = None
        self._mesh: trimesh.Trimesh | None = None
        self._owner = self._color = np.zeros(0)

    @property
    def description(self) -> str:
        """Name and version."""
        return f"flat_rays 1.2.3 (trimesh {trimesh.__version__})"

    @property
    def capabilities(self) -> Capabilities:
        """What it leaves out."""
        return Capabilities(film=False, textures=False, shadows=False, max_lights=0)

    def load(self, scene: SceneSpec) -> None:
        """Put all solid triangles of the scene into one mesh."""
        require_renderable(scene)
        vertices, faces, owner, color, first = [], [], [], [], 0
        for instance in scene.instances:
            for part in scene.models[instance.model].parts:
                material = scene.materials[instance.material_of(part)]
                if material.opacity < 1.0:
                    continue
                placed = part.placed()
                vertices.append(transform_points(instance.T_world_object, placed.vertices))
                faces.append(placed.faces + first)
                owner.append(np.full(len(placed.faces), instance.instance_id, np.int32))
                color.append(np.tile(material.base_color, (len(placed.faces), 1)))
                first += len(placed.vertices)
        self._scene = scene
        self._owner, self._color = np.concatenate(owner), np.concatenate(color)
        self._mesh = trimesh.Trimesh(np.concatenate(vertices), np.concatenate(faces), process=False)

    def render(self, camera: PinholeCamera, T_world_camera: Transform, normals: bool = False) -> RenderBuffers:
        """Cast one ray through each pixel's centre."""
        require_view(camera, T_world_camera)
        if self._mesh is None:
            raise RenderError("load a scene before rendering")
        v, u = np.indices((camera.height, camera.width))
        rays = np.stack([(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, np.ones(u.shape)], -1).reshape(-1, 3)
        face, depth = _first_hits(self._mesh, T_world_camera, rays)
        hit = face >= 0
        normal = np.zeros((len(rays), 3))
        normal[hit] = self._mesh.face_normals[face[hit]] @ T_world_camera[:3, :3]
        towards = -rays / np.linalg.norm(rays, axis=1, keepdims=True)
        facing = (normal * towards).sum(axis=1)
        normal[facing < 0] *= -1.0
        linear = np.zeros((len(rays), 3))
        linear[hit] = self._color[face[hit]] * (1.0 - self._options.shade * (1.0 - np.abs(facing[hit, None])))
        ids = np.zeros(len(rays), np.int32)
        ids[hit] = self._owner[face[hit]]
        shape = camera.height, camera.width
        return RenderBuffers(
            rgb=np.rint(255.0 * linear ** (1 / 2.2)).astype(np.uint8).reshape(*shape, 3),
            depth=depth.astype(np.float32).reshape(shape),
            instance_mask=ids.reshape(shape),
            normals=normal.astype(np.float32).reshape(*shape, 3) if normals else None,
        )

    def amodal_masks(
        self, camera: PinholeCamera, T_world_camera: Transform, instances: Sequence[ObjectInstance]
    ) -> list[AmodalMask]:
        """Cast rays at each object alone, where the box of its projection lies on the canvas."""
        require_view(camera, T_world_camera)
        return [self._amodal_mask(camera, T_world_camera, item) for item in instances]

    def close(self) -> None:
        """Forget the scene."""
        self._mesh = None

    def __enter__(self) -> Self:
        """Return itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close."""
        self.close()

    def _amodal_mask(self, camera: PinholeCamera, T_world_camera: Transform, instance: ObjectInstance) -> AmodalMask:
        assert self._scene is not None
        parts = [
            part.placed()
            for part in self._scene.models[instance.model].parts
            if self._scene.materials[part.material].opacity >= 1.0
        ]
        alone = trimesh.util.concatenate([trimesh.Trimesh(item.vertices, item.faces, process=False) for item in parts])
        alone.apply_transform(instance.T_world_object)
        low, high = np.array([-camera.width, -camera.height]), 2 * np.array([camera.width, camera.height]) - 1
        seen = transform_points(invert(T_world_camera), alone.vertices)
        if (seen[:, 2] > _NEAR).all():
            pixels = seen[:, :2] / seen[:, 2:] * (camera.fx, camera.fy) + (camera.cx, camera.cy)
            low = np.maximum(low, np.floor(pixels.min(axis=0)).astype(int))
            high = np.minimum(high, np.ceil(pixels.max(axis=0)).astype(int))
        if (low > high).any():
            return AmodalMask((0, 0), np.zeros((0, 0), bool))
        u, v = np.meshgrid(np.arange(low[0], high[0] + 1), np.arange(low[1], high[1] + 1))
        rays = np.stack([(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, np.ones(u.shape)], -1).reshape(-1, 3)
        mask = (_first_hits(alone, T_world_camera, rays)[0] >= 0).reshape(u.shape)
        rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
        if len(rows) == 0:
            return AmodalMask((0, 0), np.zeros((0, 0), bool))
        tight = mask[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
        return AmodalMask((int(low[0] + columns[0]), int(low[1] + rows[0])), tight)


def _first_hits(mesh: trimesh.Trimesh, T_world_camera: Transform, rays: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the face that each ray (camera frame, z = 1) meets first, -1 for none, and its depth (m), 0 for none."""
    directions = rays @ T_world_camera[:3, :3].T
    # Rays begin at the near plane, as what is nearer is not drawn.
    starts = T_world_camera[:3, 3] + _NEAR * directions
    face = np.asarray(mesh.ray.intersects_first(starts, directions))
    depth = np.zeros(len(rays))
    hit = face >= 0
    corner, normal = mesh.triangles[face[hit], 0], mesh.triangles_cross[face[hit]]
    reach = ((corner - starts[hit]) * normal).sum(axis=1) / (directions[hit] * normal).sum(axis=1)
    depth[hit] = _NEAR + reach
    return face, depth
