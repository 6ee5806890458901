"""Amodal masks: rays through pixel centres at one object that stands alone."""

from typing import Any

import mitsuba as mi
import numpy as np

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.mesh import merge
from warehouse_sim.geometry.pose import Transform, invert, transform_points
from warehouse_sim.render.pathtrace.triangles import mesh_shape
from warehouse_sim.render.renderer import NOTHING_COVERED, AmodalMask
from warehouse_sim.schema import ObjectInstance, SceneSpec

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
