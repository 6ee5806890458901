"""Depth, instance masks and normals from one exact ray per pixel centre; amodal masks from rays at one object."""

from dataclasses import dataclass

import mitsuba as mi
import numpy as np
from jaxtyping import Float, Float32, Int32

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.render.pathtrace.loaded_scene import LoadedScene


@dataclass(frozen=True, eq=False)
class Products:
    """What lies at the pixel centres."""

    depth: Float32[np.ndarray, "h w"]
    instance_ids: Int32[np.ndarray, "h w"]
    normals: Float32[np.ndarray, "h w 3"]


def cast_products(scene: LoadedScene, camera: PinholeCamera, T_world_camera: Transform) -> Products:
    """Return depth (m along the optical axis), ids and camera-frame normals of the loaded scene."""
    shape = (camera.height, camera.width)
    rays = camera.rays().reshape(-1, 3)
    ray = world_rays(rays, T_world_camera)
    hit = scene.solid.ray_intersect_preliminary(ray, coherent=True)
    valid = hit.is_valid().numpy()
    # Rays have z = 1 m in the camera frame, so the distance in their own units is the z-depth.
    depth = np.where(valid, hit.t.numpy(), 0.0)
    normals = hit.compute_surface_interaction(ray, mi.RayFlags.Minimal).n.numpy().T
    return Products(
        depth=depth.reshape(shape).astype(np.float32),
        instance_ids=scene.instance_ids(
            hit.shape_index.numpy().astype(np.int64), hit.prim_index.numpy().astype(np.int64), valid
        ).reshape(shape),
        normals=np.where(valid[:, None], normals @ T_world_camera[:3, :3], 0.0).reshape(*shape, 3).astype(np.float32),
    )


def world_rays(rays: Float[np.ndarray, "n 3"], T_world_camera: Transform) -> "mi.Ray3f":
    """Return rays from the camera through camera-frame points; their length is kept."""
    directions = (rays @ T_world_camera[:3, :3].T).astype(np.float32)
    origin = T_world_camera[:3, 3].astype(np.float32)
    return mi.Ray3f(mi.Point3f(*map(float, origin)), mi.Vector3f(*(mi.Float(column) for column in directions.T)))
