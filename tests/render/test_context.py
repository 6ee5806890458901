import ctypes.util
import os
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

from warehouse_sim.errors import RenderError
from warehouse_sim.render import open_renderer
from warehouse_sim.render.pathtrace import backend as variant
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


pathtracing = pytest.mark.skipif(find_spec("mitsuba") is None, reason="the extra pathtrace is not installed")


@pathtracing
def test_what_is_no_llvm_has_no_version(tmp_path: Path) -> None:
    (tmp_path / "libLLVM-19.so").write_text("no library")
    assert variant.llvm_version(tmp_path / "libLLVM-19.so") is None
    assert variant.llvm_version(Path(ctypes.util.find_library("c") or "libc.so.6")) is None


@pathtracing
def test_without_a_new_enough_llvm_the_error_names_the_package(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv(variant.LLVM_VARIABLE, raising=False)
    monkeypatch.setattr(variant, "installed_llvms", lambda: [tmp_path / "libLLVM-15.so.1"])
    with pytest.raises(
        RenderError, match=r"needs libLLVM 16 or later, found libLLVM-15\.so\.1; .*apt-get install libllvm19"
    ):
        variant.use_llvm_variant()
    monkeypatch.setenv(variant.LLVM_VARIABLE, "/nowhere/libLLVM.so")
    with pytest.raises(RenderError, match=r"DRJIT_LIBLLVM_PATH=/nowhere/libLLVM\.so is no LLVM library"):
        variant.use_llvm_variant()


@pathtracing
def test_libraries_that_are_too_old_are_passed_over(monkeypatch: pytest.MonkeyPatch) -> None:
    versions = {"libLLVM-15.so": (0,), "libLLVM-14.so": None, "libLLVM.so.19.1": (19, 1, 7)}
    monkeypatch.setattr(variant, "llvm_version", lambda path: versions[path.name])
    path, version = variant.find_llvm([Path(name) for name in versions])
    assert (path.name, version) == ("libLLVM.so.19.1", (19, 1, 7))
    with pytest.raises(RenderError, match=r"found libLLVM-15\.so"):
        variant.find_llvm([Path("libLLVM-15.so")])
