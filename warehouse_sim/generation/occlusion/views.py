"""Views of targets that a request can choose from."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from warehouse_sim.generation.occlusion.occluded_scene import OccludedScene
from warehouse_sim.generation.occlusion.sight import Sight
from warehouse_sim.scene.viewpoints.config import ViewpointsConfig
from warehouse_sim.scene.viewpoints.framing import targets_in_frame
from warehouse_sim.scene.viewpoints.single import candidate_viewpoints
from warehouse_sim.schema import Viewpoint

_TRIES = 6
"""Places drawn for a view of one target before the next."""
_WITHIN_REACH = 1.2
"""Targets whose middle is below this height (m) are hidden by most occluders."""
_IN_A_ROW = 40
"""Targets without a view after which there are no more views."""


@dataclass(frozen=True, eq=False)
class View:
    """A view of a target and what can be seen of it now."""

    viewpoint: Viewpoint
    sight: Sight

    @property
    def target(self) -> int:
        """Instance id."""
        return self.sight.target


def views_of(
    occluded: OccludedScene, own: Viewpoint, config: ViewpointsConfig, rays: int, rng: np.random.Generator
) -> Iterator[View | None]:
    """Yield views, None for each in vain: the scene's ``own`` view first, then others, target by target at random.

    A view that belongs to a drive cannot be exchanged: then the targets that it shows come again and again.
    """
    space = occluded.space()
    shown = [item.instance_id for item in targets_in_frame(own.T_world_camera, space, config)]
    shown.sort(key=lambda number: number != own.target)
    while own.sequence is not None and shown:
        yield from (_view(occluded, replace(own, target=number), rays) for number in shown)
    for number in shown[:1] if space.has_room(own, config.clearance) else ():
        yield _view(occluded, replace(own, target=number), rays)
    low = [item for item in space.targets if item.T_world_object[2, 3] < _WITHIN_REACH]
    misses = 0
    while own.sequence is None and misses < _IN_A_ROW:
        # Half of the views go to the targets that things on the floor can hide, rare as they may be.
        choice = low if low and rng.random() < 0.5 else space.targets
        target = choice[int(rng.integers(len(choice)))]
        viewpoint = next(candidate_viewpoints(target, space, config, rng, _TRIES), None)
        misses = 0 if viewpoint is not None else misses + 1
        if viewpoint is not None:
            yield _view(occluded, replace(viewpoint, target=target.instance_id), rays)


def _view(occluded: OccludedScene, viewpoint: Viewpoint, rays: int) -> View | None:
    assert viewpoint.target is not None
    sight = occluded.look(viewpoint.target, viewpoint.T_world_camera, rays)
    return None if sight is None else View(viewpoint, sight)
