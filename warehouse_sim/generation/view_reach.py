"""How far from the horizon a recipe's cameras can look."""

import itertools
from typing import Any

import numpy as np

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.level_view import reach
from warehouse_sim.scene.viewpoints import ViewpointsConfig
from warehouse_sim.scene.viewpoints.mountings import MOUNTINGS

Degrees = tuple[float, float]


def view_reach_deg(recipe: dict[str, Any], kinds: tuple[str, ...], camera: PinholeCamera) -> float:
    """Return the largest angle to the horizon (deg) that an image can reach in its level view.

    Args:
        recipe: The resolved recipe as plain data.
        kinds: Kinds of viewpoints that tilt the camera.
        camera: The rig's camera.
    """
    views = recipe.get("scene", {}).get("viewpoints", {})
    rolls = _ends(views.get("roll_deg", 0.0))
    turns = {turn for kind in kinds for turn in itertools.product(_pitches(kind, views), rolls)}
    return float(np.rad2deg(max((reach(camera, *np.deg2rad(turn)) for turn in turns), default=0.0)))


def _pitches(kind: str, views: dict[str, Any]) -> Degrees:
    """Return least and largest pitch of a kind (deg): the recipe's, or else its own."""
    if kind == "free":
        low, high = _ends(views.get("elevation_deg", ViewpointsConfig().elevation_deg.to_plain()))
        return -high, -low
    return _ends(views.get("pitch_deg") or MOUNTINGS[kind].pitch_deg.to_plain())


def _ends(plain: Any) -> Degrees:
    """Return least and largest value of a distribution as a manifest holds it."""
    if not isinstance(plain, dict):
        return float(plain), float(plain)
    values = plain.get("choices") or [plain["min"], plain["max"]]
    return float(min(values)), float(max(values))
