"""Views of a truck that comes to take something: from before the faces of pallets that it can take."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from warehouse_sim.scene.viewpoints.config import ViewpointsConfig
from warehouse_sim.scene.viewpoints.framing import shows
from warehouse_sim.scene.viewpoints.free_space import FreeSpace
from warehouse_sim.scene.viewpoints.single import candidate_viewpoints
from warehouse_sim.schema import SceneSpec, Viewpoint


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
