import hashlib
import os
import subprocess
import sys
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from warehouse_sim.errors import ConfigError, RenderError, UnknownNameError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.geometry.pose import level_camera
from warehouse_sim.render import BACKENDS, Renderer, backend_options, open_renderer, option_settings
from warehouse_sim.render.conformance.scenes import at, box_model, make_scene
from warehouse_sim.render.raster.backend import RasterOptions
from warehouse_sim.schema import Part, SceneSpec

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


@pytest.mark.gl
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


@pytest.mark.gl
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


@pytest.mark.gl
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


@pytest.mark.gl
def test_an_unknown_backend_lists_the_known_ones() -> None:
    with pytest.raises(UnknownNameError, match=r"unknown render backend 'rastr' .*did you mean 'raster'"):
        open_renderer("rastr")


@pytest.mark.gl
def test_an_image_that_is_too_large_is_rejected(renderer: Renderer, wall: SceneSpec) -> None:
    renderer.load(wall)
    with pytest.raises(RenderError, match="an image of 4097 x 10 is too large"):
        renderer.render(PinholeCamera.from_focal(4097, 10, 500.0), wall.viewpoints[0].T_world_camera)


# Each backend declares its own options; what they are given is checked before anything is opened.


@dataclass(frozen=True)
class StubOptions:
    colour: str = "grey"
    levels: int = 3


class WithOptions:
    Options = StubOptions

    def __init__(self, options: StubOptions) -> None:
        self.options = options


class Plain:
    """A backend that can be told nothing."""


@pytest.fixture
def strangers(monkeypatch: pytest.MonkeyPatch) -> None:
    known = BACKENDS._targets
    monkeypatch.setattr(
        BACKENDS, "_targets", {**known, "told": f"{__name__}:WithOptions", "plain": f"{__name__}:Plain"}
    )


def test_text_becomes_the_checked_options_of_the_backend() -> None:
    assert backend_options("raster", {"device": "3"}) == RasterOptions(device=3)
    assert backend_options("raster", {}) == RasterOptions()
    with pytest.raises(ConfigError, match=r"options of the render backend raster: devcie .* did you mean 'device'"):
        backend_options("raster", {"devcie": "0"})
    with pytest.raises(ConfigError, match=r"options of the render backend raster: device must be .*found 'first'"):
        backend_options("raster", {"device": "first"})
    with pytest.raises(ConfigError, match=r"device must be 0-1,023, found -1"):
        backend_options("raster", {"device": "-1"})
    with pytest.raises(ConfigError, match="device: is not valid YAML"):
        backend_options("raster", {"device": "["})
    with pytest.raises(UnknownNameError, match="rastr"):
        backend_options("rastr", {})


@pytest.mark.usefixtures("strangers")
def test_a_strangers_backend_gets_its_options_or_none() -> None:
    opened = open_renderer("told", backend_options("told", {"colour": "red", "levels": "5"}))
    assert isinstance(opened, WithOptions)
    assert opened.options == StubOptions("red", 5)
    assert isinstance(open_renderer("plain"), Plain)
    with pytest.raises(ConfigError, match=r"render backend plain: colour given, but it takes none"):
        backend_options("plain", {"colour": "red"})
    with pytest.raises(ConfigError, match="takes its own options alone"):
        open_renderer("told", RasterOptions())
    with pytest.raises(ConfigError, match="takes its own options alone"):
        open_renderer("plain", RasterOptions())


def test_texts_of_a_command_line_become_the_settings_that_they_give() -> None:
    assert option_settings("raster", []) == {}
    assert option_settings("raster", ["device=3"]) == {"device": 3}
    with pytest.raises(ConfigError, match=r"expected key=value, each key once; found 'device'"):
        option_settings("raster", ["device"])
    with pytest.raises(ConfigError, match=r"each key once; found 'device=2'"):
        option_settings("raster", ["device=1", "device=2"])
