"""One draw of a recipe."""

import numpy as np

from warehouse_sim.catalog.materials import materials_of
from warehouse_sim.errors import PlacementError
from warehouse_sim.scene.appearance.hall_colors import in_hall_colors
from warehouse_sim.scene.appearance.painting import paint_scene
from warehouse_sim.scene.building.hall import equip_hall
from warehouse_sim.scene.clutter import add_clutter, clutter_shelves
from warehouse_sim.scene.draft import SceneDraft
from warehouse_sim.scene.layouts.site import build_site
from warehouse_sim.scene.lighting.luminaires import add_luminaires
from warehouse_sim.scene.lighting.switching import light_without_shadows
from warehouse_sim.scene.loads.backdrop import fill_backdrop
from warehouse_sim.scene.loads.bare_goods import stock_strips
from warehouse_sim.scene.loads.carton_details import batter_cartons, open_flaps, print_cartons
from warehouse_sim.scene.loads.lanes import fill_lanes
from warehouse_sim.scene.loads.shelving import fill_rack, hang_film
from warehouse_sim.scene.loads.staging import stage_loads
from warehouse_sim.scene.recipe import SceneRecipe
from warehouse_sim.scene.streams import scene_rng
from warehouse_sim.scene.traffic import add_side_trucks, add_traffic, add_trucks
from warehouse_sim.scene.viewpoints.choose import choose_viewpoints
from warehouse_sim.scene.viewpoints.free_space import FreeSpace
from warehouse_sim.schema import SceneSpec


def sample_scene(recipe: SceneRecipe, seed: int, scene_index: int, attempt: int = 0) -> SceneSpec:
    """Draw scene ``scene_index`` of the dataset with this seed; physics has yet to settle it.

    Args:
        recipe: Distribution to draw from.
        seed: Seed of the dataset, >= 0.
        scene_index: Number of the scene, >= 0; any scene can be sampled alone.
        attempt: Number of the try, >= 0; another try is another scene.

    Raises:
        RecipeError: A number is negative.
        ConfigError: The values drawn for random settings do not go together.
        PlacementError: What the recipe requires does not fit; the message names the scene.
    """

    def stream(stage: str) -> np.random.Generator:
        return scene_rng(seed, scene_index, stage, attempt)

    draft, recipe = SceneDraft(), recipe.sampled(stream)
    try:
        site = build_site(draft, recipe.layout, recipe.hall, stream("layout"))
        area = site.aisle
        add_luminaires(draft, recipe.lights, site, recipe.hall.clear_height)
        equip_hall(draft, recipe.hall, site.aisle, site.hall, stream("services"), site.places_of_loads())
        fill_rack(draft, site.slots, recipe.shelving, recipe.loads, stream("shelving"))
        fill_backdrop(
            draft, site.backdrop, recipe.shelving, recipe.loads, "carton" in recipe.targets, stream("backdrop")
        )
        fill_lanes(draft, site.lanes, recipe.lanes, recipe.loads, stream("lanes"))
        stock_strips(draft, site.strips, recipe.loads, stream("bare goods"))
        stage_loads(draft, recipe.staging, recipe.loads, area, stream("staging"))
        add_trucks(draft, recipe.traffic, recipe.loads, area, stream("trucks"))
        add_side_trucks(draft, recipe.traffic, recipe.loads, site.side_aisles, stream("side trucks"))
        add_traffic(draft, recipe.traffic, recipe.loads.cartons, area, stream("traffic"))
        add_clutter(draft, recipe.clutter, area, stream("clutter"))
        clutter_shelves(draft, recipe.clutter, site.strips, stream("shelf clutter"))
        batter_cartons(draft, recipe.carton_wear, stream("carton wear"))
        open_flaps(draft, recipe.carton_wear.open_fraction, stream("open flaps"))
        film = stream("hanging film")
        hang_film(draft, recipe.shelving.hanging_film.sample_count(film), area, film)
        space = FreeSpace.of(draft.instances, draft.models, recipe.targets, area)
        viewpoints = choose_viewpoints(space, recipe.observations_per_scene, recipe.viewpoints, stream("viewpoints"))
    except PlacementError as problem:
        raise PlacementError(f"scene {scene_index} of seed {seed}, attempt {attempt}: {problem}") from problem
    scene = SceneSpec(
        scene_index=scene_index,
        seed=seed,
        models=draft.models,
        materials=materials_of(draft.models.values()),
        instances=tuple(draft.instances),
        lights=(),
        viewpoints=viewpoints,
        targets=recipe.targets,
        attempt=attempt,
        aisle=(area.x_min, area.x_max, area.y_min, area.y_max),
    )
    scene = paint_scene(scene, recipe.appearance, stream)
    if recipe.loads.prints == "sampled":
        scene = print_cartons(scene, stream("prints"))
    if recipe.appearance.preset == "everyday":
        scene = in_hall_colors(scene, stream("hall colours"))
    return light_without_shadows(scene, recipe.lights, stream("lighting"))
