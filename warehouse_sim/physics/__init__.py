"""Rigid-body physics: a scene as a MuJoCo model, brought to rest and checked.

Importing this room imports MuJoCo only when one of its names is used.
"""

from importlib import import_module
from typing import Any

_HOMES = {
    "ContactState": "check",
    "CrushFault": "crush",
    "CrushState": "crush",
    "SettleConfig": "settle",
    "SettleReport": "check",
    "contact_state": "check",
    "crush_state": "crush",
    "settle_scene": "settle",
    "to_mjspec": "build",
}

__all__ = list(_HOMES)


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
