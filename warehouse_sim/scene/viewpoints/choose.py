"""The viewpoints of a scene: as many as its recipe asks for, each with its targets well in view."""

import numpy as np

from warehouse_sim.errors import PlacementError
from warehouse_sim.scene.draft import Area, SceneDraft
from warehouse_sim.scene.viewpoints.config import ViewpointsConfig
from warehouse_sim.scene.viewpoints.framing import shows
from warehouse_sim.scene.viewpoints.free_space import FreeSpace
from warehouse_sim.scene.viewpoints.sequences import choose_drives
from warehouse_sim.scene.viewpoints.single import TRIES, candidate_viewpoints
from warehouse_sim.schema import SceneSpec, Viewpoint


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
