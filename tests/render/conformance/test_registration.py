"""Every channel of every backend lies where the camera model says, to a tenth of a pixel, colours included."""

from dataclasses import dataclass

import cv2
import numpy as np
import pytest

from tests.render.conformance.subject import OFF_CENTRE, Subject
from tests.render.scenes import box_model, make_scene
from warehouse_sim.geometry.boxes import box_corners
from warehouse_sim.geometry.pose import invert, make_transform, matrix_from_quat_wxyz, transform_points
from warehouse_sim.schema import Material, RenderBuffers, SceneSpec

pytestmark = pytest.mark.gl

SIZE = np.array([0.6, 0.4, 0.3])
PLACEMENTS = 24


@dataclass(frozen=True, eq=False)
class Offsets:
    """How far each placement's picture lies from where it belongs (n 2), in pixels."""

    mask: np.ndarray
    rgb: np.ndarray
    depth: np.ndarray


def glowing_box() -> SceneSpec:
    """A box at the world's origin that shines evenly in the dark: its picture is its silhouette."""
    glow = {"glow": Material("glow", (0.5, 0.5, 0.5), emission=0.6)}
    return make_scene([box_model("box", SIZE, "glow")], [("box", np.eye(4))], materials=glow, ambient=0.0)


def random_placements(count: int) -> list[np.ndarray]:
    """Poses of a box in the camera frame that keep it whole in the image of ``OFF_CENTRE``."""
    rng = np.random.default_rng(7)
    found: list[np.ndarray] = []
    while len(found) < count:
        z = rng.uniform(1.5, 6.0)
        pixel = rng.uniform((0, 0), (OFF_CENTRE.width, OFF_CENTRE.height))
        ray = (pixel - (OFF_CENTRE.cx, OFF_CENTRE.cy)) / (OFF_CENTRE.fx, OFF_CENTRE.fy)
        T = make_transform(matrix_from_quat_wxyz(rng.normal(size=4)), np.array([*ray * z, z]))
        corners = OFF_CENTRE.project(transform_points(T, box_corners(SIZE)))
        if corners.min() > 4 and (corners.max(axis=0) < (OFF_CENTRE.width - 5, OFF_CENTRE.height - 5)).all():
            found.append(T)
    return found


def polygon_centroid(points: np.ndarray) -> np.ndarray:
    x, y = points.T
    x2, y2 = np.roll(x, -1), np.roll(y, -1)
    cross = x * y2 - x2 * y
    return np.array([((x + x2) * cross).sum(), ((y + y2) * cross).sum()]) / (3.0 * cross.sum())


def image_centroid(weight: np.ndarray) -> np.ndarray:
    rows, columns = np.indices(weight.shape)
    return np.array([(columns * weight).sum(), (rows * weight).sum()]) / weight.sum()


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


def depth_offset(buffers: RenderBuffers, T_camera_object: np.ndarray) -> np.ndarray:
    """Return by how much the depth image would have to move to be exact, by least squares over its pixels."""
    rows, columns = np.nonzero(buffers.instance_ids)
    rays = OFF_CENTRE.rays()[rows, columns]
    exact, normals = ray_box_depth(T_camera_object, rays)
    # On the plane n.p = c: z = c / (n.ray), whose derivatives by u and v say how far the image would have to move.
    facing = (normals * rays).sum(axis=-1, keepdims=True)
    per_pixel = -exact[:, None] * normals[:, :2] / (facing * [OFF_CENTRE.fx, OFF_CENTRE.fy])
    error = buffers.depth[rows, columns] - exact
    same_face = np.abs(error) < 0.02
    assert same_face.mean() > 0.97
    return np.linalg.lstsq(per_pixel[same_face], error[same_face], rcond=None)[0]


def measure(subject: Subject) -> Offsets:
    subject.renderer.load(glowing_box())
    mask, rgb, depth = [], [], []
    for T_camera_object in random_placements(PLACEMENTS):
        buffers = subject.renderer.render(OFF_CENTRE, invert(T_camera_object))
        corners = OFF_CENTRE.project(transform_points(T_camera_object, box_corners(SIZE)))
        exact = polygon_centroid(cv2.convexHull(corners.astype(np.float32))[:, 0].astype(float))
        mask.append(image_centroid(buffers.instance_ids != 0) - exact)
        rgb.append(image_centroid(buffers.rgb.astype(float).sum(axis=2)) - exact)
        depth.append(depth_offset(buffers, T_camera_object))
    return Offsets(*map(np.array, (mask, rgb, depth)))


def test_masks_colours_and_depth_lie_where_the_camera_projects(subject: Subject) -> None:
    """A half pixel, the commonest error of all, is five times what is allowed, and no channel hides behind another."""
    offsets = measure(subject)
    for channel, mean_limit in ((offsets.mask, 0.03), (offsets.rgb, 0.03), (offsets.depth, 0.03)):
        assert np.linalg.norm(channel.mean(axis=0)) < mean_limit
        assert np.linalg.norm(channel, axis=1).mean() < 0.1
