"""Scenes for other programs: USD for simulators and film tools, MJCF for MuJoCo, GLB for engines and viewers.

A format's packages are imported when one of its names is first used.
"""

from importlib import import_module
from typing import Any

_HOMES = {
    "Carriage": "mjcf",
    "read_usd": "usd",
    "write_glb": "glb",
    "write_mjcf": "mjcf",
    "write_usd": "usd",
}

__all__ = list(_HOMES)


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
