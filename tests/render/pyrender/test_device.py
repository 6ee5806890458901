import os
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.render import Renderer
from warehouse_sim.render.conformance.scenes import rack_wall

ROOT = Path(__file__).resolve().parents[3]
CAMERA = PinholeCamera.from_focal(120, 80, 90.0)


def run(script: str) -> subprocess.CompletedProcess[str]:
    kept = {key: value for key, value in os.environ.items() if key not in ("PYOPENGL_PLATFORM", "EGL_DEVICE_ID")}
    command = [sys.executable, "-c", script]
    return subprocess.run(command, cwd=ROOT, env=kept, capture_output=True, text=True, check=False)


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
