"""Rigid-body physics: a scene as a MuJoCo model, brought to rest and checked.

Importing this room imports MuJoCo only when one of its names is used.
"""

from typing import Any

from warehouse_sim.optional import imported_when_used

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
    return imported_when_used(__name__, _HOMES, name)
