"""Scenes for other programs: USD for simulators and film tools, MJCF for MuJoCo, GLB for engines and viewers.

A format's packages are imported when one of its names is first used.
"""

from typing import Any

from warehouse_sim.optional import imported_when_used

_HOMES = {
    "Carriage": "mjcf",
    "read_usd": "usd",
    "write_glb": "glb",
    "write_mjcf": "mjcf",
    "write_usd": "usd",
}

__all__ = list(_HOMES)


def __getattr__(name: str) -> Any:
    return imported_when_used(__name__, _HOMES, name)
