"""Depth, ids and normals of every backend against exact rays through the pixels' centres."""

import cv2
import numpy as np
import pytest

from tests.render.conformance.subject import KITTI, VIEWS, Subject, truth, view
from tests.render.scenes import at, box_model, make_scene
from warehouse_sim.geometry.pose import level_camera

pytestmark = pytest.mark.gl


@pytest.mark.parametrize("name", VIEWS)
def test_every_channel_agrees_with_ray_casting(subject: Subject, name: str) -> None:
    exact, inside = truth(name), truth(name).inside()
    assert inside.mean() > 0.6
    seen = view(name)
    has_normals = subject.renderer.capabilities.normals
    buffers = subject.draw(seen.scene, seen.camera, seen.T_world_camera, normals=has_normals)
    same = buffers.instance_ids == exact.instance_ids
    assert buffers.instance_ids.dtype == np.int32
    assert same[inside].mean() >= 0.999
    assert same.mean() >= 0.997
    compared = inside & (exact.instance_ids > 0) & same
    error = np.abs(buffers.depth - exact.depth) - 0.001 * exact.depth
    assert buffers.depth.dtype == np.float32
    assert np.quantile(error[compared], 0.9999) < 0.001
    # Where nothing is, nothing is said: no depth and no id, and no blend of one id with the next.
    assert ((buffers.depth == 0.0) == (buffers.instance_ids == 0)).all()
    assert set(np.unique(buffers.instance_ids)) <= {0, *(item.instance_id for item in seen.scene.instances)}
    assert buffers.rgb.shape == (*exact.depth.shape, 3)
    if has_normals:
        assert buffers.normals is not None
        cosine = (buffers.normals * exact.normals).sum(axis=-1)[compared]
        assert np.quantile(np.degrees(np.arccos(np.clip(cosine, -1, 1))), 0.9999) < 1.0
        np.testing.assert_allclose(np.linalg.norm(buffers.normals[compared], axis=-1), 1.0, atol=1e-3)
        assert (buffers.normals[buffers.instance_ids == 0] == 0.0).all()


@pytest.mark.parametrize("pitch", [0.0, -0.3])
def test_the_depth_of_a_plane_equals_the_closed_form(subject: Subject, pitch: float) -> None:
    scene = make_scene([box_model("floor", (120, 120, 0.1), "concrete")], [("floor", at(0, 0, -0.05))])
    height, camera = 1.65, KITTI.crop(300, 0, 600, 370)
    T = level_camera(np.array([0.0, 0.0, height]), 0.3, pitch)
    depth = subject.draw(scene, camera, T).depth
    down = -(camera.rays() @ T[:3, :3].T)[..., 2]
    exact = np.where(down > 0, height / np.where(down > 0, down, 1.0), np.inf)
    on_floor = exact < 35.0
    assert np.count_nonzero(on_floor) > 50_000
    error = np.abs(depth[on_floor] - exact[on_floor])
    assert (error < 0.001 + 0.001 * exact[on_floor]).all()
    assert np.median(error) < 0.001
    assert (depth[exact > 120.0] == 0.0).all()


def test_a_window_of_the_image_is_the_image_of_the_cropped_camera(subject: Subject) -> None:
    """The principal point may lie anywhere, even outside the image."""
    seen = view("whole image")
    whole = subject.draw(seen.scene, KITTI, seen.T_world_camera)
    for left, top, width, height in ((500, 40, 400, 300), (1000, 300, 224, 70)):
        part = subject.renderer.render(KITTI.crop(left, top, width, height), seen.T_world_camera)
        window = (slice(top, top + height), slice(left, left + width))
        same = part.instance_ids == whole.instance_ids[window]
        assert same.mean() >= 0.9995  # drivers round vertices to 1/256 px: a few outlines move by that much
        assert np.quantile(np.abs(part.depth - whole.depth[window])[same], 0.999) < 0.001
        # Colours are those of the same surfaces: means over 8 x 8 pixels, so that a path tracer's noise averages out.
        colors = (cv2.blur(image.astype(np.float32), (8, 8))[4:-4, 4:-4] for image in (part.rgb, whole.rgb[window]))
        assert np.median(np.abs(np.subtract(*colors))) < 3.0
