"""Which window system PyOpenGL, and with it MuJoCo and pyrender, renders through: one for the life of a process."""

import ctypes
import os
import sys
from typing import Literal

from warehouse_sim.errors import RenderError

Platform = Literal["egl", "osmesa"]

LIBRARIES: dict[str, tuple[str, ...]] = {
    "egl": ("libEGL.so.1",),
    "osmesa": ("libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so"),
}
_REMEDIES = {
    "egl": "install the EGL loader and a driver: apt-get install libegl1 libegl-mesa0 libgl1-mesa-dri",
    "osmesa": "apt-get install libosmesa6 where it still exists (Mesa 25.1 removed OSMesa), or draw through EGL",
}


def claim_platform(platform: Platform, who: str) -> None:
    """Make PyOpenGL draw through ``platform``, before it is imported.

    Args:
        platform: EGL, hardware or software, or OSMesa, Mesa's old software renderer.
        who: The backend that asks, for errors.

    Raises:
        RenderError: The library is missing, or the process renders through another one already.
    """
    taken = _taken_platform()
    if taken is not None and taken != platform:
        raise RenderError(
            f"the {who} backend cannot render through {platform}: it renders through {taken} already "
            f"(PYOPENGL_PLATFORM), and a process can hold only one; start another process for {platform}"
        )
    _require_library(platform)
    os.environ["PYOPENGL_PLATFORM"] = platform


def remedy(platform: Platform) -> str:
    """Return what to do when no context can be opened."""
    return _REMEDIES[platform]


def _taken_platform() -> str | None:
    loaded = sys.modules.get("OpenGL.platform")
    if loaded is not None and getattr(loaded, "PLATFORM", None) is not None:
        return type(loaded.PLATFORM).__name__.removesuffix("Platform").lower()
    return os.environ.get("PYOPENGL_PLATFORM") or None


def _require_library(platform: Platform) -> None:
    reasons = []
    for name in LIBRARIES[platform]:
        try:
            ctypes.CDLL(name)
        except OSError as error:
            reasons.append(str(error))
        else:
            return
    raise RenderError(f"{LIBRARIES[platform][0]} cannot be loaded ({reasons[0]}); {remedy(platform)}")
