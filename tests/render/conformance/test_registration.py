"""Every channel of every backend lies where the camera model says, to a tenth of a pixel, colours included."""

from dataclasses import dataclass

import cv2
import numpy as np
import pytest

from tests.render.conformance.subject import Subject
from tests.render.known_box import OFF_CENTRE, SIZE, polygon_centroid, random_placements, ray_box_depth
from tests.render.scenes import box_model, make_scene
from warehouse_sim.geometry.boxes import box_corners
from warehouse_sim.geometry.pose import invert, transform_points
from warehouse_sim.schema import Material, RenderBuffers, SceneSpec

pytestmark = pytest.mark.gl

PLACEMENTS = 24


@dataclass(frozen=True, eq=False)
class Offsets:
    """How far each placement's picture lies from where it belongs (n 2), in pixels."""

    mask: np.ndarray
    rgb: np.ndarray
    depth: np.ndarray


def glowing_box() -> SceneSpec:
    """A box at the world's origin that shines evenly in the dark: its picture is its silhouette."""
    glow = {"glow": Material("glow", (0.5, 0.5, 0.5), emission=0.6 / 0.015)}
    return make_scene([box_model("box", SIZE, "glow")], [("box", np.eye(4))], materials=glow, ambient=0.0)


def image_centroid(weight: np.ndarray) -> np.ndarray:
    rows, columns = np.indices(weight.shape)
    return np.array([(columns * weight).sum(), (rows * weight).sum()]) / weight.sum()


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
    for T_camera_object in random_placements(PLACEMENTS, margin=4):
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
