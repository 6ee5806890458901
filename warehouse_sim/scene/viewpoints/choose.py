"""The viewpoints of a scene, each with its targets well in view, chosen before or after it has settled."""

from dataclasses import replace

import numpy as np

from warehouse_sim.errors import PlacementError
from warehouse_sim.scene.draft import Area, SceneDraft
from warehouse_sim.scene.viewpoints.config import ViewpointsConfig
from warehouse_sim.scene.viewpoints.framing import shows
from warehouse_sim.scene.viewpoints.free_space import FreeSpace
from warehouse_sim.scene.viewpoints.sequences import choose_drives
from warehouse_sim.scene.viewpoints.single import TRIES, candidate_viewpoints
from warehouse_sim.schema import SceneSpec, Viewpoint


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
        views[number] = _another_view(views[number], space, config, rng)
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


def _another_view(view: Viewpoint, space: FreeSpace, config: ViewpointsConfig, rng: np.random.Generator) -> Viewpoint:
    for target in sorted(
        space.shuffled_targets(config.aisle_fraction, rng), key=lambda item: item.instance_id != view.target
    ):
        for candidate in candidate_viewpoints(target, space, config, rng):
            if shows(candidate, target, space, config):
                return candidate
    raise PlacementError("something fell before a view, and no other one is found")


def choose_viewpoints(
    draft: SceneDraft,
    targets: tuple[str, ...],
    count: int,
    config: ViewpointsConfig,
    area: Area,
    rng: np.random.Generator,
) -> tuple[Viewpoint, ...]:
    """Return ``count`` viewpoints in the aisle ``area``, each with as many targets well in view as requested.

    Raises:
        PlacementError: There is no target, or none can be seen from a free place.
    """
    return _choose(FreeSpace.of(draft.instances, draft.models, targets, area), count, config, rng)


def views_of(scene: SceneSpec, count: int, config: ViewpointsConfig, rng: np.random.Generator) -> tuple[Viewpoint, ...]:
    """Return ``count`` viewpoints in the aisle of a scene as it stands, each with its targets well in view.

    Raises:
        PlacementError: There is no target, none can be seen from a free place, or the aisle is not known.
    """
    return _choose(FreeSpace.of_scene(scene), count, config, rng)


def _choose(space: FreeSpace, count: int, config: ViewpointsConfig, rng: np.random.Generator) -> tuple[Viewpoint, ...]:
    if config.trajectory != "none" and config.mounting is not None:
        return choose_drives(space, count, config, config.mounting, rng)
    return tuple(_choose_single(space, config, rng) for _ in range(count))


def _choose_single(space: FreeSpace, config: ViewpointsConfig, rng: np.random.Generator) -> Viewpoint:
    # All tries of a target before the next one: the hard ones, down on the floor, are seen as often as the easy ones.
    for target in space.shuffled_targets(config.aisle_fraction, rng):
        for viewpoint in candidate_viewpoints(target, space, config, rng):
            if shows(viewpoint, target, space, config):
                return viewpoint
    raise PlacementError(
        f"no viewpoint found in {TRIES} tries for each of {len(space.targets)} targets; "
        "widen layout.aisle_width, viewpoints.distance or viewpoints.height"
    )
