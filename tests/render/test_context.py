import os
import subprocess
import sys
from pathlib import Path

import pytest

from warehouse_sim.errors import RenderError
from warehouse_sim.render import open_renderer
from warehouse_sim.render.raster import context

ROOT = Path(__file__).resolve().parents[2]


def test_without_the_egl_library_the_error_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(context, "EGL_LIBRARY", "libEGL-not-there.so.1")
    with pytest.raises(RenderError) as caught:
        open_renderer()
    message = str(caught.value)
    assert message.startswith("libEGL-not-there.so.1 cannot be loaded")
    assert "apt-get install libegl1 libegl-mesa0 libgl1-mesa-dri" in message
    assert "\n" not in message


@pytest.mark.gl
@pytest.mark.parametrize("device", [99, 1000])
def test_a_device_that_does_not_exist_is_named(device: int) -> None:
    with pytest.raises(RenderError, match=f"opens no OpenGL 4.5 context on EGL device {device} ") as caught:
        open_renderer(device=device)
    assert "\n" not in str(caught.value)


@pytest.mark.gl
def test_a_driver_that_is_too_old_is_one_clear_error() -> None:
    """Mesa pretends to know OpenGL 3.3 only; in a process of its own, since it reads that once."""
    script = (
        "from warehouse_sim.errors import RenderError\n"
        "from warehouse_sim.render import open_renderer\n"
        "try: open_renderer()\n"
        "except RenderError as error: print(error)"
    )
    environment = {**os.environ, "LIBGL_ALWAYS_SOFTWARE": "1", "MESA_GL_VERSION_OVERRIDE": "3.3"}
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True, cwd=ROOT, env=environment
    )
    assert done.stdout.startswith("libEGL.so.1 opens no OpenGL 4.5 context on EGL device 0 ")
    assert "install the EGL loader and a driver with OpenGL 4.5" in done.stdout
    assert done.stdout.count("\n") == 1


def test_without_moderngl_the_error_says_which_extra_brings_it() -> None:
    script = (
        "import sys; sys.modules['moderngl'] = None\n"
        "from warehouse_sim.errors import MissingPackageError\n"
        "from warehouse_sim.render import open_renderer\n"
        "try: open_renderer()\n"
        "except MissingPackageError as error: print(error)"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True, cwd=ROOT)
    assert "moderngl is needed for the raster renderer" in done.stdout
    assert "pip install 'warehouse-sim[generate]'" in done.stdout
