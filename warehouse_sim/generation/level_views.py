"""Which formats hold a level camera's images instead of a tilted one's, and how far from the horizon those reach."""

import itertools
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from warehouse_sim.dataset.formats import dataset_format, needs_level_camera
from warehouse_sim.dataset.stored.contents import Contents
from warehouse_sim.dataset.stored.recipe_contents import draft_contents
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.level_view import reach
from warehouse_sim.scene.viewpoints.mountings import MOUNTINGS

Degrees = tuple[float, float]


def planned_contents(recipe: dict[str, Any], camera: PinholeCamera, formats: Sequence[str], backend: str) -> Contents:
    """Return what a dataset of a recipe will hold.

    Args:
        recipe: The resolved recipe as plain data, whose settings may be distributions and choices.
        camera: The rig's camera.
        formats: Names of the formats.
        backend: Name of the render backend.
    """
    contents = draft_contents(recipe, (*formats, backend))
    if not contents.tilted_viewpoints:
        return contents
    views = recipe["scene"]["viewpoints"]
    rolls = _ends(views["roll_deg"])
    turns = {turn for kind in contents.tilted_viewpoints for turn in itertools.product(_pitches(kind, views), rolls)}
    farthest = max(reach(camera, *np.deg2rad(turn)) for turn in turns)
    levelled = tuple(name for name in formats if needs_level_camera(dataset_format(name)))
    return replace(contents, levelled=levelled, view_angle_deg=float(np.rad2deg(farthest)))


def _pitches(kind: str, views: dict[str, Any]) -> Degrees:
    """Return least and largest pitch of a kind (deg): the recipe's, or else its own."""
    if kind == "free":
        low, high = _ends(views["elevation_deg"])
        return -high, -low
    return _ends(views["pitch_deg"] or MOUNTINGS[kind].pitch_deg.to_plain())


def _ends(plain: Any) -> Degrees:
    """Return least and largest value of a distribution as a manifest holds it."""
    if not isinstance(plain, dict):
        return float(plain), float(plain)
    values = plain.get("choices") or [plain["min"], plain["max"]]
    return float(min(values)), float(max(values))
