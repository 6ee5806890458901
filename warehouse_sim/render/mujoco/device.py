"""OpenGL for MuJoCo without a display: EGL on a device of choice, or OSMesa."""

import os
from importlib import import_module
from typing import Any, Literal

from warehouse_sim.errors import RenderError
from warehouse_sim.render.pyopengl_platform import claim_platform, remedy


def choose_platform(platform: Literal["egl", "osmesa"] | None) -> Literal["egl", "osmesa"]:
    """Return ``platform``, or what MUJOCO_GL requires, or EGL.

    Raises:
        RenderError: Neither is a platform that draws without a display.
    """
    wanted = platform or os.environ.get("MUJOCO_GL", "").strip().lower() or "egl"
    if wanted == "egl":
        return "egl"
    if wanted == "osmesa":
        return "osmesa"
    raise RenderError(f"the mujoco backend renders through egl or osmesa, not {wanted!r}; change platform or MUJOCO_GL")


def open_device(platform: Literal["egl", "osmesa"], device: int | None) -> tuple[Any, str]:
    """Return a current OpenGL context of MuJoCo and the name and version of its driver.

    Args:
        platform: What to draw through; the first one opened binds the process.
        device: Number of the EGL device; None = the first that works, or MUJOCO_EGL_DEVICE_ID.

    Raises:
        RenderError: A library is missing or too old, or the device cannot be opened.
    """
    claim_platform(platform, "mujoco")
    os.environ["MUJOCO_GL"] = platform  # MuJoCo's library reads it when it looks up the functions of OpenGL
    if device is not None:
        os.environ["MUJOCO_EGL_DEVICE_ID"] = str(device)
    try:
        context = import_module(f"mujoco.{platform}").GLContext(64, 64)  # images are rendered into buffers of their own
        context.make_current()
        return context, _describe()
    except (ImportError, AttributeError) as error:
        raise RenderError(
            f"MuJoCo cannot use PyOpenGL for {platform} ({error}); pip install 'PyOpenGL>=3.1.9', which pyrender 0.1 "
            f"forbids and pyrender2 does not, and a driver: {remedy(platform)}"
        ) from error
    except Exception as error:  # PyOpenGL and EGL raise all kinds
        where = f"EGL device {'' if device is None else device}".strip() if platform == "egl" else "OSMesa"
        raise RenderError(f"MuJoCo opens no OpenGL context on {where} ({_line(error)}); {remedy(platform)}") from error


def _describe() -> str:
    gl = import_module("OpenGL.GL")
    renderer, version = (gl.glGetString(name).decode() for name in (gl.GL_RENDERER, gl.GL_VERSION))
    return f"{renderer}, OpenGL {version}"


def _line(error: Exception) -> str:
    return " ".join(str(error).split()) or type(error).__name__
