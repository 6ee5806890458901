import os
import subprocess
import sys
from pathlib import Path

import pytest

from warehouse_sim.errors import RenderError
from warehouse_sim.render import open_renderer, pyopengl_platform

ROOT = Path(__file__).resolve().parents[3]
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
    kept = {key: value for key, value in os.environ.items() if key not in ("PYOPENGL_PLATFORM", "MUJOCO_GL")}
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
