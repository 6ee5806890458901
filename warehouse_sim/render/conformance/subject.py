"""The backend under test, a box of known place, and the exact rays that its views are compared with."""

import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property

import cv2
import numpy as np

from warehouse_sim.errors import RenderError
from warehouse_sim.geometry.boxes import box_corners
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import (
    Transform,
    invert,
    level_camera,
    make_transform,
    matrix_from_quat_wxyz,
    transform_points,
)
from warehouse_sim.render.conformance.scenes import rack_wall
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.render.renderer import Renderer
from warehouse_sim.schema import RenderBuffers, SceneSpec


@dataclass(frozen=True, eq=False)
class GroundTruth:
    """What exact rays see in an image."""

    instance_mask: np.ndarray
    depth: np.ndarray
    normals: np.ndarray
    """Camera frame."""

    def inside(self) -> np.ndarray:
        """Return the pixels whose 3 x 3 neighbours show the same object with the same normal, or all nothing."""
        word = self.instance_mask.astype(float)[..., None] * 10 + np.round(self.normals, 3)
        kernel = np.ones((3, 3), np.uint8)
        spread = [cv2.dilate(plane, kernel) - cv2.erode(plane, kernel) for plane in np.moveaxis(word, -1, 0)]
        # Parallel faces of one object at two depths: a step far larger than the slope of one surface explains.
        inverse = np.divide(1.0, self.depth, out=np.zeros(self.depth.shape), where=self.depth > 0)
        bend = np.abs(cv2.Laplacian(inverse, cv2.CV_64F))
        return (np.max(spread, axis=0) == 0) & (cv2.dilate(bend, kernel) < 1e-4)


def cast_image(scene: SceneSpec, camera: PinholeCamera, T_world_camera: Transform) -> GroundTruth:
    """Cast a ray through the centre of each pixel."""
    rays = camera.rays().reshape(-1, 3)
    R = T_world_camera[:3, :3]
    hits = RayCaster(scene).cast(np.broadcast_to(T_world_camera[:3, 3], rays.shape), rays @ R.T)
    shape = (camera.height, camera.width)
    # Rays have z = 1 m in the camera frame, so the distance in their own units is the z-depth.
    depth = np.where(np.isfinite(hits.distance), hits.distance, 0.0).reshape(shape)
    return GroundTruth(hits.instance_ids.reshape(shape), depth, (hits.normals @ R).reshape(*shape, 3))


OFF_CENTRE = PinholeCamera(320, 240, 310.0, 290.0, 121.3, 157.8)
"""Oblong pixels and a principal point far from the middle."""
SIZE = np.array([0.6, 0.4, 0.3])


def random_placements(count: int, margin: int) -> list[np.ndarray]:
    """Return poses of the box in the camera frame that keep it ``margin`` px inside the image of ``OFF_CENTRE``."""
    rng = np.random.default_rng(7)
    high = (OFF_CENTRE.width - 1 - margin, OFF_CENTRE.height - 1 - margin)
    found: list[np.ndarray] = []
    while len(found) < count:
        z = rng.uniform(1.5, 6.0)
        pixel = rng.uniform((0, 0), (OFF_CENTRE.width, OFF_CENTRE.height))
        ray = (pixel - (OFF_CENTRE.cx, OFF_CENTRE.cy)) / (OFF_CENTRE.fx, OFF_CENTRE.fy)
        T = make_transform(matrix_from_quat_wxyz(rng.normal(size=4)), np.array([*ray * z, z]))
        corners = OFF_CENTRE.project(transform_points(T, box_corners(SIZE)))
        if corners.min() > margin and (corners.max(axis=0) < high).all():
            found.append(T)
    return found


def polygon_centroid(points: np.ndarray) -> np.ndarray:
    """Return the centre of gravity of a polygon by its corners (n 2)."""
    x, y = points.T
    x2, y2 = np.roll(x, -1), np.roll(y, -1)
    cross = x * y2 - x2 * y
    return np.array([((x + x2) * cross).sum(), ((y + y2) * cross).sum()]) / (3.0 * cross.sum())


def ray_box_depth(T_camera_object: np.ndarray, rays: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return z-depth (0 = missed) and normals where rays with z = 1 m meet a box, by the slab method in 64 bits."""
    T = invert(T_camera_object)
    directions = rays @ T[:3, :3].T
    a, b = (-SIZE / 2 - T[:3, 3]) / directions, (SIZE / 2 - T[:3, 3]) / directions
    enter, leave = np.minimum(a, b), np.maximum(a, b)
    axis = enter.argmax(axis=1)
    depth = np.where(enter.max(axis=1) < leave.min(axis=1), enter.max(axis=1), 0.0)
    sign = -np.sign(np.take_along_axis(directions, axis[:, None], axis=1))
    return depth, sign * np.eye(3)[axis] @ T_camera_object[:3, :3].T


KITTI = PinholeCamera.from_focal(1224, 370, 721.5377)
HALF = PinholeCamera.from_focal(612, 185, 360.76885)
_OTHERS = "raster|pathtrace"
"""A rejection names a backend that can."""


@dataclass(frozen=True, eq=False)
class Subject:
    """An open backend and the name that it is registered under."""

    name: str
    renderer: Renderer

    def render(
        self, scene: SceneSpec, camera: PinholeCamera, T_world_camera: Transform, normals: bool = False
    ) -> RenderBuffers:
        """Load ``scene`` and draw one view of it."""
        self.renderer.load(scene)
        return self.renderer.render(camera, T_world_camera, normals=normals)

    def expect(self, ok: object, what: str) -> None:
        """Raise a RenderError that names the backend unless ``ok``."""
        if not ok:
            raise RenderError(f"the {self.name} backend does not conform: {what}")

    def expect_rejection(self, call: Callable[[], object], pattern: str) -> None:
        """Expect that ``call`` raises a RenderError whose message holds the regular expression ``pattern``."""
        try:
            call()
        except RenderError as error:
            self.expect(
                re.search(pattern, str(error)), f"it rejects with {str(error)!r}, which does not say {pattern!r}"
            )
            return
        self.expect(False, f"it should have rejected with {pattern!r}")

    def expect_cannot(self, call: Callable[[], object], product: str) -> None:
        """Expect that ``call`` is rejected since the backend draws no ``product``, with the name of one that does."""
        self.expect_rejection(call, f"the {self.name} backend renders no {product}; use .*({_OTHERS})")


@dataclass(frozen=True, eq=False)
class View:
    """A camera in a scene."""

    scene: SceneSpec
    camera: PinholeCamera
    T_world_camera: Transform

    @cached_property
    def gt(self) -> GroundTruth:
        """What exact rays see."""
        return cast_image(self.scene, self.camera, self.T_world_camera)


def _wall(camera: PinholeCamera, viewpoint: int) -> View:
    scene = rack_wall()
    return View(scene, camera, scene.viewpoints[viewpoint].T_world_camera)


def _tilted() -> View:
    T = level_camera(np.array([0.5, 1.0, 2.2]), -0.3, -0.35, 0.5)
    return View(rack_wall(), HALF, T)


VIEWS: dict[str, Callable[[], View]] = {
    "whole image": lambda: _wall(KITTI, 0),
    "off-centre": lambda: _wall(OFF_CENTRE, 1),
    "principal point outside": lambda: _wall(KITTI.crop(700, 210, 300, 160), 2),
    "tilted": _tilted,
}


@cache
def view(name: str) -> View:
    """Return a view of ``VIEWS``; what exact rays see there is cast once."""
    return VIEWS[name]()
