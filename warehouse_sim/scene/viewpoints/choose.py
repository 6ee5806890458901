"""The viewpoints of a scene, each with its targets well in view, chosen before or after it has settled."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from warehouse_sim.errors import PlacementError
from warehouse_sim.scene.viewpoints.config import ViewpointsConfig
from warehouse_sim.scene.viewpoints.drives import Drive
from warehouse_sim.scene.viewpoints.framing import shows
from warehouse_sim.scene.viewpoints.free_space import FreeSpace
from warehouse_sim.scene.viewpoints.mountings import Mounting
from warehouse_sim.scene.viewpoints.plans import Planner
from warehouse_sim.scene.viewpoints.single import TRIES, candidate_viewpoints
from warehouse_sim.schema import ObjectInstance, SceneSpec, Viewpoint

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


def replace_blocked_views(scene: SceneSpec, config: ViewpointsConfig, rng: np.random.Generator) -> SceneSpec:
    """Return the scene with another view of the same target, or else of another one, for each that was lost.

    Args:
        scene: The scene at rest.
        config: What its viewpoints were chosen by, with no setting left open.
        rng: Where new views come from.

    Raises:
        PlacementError: A drive is blocked, or no other view is found.
    """
    space = FreeSpace.of_scene(scene)
    lost = blocked_views(scene, config, space)
    if not lost:
        return scene
    views = list(scene.viewpoints)
    for number in lost:
        if views[number].sequence is not None:
            raise PlacementError(f"something fell before the drive of viewpoint {number}")
        shuffled, before = space.shuffled_targets(config.aisle_fraction, rng), views[number].target
        same = [item for item in shuffled if item.instance_id == before]
        others = [item for item in shuffled if item.instance_id != before]
        found = _first_shown([*same, *others], space, config, rng)
        if found is None:
            raise PlacementError("something fell before a view, and no other one is found")
        views[number] = found
    return replace(scene, viewpoints=tuple(views))


def blocked_views(scene: SceneSpec, config: ViewpointsConfig, space: FreeSpace) -> list[int]:
    """Return the numbers of the viewpoints that have lost their room or the sight of their target."""
    target_of = {item.instance_id: item for item in space.targets}
    lift = None if config.mounting is not None and config.mounting.lifts else 0.0
    lost = []
    for number, view in enumerate(scene.viewpoints):
        target = target_of.get(view.target) if view.target is not None else None
        stands = space.is_clear(view, config.clearance, lift)
        if not stands or (target is not None and not shows(view, target, space, config)):
            lost.append(number)
    return lost


def _first_shown(
    targets: Iterable[ObjectInstance], space: FreeSpace, config: ViewpointsConfig, rng: np.random.Generator
) -> Viewpoint | None:
    """Return a view of the first of ``targets`` that has one; all tries of one come before the next.

    So the hard ones, down on the floor, are seen as often as the easy ones.
    """
    views = ((view, item) for item in targets for view in candidate_viewpoints(item, space, config, rng))
    return next((view for view, target in views if shows(view, target, space, config)), None)


def choose_viewpoints(
    space: FreeSpace, count: int, config: ViewpointsConfig, rng: np.random.Generator
) -> tuple[Viewpoint, ...]:
    """Return ``count`` viewpoints in the aisle, each with as many targets well in view as requested.

    Raises:
        PlacementError: No target can be seen from a free place.
    """
    if config.trajectory != "none" and config.mounting is not None:
        return choose_drives(space, count, config, config.mounting, rng)
    return tuple(_choose_single(space, config, rng) for _ in range(count))


def _choose_single(space: FreeSpace, config: ViewpointsConfig, rng: np.random.Generator) -> Viewpoint:
    found = _first_shown(space.shuffled_targets(config.aisle_fraction, rng), space, config, rng)
    if found is None:
        raise PlacementError(
            f"no viewpoint found in {TRIES} tries for each of {len(space.targets)} targets; "
            "widen layout.aisle_width, viewpoints.distance or viewpoints.height"
        )
    return found


def view_dockable(
    scene: SceneSpec, headings: Mapping[int, Sequence[float]], config: ViewpointsConfig, rng: np.random.Generator
) -> SceneSpec:
    """Return the scene with ``dockable_fraction`` of its views replaced.

    Args:
        scene: The scene at rest.
        headings: Instance id of a pallet -> headings (rad, world) straight into the faces that a truck takes it by.
        config: Kind of camera, distances, what counts as in view, with no setting left open.
        rng: Which views are replaced, and by which ones.

    A view stays as it is where no such pallet is well in view from the aisle.
    """
    space, views = FreeSpace.of_scene(scene), list(scene.viewpoints)
    count = int(config.dockable_fraction * len(views) + rng.random())
    for number in rng.permutation(len(views))[:count]:
        found = _first_before(space, headings, config, rng)
        if found is not None:
            views[number] = found
    return replace(scene, viewpoints=tuple(views))


def _first_before(
    space: FreeSpace, headings: Mapping[int, Sequence[float]], config: ViewpointsConfig, rng: np.random.Generator
) -> Viewpoint | None:
    """Return a view of the first pallet, in random order, that has one from before one of its faces."""
    takes = [(item, into) for item in space.targets for into in headings.get(item.instance_id, ())]
    for row in rng.permutation(len(takes)):
        target, into = takes[row]
        for view in candidate_viewpoints(target, space, config, rng, into=into):
            if shows(view, target, space, config):
                return view
    return None
