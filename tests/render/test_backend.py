import hashlib
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from warehouse_sim.errors import RenderError, UnknownNameError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.geometry.pose import level_camera
from warehouse_sim.render import Renderer, open_renderer
from warehouse_sim.render.conformance.scenes import at, box_model, make_scene
from warehouse_sim.schema import Part, SceneSpec

pytestmark = pytest.mark.gl

CAMERA = PinholeCamera.from_focal(640, 200, 380.0)


def digest(renderer: Renderer, scene: SceneSpec) -> str:
    """Return a hash of all that a scene's views and amodal masks hold."""
    renderer.load(scene)
    total = hashlib.sha256()
    for viewpoint in scene.viewpoints:
        buffers = renderer.render(CAMERA, viewpoint.T_world_camera, normals=True)
        assert buffers.normals is not None
        for image in (buffers.rgb, buffers.depth, buffers.instance_mask, buffers.normals):
            total.update(image.tobytes())
        for amodal_mask in renderer.amodal_masks(CAMERA, viewpoint.T_world_camera, scene.target_instances()):
            total.update(repr(amodal_mask.offset).encode() + amodal_mask.mask.tobytes())
    return total.hexdigest()


def test_the_number_of_driver_threads_changes_no_byte(renderer: Renderer, wall: SceneSpec) -> None:
    root = Path(__file__).resolve().parents[2]
    script = (
        "from warehouse_sim.render.conformance.scenes import rack_wall; from tests.render.test_backend import digest\n"
        "from warehouse_sim.render import open_renderer\n"
        "with open_renderer() as renderer: print(digest(renderer, rack_wall()))"
    )
    threads = "1" if os.environ.get("LP_NUM_THREADS") != "1" else "2"  # than this process has
    environment = {**os.environ, "LP_NUM_THREADS": threads}
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=root, env=environment, capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == digest(renderer, wall)


def test_any_mesh_is_drawn_not_only_boxes(renderer: Renderer) -> None:
    """A pyramid over a square, seen from above and from the side."""
    corners = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0), (0, 0, 1)]
    faces = [(0, 2, 1), (0, 3, 2), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)]
    pyramid = TriangleMesh(np.array(corners, float), np.array(faces, np.int32))
    box = box_model("pyramid", (1, 1, 1))
    part = Part(pyramid, np.array([0.5, 0.5, 0.8]), np.eye(4), "kraft")
    scene = make_scene([replace(box, parts=(part,))], [("pyramid", at(0, 0, 0))])
    renderer.load(scene)
    camera = PinholeCamera.from_focal(201, 201, 200.0)
    above = renderer.render(camera, level_camera(np.array([0.0, 0.0, 4.0]), 0.0, -np.pi / 2))
    assert np.count_nonzero(above.instance_mask) == pytest.approx((200.0 / 4.0) ** 2, rel=0.03)
    assert above.depth[100, 100] == pytest.approx(3.2, abs=0.02)
    side = renderer.render(camera, level_camera(np.array([-4.0, 0.0, 0.4]), 0.0)).instance_mask
    widths = np.count_nonzero(side, axis=1)
    assert np.count_nonzero(widths) == pytest.approx(0.8 * 200 / 3.75, abs=3)
    assert (np.diff(widths[widths > 0]) >= 0).all()


def test_use_before_load_and_after_close_is_rejected(wall: SceneSpec) -> None:
    T = wall.viewpoints[0].T_world_camera
    with open_renderer() as fresh:
        with pytest.raises(RenderError, match="no scene is loaded"):
            fresh.render(CAMERA, T)
        with pytest.raises(RenderError, match="no scene is loaded"):
            fresh.amodal_masks(CAMERA, T, [])
    fresh.close()
    with pytest.raises(RenderError, match="closed"):
        fresh.load(wall)


def test_an_unknown_backend_lists_the_known_ones() -> None:
    with pytest.raises(UnknownNameError, match=r"unknown render backend 'rastr' .*did you mean 'raster'"):
        open_renderer("rastr")


def test_an_image_that_is_too_large_is_rejected(renderer: Renderer, wall: SceneSpec) -> None:
    renderer.load(wall)
    with pytest.raises(RenderError, match="an image of 4097 x 10 is too large"):
        renderer.render(PinholeCamera.from_focal(4097, 10, 500.0), wall.viewpoints[0].T_world_camera)
