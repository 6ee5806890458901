"""Flat targets, edges and corners in closed form, as a renderer would give them."""

from dataclasses import fields
from typing import Any

import numpy as np

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.schema import RenderBuffers
from warehouse_sim.sensors.surfaces import Reflected, Surfaces
from warehouse_sim.sensors.view import Capture

CAMERA = PinholeCamera.from_focal(320, 240, 585.5)


def buffers_of(depth: np.ndarray, normals: np.ndarray, code: int = 128) -> RenderBuffers:
    rgb = np.full((*depth.shape, 3), code, np.uint8)
    return RenderBuffers(rgb, depth.astype(np.float32), np.ones(depth.shape, np.int32), normals.astype(np.float32))


def plane(z: float, lean_deg: float = 0.0, camera: PinholeCamera = CAMERA, code: int = 128) -> RenderBuffers:
    """A plane that the axis meets at z (m), turned about the vertical."""
    lean = np.deg2rad(lean_deg)
    normal = np.array([np.sin(lean), 0.0, -np.cos(lean)])
    along = camera.rays() @ normal
    depth = np.where(along < -1e-3, -z * np.cos(lean) / np.minimum(along, -1e-3), 0.0)
    return buffers_of(depth, np.broadcast_to(normal, (*depth.shape, 3)), code)


def step(near: float, far: float, columns: slice, camera: PinholeCamera = CAMERA) -> RenderBuffers:
    """A wall at ``far`` and a board at ``near`` before some columns of it (m)."""
    depth = np.full((camera.height, camera.width), far)
    depth[:, columns] = near
    return buffers_of(depth, np.broadcast_to([0.0, 0.0, -1.0], (*depth.shape, 3)))


def corner(z: float, concave: bool, camera: PinholeCamera = CAMERA) -> RenderBuffers:
    """Two walls at right angles whose common edge the axis meets at z (m), both 45 degrees off the axis."""
    turn = np.sqrt(0.5)
    normals = np.array([[turn, 0.0, -turn], [-turn, 0.0, -turn]])
    along = -np.stack([camera.rays() @ normal for normal in normals])
    depths = z * turn / along
    picked = depths.argmin(axis=0) if concave else depths.argmax(axis=0)
    depth = np.take_along_axis(depths, picked[None], axis=0)[0]
    return buffers_of(depth, normals[picked])


def capture_of(
    camera: PinholeCamera = CAMERA, remission: float = 1.0, roughness: float = 1.0, metallic: float = 0.0
) -> Capture:
    size = (camera.height, camera.width)
    images = (np.full(size, value, np.float32) for value in (remission, roughness, metallic))
    nothing = Reflected(np.zeros(size, np.float32), np.zeros(size, np.float32), np.ones(size, np.float32))
    return Capture(camera, surfaces=Surfaces(*images, reflected=nothing))


def with_constants(model: Any, **values: float) -> Any:
    """Return a sensor's settings as of a class that has other constants, to see one effect without the others."""
    kind = type(type(model).__name__, (type(model),), values)
    return kind(**{item.name: getattr(model, item.name) for item in fields(model)})
