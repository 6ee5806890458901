"""The one OpenGL context of pyrender in a process."""

import os
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from types import ModuleType
from typing import Any

from warehouse_sim.errors import RenderError
from warehouse_sim.optional import require
from warehouse_sim.render.pyopengl_platform import claim_platform, remedy

_offscreen: Any = None
"""pyrender's renderer; kept when a backend closes, because deleting it ends EGL for the whole process."""
_in_use = False


def import_pyrender() -> ModuleType:
    """Import pyrender, which looks for a display unless PyOpenGL is set to EGL.

    Raises:
        RenderError: EGL is missing or this process renders through another platform.
        MissingPackageError: pyrender is not installed.
    """
    claim_platform("egl", "pyrender")
    return require("pyrender", "peers", "for the pyrender renderer")


def open_offscreen(device: int) -> tuple[Any, str]:
    """Return pyrender's renderer and the name and version of its driver.

    Args:
        device: Number of the EGL device.

    Raises:
        RenderError: It is in use, or no context can be opened.
    """
    global _offscreen, _in_use
    if _in_use:
        raise RenderError("a process holds one pyrender renderer, and one is open; close it first")
    pyrender = import_pyrender()
    if _offscreen is None:
        os.environ["EGL_DEVICE_ID"] = str(device)
        try:
            _offscreen = pyrender.OffscreenRenderer(64, 64)
        except Exception as error:  # PyOpenGL and EGL raise all kinds, bare assertions among them
            reason = " ".join(str(error).split()) or type(error).__name__
            raise RenderError(
                f"pyrender opens no OpenGL 4.1 context on EGL device {device} ({reason}); {remedy('egl')}"
            ) from error
    elif os.environ.get("EGL_DEVICE_ID") != str(device):
        raise RenderError(
            f"pyrender renders on EGL device {os.environ.get('EGL_DEVICE_ID')} in this process; "
            f"start another process for device {device}"
        )
    _in_use = True
    return _offscreen, f"{_package()} on {_driver()}"


def close_offscreen() -> None:
    """Free all that was uploaded, and let another backend open."""
    global _in_use
    if _in_use and _offscreen is not None:
        _offscreen._platform.make_current()
        _offscreen._renderer.delete()
        _offscreen._renderer._shadow_fb = None  # deleted, but not forgotten
    _in_use = False


def _driver() -> str:
    _offscreen._platform.make_current()
    gl = import_module("OpenGL.GL")
    renderer, release = (gl.glGetString(name).decode() for name in (gl.GL_RENDERER, gl.GL_VERSION))
    return f"{renderer}, OpenGL {release}"


def _package() -> str:
    for name in ("pyrender2", "pyrender"):
        try:
            return f"{name} {version(name)}"
        except PackageNotFoundError:
            continue
    return "pyrender"
