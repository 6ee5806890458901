"""Pixels lie where the camera model says, in every channel."""

import cv2
import numpy as np
import pytest

from warehouse_sim.geometry.boxes import box_corners
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import (
    invert,
    level_camera,
    transform_points,
)
from warehouse_sim.render import Renderer
from warehouse_sim.render.conformance.scenes import at, box_model, make_scene
from warehouse_sim.render.conformance.subject import (
    OFF_CENTRE,
    SIZE,
    cast_image,
    polygon_centroid,
    random_placements,
    ray_box_depth,
)
from warehouse_sim.schema import SceneSpec

pytestmark = pytest.mark.gl

KITTI = PinholeCamera.from_focal(1224, 370, 721.5377)


def test_masks_and_depth_lie_where_the_camera_projects(renderer: Renderer) -> None:
    """200 random placements: mask against the projected outline, depth against exact rays, both below 0.1 px."""
    model = box_model("box", SIZE)
    mask_offsets, depth_offsets = [], []
    all_rays = OFF_CENTRE.rays()
    # The box stands at the world's origin; the camera moves around it.
    renderer.load(make_scene([model], [("box", np.eye(4))]))
    for T_camera_object in random_placements(200, margin=2):
        buffers = renderer.render(OFF_CENTRE, invert(T_camera_object))
        rows, columns = np.nonzero(buffers.instance_mask)
        corners = OFF_CENTRE.project(transform_points(T_camera_object, box_corners(SIZE)))
        outline = cv2.convexHull(corners.astype(np.float32))[:, 0].astype(float)
        mask_offsets.append(np.array([columns.mean(), rows.mean()]) - polygon_centroid(outline))
        rays = all_rays[rows, columns]
        gt_depth, normals = ray_box_depth(T_camera_object, rays)
        # On the plane n.p = c: z = c / (n.ray), whose derivatives by u and v say how far the image would have to move.
        facing = (normals * rays).sum(axis=-1, keepdims=True)
        per_pixel = -gt_depth[:, None] * normals[:, :2] / (facing * [OFF_CENTRE.fx, OFF_CENTRE.fy])
        error = buffers.depth[rows, columns] - gt_depth
        same_face = np.abs(error) < 0.02
        assert same_face.mean() > 0.97
        depth_offsets.append(np.linalg.lstsq(per_pixel[same_face], error[same_face], rcond=None)[0])
    assert np.linalg.norm(np.mean(mask_offsets, axis=0)) < 0.02
    assert np.linalg.norm(mask_offsets, axis=1).mean() < 0.1
    assert np.linalg.norm(np.mean(depth_offsets, axis=0)) < 0.02
    assert np.linalg.norm(depth_offsets, axis=1).mean() < 0.02


@pytest.mark.parametrize("pitch", [0.0, -0.3, -1.2])
def test_the_depth_of_a_plane_equals_the_closed_form(renderer: Renderer, pitch: float) -> None:
    renderer.load(make_scene([box_model("floor", (120, 120, 0.1), "concrete")], [("floor", at(0, 0, -0.05))]))
    height = 1.65
    T = level_camera(np.array([0.0, 0.0, height]), 0.3, pitch)
    depth = renderer.render(KITTI, T).depth
    down = -(KITTI.rays() @ T[:3, :3].T)[..., 2]
    points = np.where(down > 0, height / np.where(down > 0, down, 1.0), np.inf)
    on_floor = points < 35.0
    assert np.count_nonzero(on_floor) > 100_000
    error = np.abs(depth[on_floor] - points[on_floor])
    assert (error < 0.001 + 0.001 * points[on_floor]).all()
    assert np.median(error) < 0.0005
    assert (depth[points > 120.0] == 0.0).all()


def test_every_channel_agrees_with_ray_casting(renderer: Renderer, wall: SceneSpec) -> None:
    renderer.load(wall)
    for viewpoint in wall.viewpoints:
        buffers = renderer.render(KITTI, viewpoint.T_world_camera, normals=True)
        gt = cast_image(wall, KITTI, viewpoint.T_world_camera)
        inside = gt.inside()
        assert inside.mean() > 0.7
        assert (buffers.instance_mask == gt.instance_mask)[inside].mean() >= 0.999
        assert (buffers.instance_mask == gt.instance_mask).mean() >= 0.997
        compared = inside & (gt.instance_mask > 0) & (buffers.instance_mask == gt.instance_mask)
        error = np.abs(buffers.depth - gt.depth)[compared]
        assert np.quantile(error - 0.001 * gt.depth[compared], 0.9999) < 0.001
        assert buffers.normals is not None
        cosine = (buffers.normals * gt.normals).sum(axis=-1)[compared]
        assert np.quantile(np.degrees(np.arccos(np.clip(cosine, -1, 1))), 0.9999) < 0.1
        assert (buffers.normals[buffers.instance_mask == 0] == 0.0).all()
        assert ((buffers.depth == 0.0) == (buffers.instance_mask == 0)).all()


def test_a_window_of_the_image_is_the_image_of_the_cropped_camera(renderer: Renderer, wall: SceneSpec) -> None:
    """The principal point may lie anywhere, even outside the image."""
    renderer.load(wall)
    T = wall.viewpoints[1].T_world_camera
    whole = renderer.render(KITTI, T)
    for left, top, width, height in ((700, 40, 400, 300), (0, 0, 200, 100), (1000, 300, 224, 70)):
        part = renderer.render(KITTI.crop(left, top, width, height), T)
        window = (slice(top, top + height), slice(left, left + width))
        same = part.instance_mask == whole.instance_mask[window]
        assert same.mean() >= 0.9998  # vertices are rounded to 1/256 px: a few outlines move by that much
        assert np.quantile(np.abs(part.depth - whole.depth[window])[same], 0.999) < 0.001
