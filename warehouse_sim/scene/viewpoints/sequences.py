"""Frames of drives: which moments become viewpoints, and whether each shows what was requested."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from warehouse_sim.errors import PlacementError
from warehouse_sim.scene.viewpoints.config import ViewpointsConfig
from warehouse_sim.scene.viewpoints.drives import Drive
from warehouse_sim.scene.viewpoints.free_space import FreeSpace
from warehouse_sim.scene.viewpoints.mountings import Mounting
from warehouse_sim.scene.viewpoints.plans import Planner
from warehouse_sim.schema import Viewpoint

_TRIES = 40
"""Drives drawn for a target before it is given up."""
_BEYOND = 4.0
"""How far beyond the ends of the aisle a drive may reach (m)."""


def choose_drives(
    space: FreeSpace, count: int, config: ViewpointsConfig, mounting: Mounting, rng: np.random.Generator
) -> tuple[Viewpoint, ...]:
    """Return ``count`` viewpoints on drives, as sequences or each from a drive of its own.

    Raises:
        PlacementError: No drive is found that has room and its targets in view.
    """
    area = replace(space.area, x_min=space.area.x_min - _BEYOND, x_max=space.area.x_max + _BEYOND)
    planner, is_sequence = Planner(replace(space, area=area), config, mounting, rng), config.drive.sequence
    drives = min(config.drive.drives, count) if is_sequence else count
    chosen: list[Viewpoint] = []
    for number in range(drives):
        frames = _choose_frames(planner, count // drives + (number < count % drives))
        # A view on its own has no time: its drive is not part of the scene.
        chosen += [replace(view, sequence=number) if is_sequence else replace(view, time=0.0) for view in frames]
    return tuple(chosen)


def _choose_frames(planner: Planner, count: int) -> list[Viewpoint]:
    """Return ``count`` frames of one drive."""
    config, space = planner.config, planner.space
    aims = [None] if config.trajectory == "drive" else space.shuffled_targets(config.aisle_fraction, planner.rng)
    for aim in aims:
        for _ in range(_TRIES):
            drive = planner.sample(aim)
            if drive is None:
                continue
            frames = _frames(drive, _moments(drive, count, planner), planner)
            if frames is not None:
                return frames
    raise PlacementError(
        f"no {config.trajectory} of kind {config.kind} found in {_TRIES} tries for each of {len(aims)} targets; "
        "widen layout.aisle_width, viewpoints.max_elevation_deg or viewpoints.drive"
    )


def _moments(drive: Drive, count: int, planner: Planner) -> Sequence[float]:
    """Return times (s): evenly from start to end, or random for views on their own."""
    if planner.config.drive.sequence and count > 1:
        return [float(time) for time in np.linspace(0.0, drive.duration, count)]
    return [float(planner.rng.uniform(0.0, drive.duration)) for _ in range(count)]


def _frames(drive: Drive, times: Sequence[float], planner: Planner) -> list[Viewpoint] | None:
    """Return the views at ``times``, each with the target that it shows; None if one of them shows none."""
    views = []
    for time in times:
        view = drive.at(time)
        found = planner.is_shown(view, drive.target)
        if found is None or not planner.space.admits_camera(view.T_world_camera[:3, 3], planner.config.clearance):
            return None
        views.append(replace(view, target=found.instance_id))
    return views
