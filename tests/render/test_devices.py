import os
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

from warehouse_sim.errors import RenderError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.render import Renderer, open_renderer, pyopengl_platform
from warehouse_sim.render.conformance.scenes import rack_wall

ROOT = Path(__file__).resolve().parents[2]
DRAW = """
from dataclasses import replace
import numpy as np
from warehouse_sim.render.conformance.subject import cast_image
from warehouse_sim.render.conformance.scenes import rack_wall
from warehouse_sim.errors import RenderError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.render import open_renderer
camera, scene = PinholeCamera(200, 120, 150.0, 140.0, 60.0, 70.0), rack_wall(1, 1)
T = scene.viewpoints[0].T_world_camera
with open_renderer("mujoco", platform="osmesa") as renderer:
    renderer.load(scene)
    buffers = renderer.render(camera, T)
    exact = cast_image(scene, camera, T)
    inside = exact.inside()
    assert (buffers.instance_mask == exact.instance_mask)[inside].all()
    assert (np.abs(buffers.depth - exact.depth)[inside] < 0.001 + 0.001 * exact.depth[inside]).all()
    assert buffers.rgb.std() > 10
    print(renderer.description)
for name, options in (("mujoco", {"platform": "egl"}), ("pyrender", {})):
    try: open_renderer(name, **options)
    except RenderError as error: print(error)
"""


def run(script: str, **environment: str) -> subprocess.CompletedProcess[str]:
    chosen = ("PYOPENGL_PLATFORM", "MUJOCO_GL", "EGL_DEVICE_ID")
    kept = {key: value for key, value in os.environ.items() if key not in chosen}
    command = [sys.executable, "-c", script]
    return subprocess.run(command, cwd=ROOT, env=kept | environment, capture_output=True, text=True, check=False)


def has_osmesa() -> bool:
    try:
        pyopengl_platform._require_library("osmesa")
    except RenderError:
        return False
    return True


@pytest.mark.skipif(not has_osmesa(), reason="libOSMesa is not installed; Mesa 25.1 removed it")
def test_osmesa_draws_the_same_geometry_and_keeps_the_process_to_itself() -> None:
    done = run(DRAW)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert lines[0].startswith("mujoco on ")
    assert lines[0].endswith(" through osmesa")
    assert lines[1].startswith("the mujoco backend cannot render through egl: it renders through osmesa already")
    assert lines[2].startswith("the pyrender backend cannot render through egl: it renders through osmesa already")


def test_without_the_library_the_error_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("PYOPENGL_PLATFORM", raising=False)
    monkeypatch.setattr(pyopengl_platform, "_taken_platform", lambda: None)
    missing = {"egl": ("libEGL-not-there.so.1",), "osmesa": ("libOSMesa-not-there.so",)}
    monkeypatch.setattr(pyopengl_platform, "LIBRARIES", missing)
    with pytest.raises(RenderError, match=r"libOSMesa-not-there\.so cannot be loaded .*Mesa 25\.1 removed OSMesa"):
        open_renderer("mujoco", platform="osmesa")
    with pytest.raises(RenderError, match=r"libEGL-not-there\.so\.1 cannot be loaded .*apt-get install libegl1"):
        open_renderer("mujoco", platform="egl")


def test_a_platform_that_needs_a_display_is_rejected() -> None:
    script = (
        "from warehouse_sim.errors import RenderError\nfrom warehouse_sim.render import open_renderer\n"
        "try: open_renderer('mujoco')\nexcept RenderError as error: print(error)"
    )
    done = run(script, MUJOCO_GL="glfw")
    assert "renders through egl or osmesa, not 'glfw'; change platform or MUJOCO_GL" in done.stdout, done.stderr


@pytest.mark.gl
def test_a_device_that_does_not_exist_is_named() -> None:
    script = (
        "from warehouse_sim.errors import RenderError\nfrom warehouse_sim.render import open_renderer\n"
        "try: open_renderer('mujoco', device=99)\nexcept RenderError as error: print(error)"
    )
    done = run(script)
    assert "MuJoCo opens no OpenGL context on EGL device 99" in done.stdout, done.stderr
    assert done.stdout.count("\n") == 1


CAMERA = PinholeCamera.from_focal(120, 80, 90.0)


@pytest.mark.gl
def test_one_is_open_at_a_time_and_closing_it_ends_no_other_backend(renderer: Renderer) -> None:
    """pyrender's own clean-up ends EGL for the whole process: other contexts must survive a close."""
    if find_spec("pyrender") is None:  # imported here it would bind the process to a display
        pytest.skip("pyrender is not installed")
    script = """
from warehouse_sim.render.conformance.scenes import rack_wall
from warehouse_sim.errors import RenderError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.render import open_renderer
camera, scene = PinholeCamera.from_focal(120, 80, 90.0), rack_wall(1, 1)
T = scene.viewpoints[0].T_world_camera
raster, classic = open_renderer("raster"), open_renderer("mujoco")
for backend in (raster, classic):
    backend.load(scene)
first = [backend.render(camera, T).instance_mask.tobytes() for backend in (raster, classic)]
for _ in range(2):
    with open_renderer("pyrender") as peer:
        peer.load(scene)
        assert (peer.render(camera, T).instance_mask > 0).any()
        try: open_renderer("pyrender")
        except RenderError as error: print(error)
    assert [backend.render(camera, T).instance_mask.tobytes() for backend in (raster, classic)] == first
print("alive")
"""
    done = run(script)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines() == [
        *["a process holds one pyrender renderer, and one is open; close it first"] * 2,
        "alive",
    ]
    scene = rack_wall(1, 1)
    renderer.load(scene)
    assert renderer.render(CAMERA, scene.viewpoints[0].T_world_camera).depth.any()


def test_without_pyrender_the_error_says_which_extra_brings_it() -> None:
    script = (
        "import sys; sys.modules['pyrender'] = None\n"
        "from warehouse_sim.errors import MissingPackageError\n"
        "from warehouse_sim.render import open_renderer\n"
        "try: open_renderer('pyrender')\n"
        "except MissingPackageError as error: print(error)"
    )
    done = run(script)
    assert "pyrender: needed for the pyrender renderer" in done.stdout, done.stderr
    assert "pip install 'warehouse-sim[peers]'" in done.stdout


def test_naming_the_backends_imports_none_of_them() -> None:
    script = (
        "import sys\nfrom warehouse_sim.render import BACKENDS\n"
        "assert {'raster', 'mujoco', 'pyrender', 'pathtrace'} <= set(BACKENDS.names())\n"
        "print(sorted({'OpenGL', 'mujoco', 'pyrender', 'mitsuba', 'moderngl'} & set(sys.modules)))"
    )
    assert run(script).stdout.strip() == "[]"
