"""Amodal masks for backends that draw one object alone at a time: the canvas around the image, one image at a time."""

from collections.abc import Callable

import numpy as np
from jaxtyping import Bool, Float64

from warehouse_sim.geometry.boxes import box_corners
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform, invert, transform_points
from warehouse_sim.render.renderer import AmodalMask
from warehouse_sim.schema import ObjectInstance, ObjectModel, SceneSpec

_MARGIN_PX = 2.0


def _solid_corners(scene: SceneSpec, model: ObjectModel) -> Float64[np.ndarray, "k 3"]:
    """Return the corners, in the object frame (m), of boxes around the parts of ``model`` that are not film."""
    corners = []
    for part in model.parts:
        if scene.materials[part.material].opacity < 1.0:
            continue
        low, high = (pick(part.mesh.vertices * part.scale, axis=0) for pick in (np.min, np.max))
        box = (low + high) / 2 + box_corners(high - low)
        corners.append(transform_points(part.T_object_part, box))
    return np.concatenate(corners) if corners else np.zeros((0, 3))


def amodal_mask_by_tiles(
    camera: PinholeCamera,
    T_world_camera: Transform,
    scene: SceneSpec,
    instance: ObjectInstance,
    near: float,
    draw: Callable[[PinholeCamera], Bool[np.ndarray, "h w"]],
) -> AmodalMask:
    """Return the amodal mask of one object on the canvas of 3 x 3 images with the image in the middle.

    The middle tile is rendered with the camera of the image itself, so that it covers the same pixels there.

    Args:
        camera: Intrinsics of the image.
        T_world_camera: Pose of the camera.
        scene: Holds the object's model and materials; film covers nothing.
        instance: The object.
        near: Distance of the near plane (m).
        draw: Renders the object alone with the camera of a tile, as large as the image; returns the covered pixels.
    """
    width, height = camera.width, camera.height
    corners = _solid_corners(scene, scene.model_of(instance))
    in_camera = transform_points(invert(T_world_camera) @ instance.T_world_object, corners)
    canvas = np.zeros((3 * height, 3 * width), bool)
    for column, row in _touched_tiles(camera, in_camera, near):
        left, top = column * width, row * height
        tile = camera.crop(left, top, width, height) if (left, top) != (0, 0) else camera
        canvas[top + height : top + 2 * height, left + width : left + 2 * width] = draw(tile)
    return AmodalMask.of(canvas, -width, -height)


def _touched_tiles(camera: PinholeCamera, points: Float64[np.ndarray, "k 3"], near: float) -> list[tuple[int, int]]:
    """Return column and row, -1 to 1, of the tiles that the hull of ``points`` (camera frame) may be seen in."""
    everywhere = [(column, row) for row in (-1, 0, 1) for column in (-1, 0, 1)]
    before = points[:, 2] > near
    if not before.any():
        return []
    if not before.all():
        return everywhere  # it reaches behind the camera: its bounds say nothing
    pixels = camera.project(points)
    size = np.array([camera.width, camera.height])
    low, high = pixels.min(axis=0) - _MARGIN_PX, pixels.max(axis=0) + _MARGIN_PX
    return [tile for tile in everywhere if (low < (np.array(tile) + 1) * size).all() and (high > tile * size).all()]
