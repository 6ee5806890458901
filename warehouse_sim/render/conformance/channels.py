"""Every channel of a backend against exact rays through pixel centres, and against closed forms."""

from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Bool

from warehouse_sim.errors import RenderError
from warehouse_sim.geometry.boxes import box_corners
from warehouse_sim.geometry.pose import invert, level_camera, transform_points
from warehouse_sim.render.conformance.scenes import at, box_model, make_scene
from warehouse_sim.render.conformance.subject import (
    KITTI,
    OFF_CENTRE,
    SIZE,
    GroundTruth,
    Subject,
    View,
    polygon_centroid,
    random_placements,
    ray_box_depth,
    view,
)
from warehouse_sim.schema import Material, RenderBuffers, SceneSpec


def check_view(subject: Subject, seen: View) -> None:
    """Compare every channel of a view with exact rays."""
    exact, inside = seen.gt, seen.gt.inside()
    has_normals = subject.renderer.capabilities.normals
    buffers = subject.render(seen.scene, seen.camera, seen.T_world_camera, normals=has_normals)
    same = buffers.instance_mask == exact.instance_mask
    subject.expect(
        buffers.instance_mask.dtype == np.int32, f"instance_mask is {buffers.instance_mask.dtype}, not int32"
    )
    subject.expect(
        same[inside].mean() >= 0.999, f"{same[inside].mean():.2%} of the instance mask inside surfaces is right"
    )
    subject.expect(same.mean() >= 0.997, f"{same.mean():.2%} of the instance mask is right")
    compared = inside & (exact.instance_mask > 0) & same
    error = np.quantile((np.abs(buffers.depth - exact.depth) - 0.001 * exact.depth)[compared], 0.9999)
    subject.expect(buffers.depth.dtype == np.float32, f"depth is {buffers.depth.dtype}, not float32")
    subject.expect(error < 0.001, f"depth is {error:.4f} m beyond 0.1 % from that of rays")
    nothing = buffers.instance_mask == 0
    subject.expect(
        ((buffers.depth == 0.0) == nothing).all(), "depth and instance masks must be zero in the same pixels"
    )
    known = {0, *(item.instance_id for item in seen.scene.instances)}
    subject.expect(
        set(np.unique(buffers.instance_mask)) <= known, "instance_mask holds ids that no object has: are they blended?"
    )
    subject.expect(buffers.rgb.shape == (*exact.depth.shape, 3), f"the image has the shape {buffers.rgb.shape}")
    if has_normals:
        _check_normals(subject, buffers, exact, compared)


def _check_normals(
    subject: Subject, buffers: RenderBuffers, exact: GroundTruth, compared: Bool[np.ndarray, "h w"]
) -> None:
    normals = buffers.normals
    if normals is None:
        raise RenderError(f"the {subject.name} backend does not conform: it declares normals and returns none")
    cosine = (normals * exact.normals).sum(axis=-1)[compared]
    angle = np.quantile(np.degrees(np.arccos(np.clip(cosine, -1, 1))), 0.9999)
    subject.expect(angle < 1.0, f"normals are {angle:.2f} deg from those of rays")
    length = np.linalg.norm(normals[compared], axis=-1)
    subject.expect(np.allclose(length, 1.0, rtol=0, atol=1e-3), "normals are not of unit length")
    subject.expect((normals[buffers.instance_mask == 0] == 0.0).all(), "normals must be zero where nothing is")


def check_depth_of_a_plane(subject: Subject) -> None:
    """Compare the depth of a floor, seen level and from above, with the closed form."""
    scene = make_scene([box_model("floor", (120, 120, 0.1), "concrete")], [("floor", at(0, 0, -0.05))])
    height, camera = 1.65, KITTI.crop(300, 0, 600, 370)
    for pitch in (0.0, -0.3):
        T = level_camera(np.array([0.0, 0.0, height]), 0.3, pitch)
        depth = subject.render(scene, camera, T).depth
        down = -(camera.rays() @ T[:3, :3].T)[..., 2]
        exact = np.where(down > 0, height / np.where(down > 0, down, 1.0), np.inf)
        on_floor = exact < 35.0
        error = np.abs(depth[on_floor] - exact[on_floor])
        subject.expect(
            (error < 0.001 + 0.001 * exact[on_floor]).all(), f"a floor is {error.max():.4f} m from its depth"
        )
        subject.expect(np.median(error) < 0.001, f"a floor is {np.median(error):.4f} m from its depth in the median")
        subject.expect((depth[exact > 120.0] == 0.0).all(), "depth beyond the end of a floor")


def check_window(subject: Subject) -> None:
    """Compare a window of the image with the image of the cropped camera, whose principal point may lie anywhere."""
    seen = view("whole image")
    whole = subject.render(seen.scene, KITTI, seen.T_world_camera)
    for left, top, width, height in ((500, 40, 400, 300), (1000, 300, 224, 70)):
        part = subject.renderer.render(KITTI.crop(left, top, width, height), seen.T_world_camera)
        window = (slice(top, top + height), slice(left, left + width))
        same = part.instance_mask == whole.instance_mask[window]
        # Drivers round vertices to 1/256 px: a few outlines move by that much.
        subject.expect(
            same.mean() >= 0.9995, f"{same.mean():.2%} of the instance mask of a cropped camera is that of the whole"
        )
        error = np.quantile(np.abs(part.depth - whole.depth[window])[same], 0.999)
        subject.expect(error < 0.001, f"the depth of a cropped camera is {error:.4f} m from that of the whole")
        # Colours are those of the same surfaces: means over 8 x 8 pixels, so that a path tracer's noise averages out.
        colors = (cv2.blur(image.astype(np.float32), (8, 8))[4:-4, 4:-4] for image in (part.rgb, whole.rgb[window]))
        apart = np.median(np.abs(np.subtract(*colors)))
        subject.expect(apart < 3.0, f"the colours of a cropped camera are {apart:.1f} from those of the whole")


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
