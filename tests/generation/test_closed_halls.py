"""Whatever a camera looks at has a surface: exact rays through the doors of docks, and pixels.

What every shipped recipe's cameras look at: ``test_drafts.py``.
"""

import numpy as np
import pytest
from jaxtyping import Float

from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.render import Renderer
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.scene import SceneRecipe, sample_scene
from warehouse_sim.scene.building.hall import HallConfig
from warehouse_sim.scene.layouts.dock_staging import DockStagingConfig
from warehouse_sim.schema import SceneSpec


def lost(caster: RayCaster, origins: Float[np.ndarray, "n 3"], targets: Float[np.ndarray, "n 3"]) -> int:
    """Return how many rays hit nothing."""
    return int(np.count_nonzero(~np.isfinite(caster.cast(origins, targets - origins).distance)))


def docks(open_fraction: float, index: int) -> SceneSpec:
    """Return a hall with three docks."""
    layout = DockStagingConfig(doors=3, open_fraction=open_fraction, lane_depth=1, aisle_width=8.0)
    return sample_scene(SceneRecipe(layout=layout, hall=HallConfig(roof=True)), seed=5, scene_index=index)


def eyes(scene: SceneSpec, count: int, rng: np.random.Generator) -> Float[np.ndarray, "n 3"]:
    """Return points in the aisle, up to 3.2 m high."""
    x_min, x_max, y_min, y_max = scene.aisle
    return rng.uniform((x_min, y_min, 0.2), (x_max, y_max, 3.2), (count, 3))


@pytest.mark.parametrize("fraction", [0.0, 1.0])
def test_nothing_is_to_be_seen_past_a_dock_door_open_or_shut(fraction: float) -> None:
    for index in range(2):
        scene = docks(fraction, index)
        rng = np.random.default_rng(index)
        caster = RayCaster(scene)
        walls = [item.T_world_object[:3, 3] for item in scene.instances if item.model == "wall_module_dock"]
        for x, y, _ in walls:
            # Past the edges of the opening, where gaps would be: rays aimed at its frame, its seal and its sill.
            targets = rng.uniform((x - 1.75, y - 0.2, 0.0), (x + 1.75, y + 0.5, 3.4), (60_000, 3))
            assert lost(caster, eyes(scene, len(targets), rng), targets) == 0
            near = rng.uniform((x - 1.3, y - 1.5, 0.1), (x + 1.3, y - 0.4, 2.8), (60_000, 3))
            assert lost(caster, near, targets) == 0


@pytest.mark.gl
def test_no_pixel_of_an_open_dock_lacks_depth_or_an_instance(renderer: Renderer) -> None:
    scene, camera = docks(1.0, 0), load_recipe("dock_staging").sensors.make_camera()
    for view in scene.viewpoints:
        renderer.load(scene.seen_from(view))
        buffers = renderer.render(camera, view.T_world_camera)
        assert np.all(buffers.depth > 0.0)
        assert np.all(buffers.instance_mask > 0)
