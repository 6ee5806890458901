"""Every channel of a backend lies where the camera model says, to a tenth of a pixel, colours included."""

from dataclasses import dataclass

import cv2
import numpy as np

from warehouse_sim.geometry.boxes import box_corners
from warehouse_sim.geometry.pose import invert, transform_points
from warehouse_sim.render.conformance.scenes import box_model, make_scene
from warehouse_sim.render.conformance.subject import (
    OFF_CENTRE,
    SIZE,
    Subject,
    polygon_centroid,
    random_placements,
    ray_box_depth,
)
from warehouse_sim.schema import Material, RenderBuffers, SceneSpec

_PLACEMENTS = 24


@dataclass(frozen=True, eq=False)
class Offsets:
    """How far each placement's image lies from where it belongs (n 2), in pixels."""

    mask: np.ndarray
    rgb: np.ndarray
    depth: np.ndarray


def _glowing_box() -> SceneSpec:
    """Return a box at the world's origin that shines evenly in the dark: its image is its amodal mask."""
    glow = {"glow": Material("glow", (0.5, 0.5, 0.5), emission=0.6 / 0.015)}
    return make_scene([box_model("box", SIZE.tolist(), "glow")], [("box", np.eye(4))], materials=glow, ambient=0.0)


def _image_centroid(weight: np.ndarray) -> np.ndarray:
    rows, columns = np.indices(weight.shape)
    return np.array([(columns * weight).sum(), (rows * weight).sum()]) / weight.sum()


def _depth_offset(subject: Subject, buffers: RenderBuffers, T_camera_object: np.ndarray) -> np.ndarray:
    """Return by how much the depth image would have to move to be exact, by least squares over its pixels."""
    rows, columns = np.nonzero(buffers.instance_mask)
    rays = OFF_CENTRE.rays()[rows, columns]
    exact, normals = ray_box_depth(T_camera_object, rays)
    # On the plane n.p = c: z = c / (n.ray), whose derivatives by u and v say how far the image would have to move.
    facing = (normals * rays).sum(axis=-1, keepdims=True)
    per_pixel = -exact[:, None] * normals[:, :2] / (facing * [OFF_CENTRE.fx, OFF_CENTRE.fy])
    error = buffers.depth[rows, columns] - exact
    same_face = np.abs(error) < 0.02
    subject.expect(same_face.mean() > 0.97, f"{same_face.mean():.1%} of a box has the depth of the face there")
    return np.linalg.lstsq(per_pixel[same_face], error[same_face], rcond=None)[0]


def measure_offsets(subject: Subject) -> Offsets:
    """Measure all channels with a box at many places, whose image is known in closed form."""
    subject.renderer.load(_glowing_box())
    mask, rgb, depth = [], [], []
    for T_camera_object in random_placements(_PLACEMENTS, margin=4):
        buffers = subject.renderer.render(OFF_CENTRE, invert(T_camera_object))
        corners = OFF_CENTRE.project(transform_points(T_camera_object, box_corners(SIZE)))
        exact = polygon_centroid(cv2.convexHull(corners.astype(np.float32))[:, 0].astype(float))
        mask.append(_image_centroid(buffers.instance_mask != 0) - exact)
        rgb.append(_image_centroid(buffers.rgb.astype(float).sum(axis=2)) - exact)
        depth.append(_depth_offset(subject, buffers, T_camera_object))
    return Offsets(*map(np.array, (mask, rgb, depth)))


def check_registration(subject: Subject) -> None:
    """Expect each channel within a tenth of a pixel: half a pixel, the commonest error, is five times as much."""
    offsets = measure_offsets(subject)
    for channel in ("mask", "rgb", "depth"):
        measured = getattr(offsets, channel)
        mean, size = np.linalg.norm(measured.mean(axis=0)), np.linalg.norm(measured, axis=1).mean()
        subject.expect(mean < 0.03, f"{channel} lies {mean:.3f} px beside where the camera projects")
        subject.expect(size < 0.1, f"{channel} lies {size:.3f} px from where the camera projects, on average")
