"""Scenes by hand: drafted empty or from a recipe, changed, settled with all changes, seen from anywhere."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

from warehouse_sim.catalog import catalog_object
from warehouse_sim.errors import PlacementError, SettleError
from warehouse_sim.generation.light import light_scene
from warehouse_sim.generation.observe import observe_scene
from warehouse_sim.generation.occlusion import request_views
from warehouse_sim.generation.plan import target_models
from warehouse_sim.generation.recipe import Recipe
from warehouse_sim.generation.recipe.paired_variants import base_variant
from warehouse_sim.generation.scene import ATTEMPTS
from warehouse_sim.physics import SettleReport, settle_scene
from warehouse_sim.physics.settle import SettleConfig
from warehouse_sim.render import open_renderer
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.scene import SceneRecipe, sample_scene, scene_rng
from warehouse_sim.scene.hand_made import LIGHTS, VIEWPOINTS, Change, cleared, empty_scene, nudged
from warehouse_sim.scene.lighting.config import LightingConfig
from warehouse_sim.scene.viewpoints.choose import choose_viewpoints
from warehouse_sim.scene.viewpoints.config import ViewpointsConfig
from warehouse_sim.scene.viewpoints.free_space import FreeSpace
from warehouse_sim.schema import ObjectModel, Observation, SceneSpec, Viewpoint
from warehouse_sim.sensors.rig import RigConfig

SETTLE = SettleConfig(max_time=20.0, max_drift_mm=10_000.0, max_tilt_deg=180.0)
"""What was placed by hand may fall and topple, but comes to rest, and neither overlaps nor floats."""
_REACH = (1.0, 1.0, 4.0)
"""How far things that were placed by hand may slide and fall (m)."""


@dataclass(frozen=True, eq=False)
class HandMade:
    """A scene by hand, settled or not."""

    scene: SceneSpec
    """Without viewpoints; its light is the draft's."""
    settings: SceneRecipe | None
    """What it was sampled from, one value for each random setting; None for a scene that began empty."""
    report: SettleReport | None = None
    """How it came to rest; None where it has not settled."""

    @property
    def lights(self) -> LightingConfig:
        """The light that nobody changed."""
        return LIGHTS if self.settings is None else self.settings.lights

    @property
    def viewpoints(self) -> ViewpointsConfig:
        """Where cameras may stand."""
        return VIEWPOINTS if self.settings is None else self.settings.viewpoints


def draft(recipe: Recipe | None, seed: int) -> HandMade:
    """Return scene 0 of a recipe with this seed before it settles; an empty hall without a recipe.

    Raises:
        PlacementError: What the recipe requires fits in no attempt.
    """
    if recipe is None:
        return HandMade(empty_scene(seed), None)
    problem: Exception | None = None
    for attempt in range(ATTEMPTS):
        try:
            return _sampled(recipe, seed, attempt)
        except PlacementError as error:
            problem = error
    raise PlacementError(f"{problem}; loosen the recipe") from problem


def changed(made: HandMade, changes: Sequence[Change]) -> HandMade:
    """Return the scene after some changes, not settled."""
    scene = made.scene
    for change in changes:
        scene = change(scene)
    return replace(made, scene=scene)


def settle(
    recipe: Recipe | None, seed: int, changes: Sequence[Change], first: HandMade, settle_seed: int = 0
) -> HandMade:
    """Return the scene at rest; a recipe's scene that does not stand is sampled and changed again.

    Args:
        recipe: As in ``draft``.
        seed: As in ``draft``.
        changes: What was changed since, in order.
        first: The draft with these changes.
        settle_seed: 0 settles objects from where they were put; any other shifts each load by some millimetres first.

    Raises:
        SettleError: It does not come to rest, or objects overlap.
    """
    problem: Exception | None = None
    for attempt in range(1 if recipe is None else ATTEMPTS):
        try:
            found = first if attempt == first.scene.attempt else changed(_sampled(recipe, seed, attempt), changes)
            return _at_rest(found, recipe, bool(changes), settle_seed)
        except (PlacementError, SettleError) as error:
            problem = error
    raise SettleError(f"{problem}; move objects apart, or put them where something carries them") from problem


def sampled_views(made: HandMade, count: int) -> tuple[Viewpoint, ...]:
    """Return viewpoints around the targets of a scene.

    Raises:
        PlacementError: There is no target, or none can be seen from a free place.
    """
    scene = made.scene
    rng = scene_rng(scene.seed, scene.scene_index, "viewpoints by hand", scene.attempt)
    return choose_viewpoints(FreeSpace.of_scene(scene), count, made.viewpoints, rng)


@dataclass(frozen=True, eq=False)
class Take:
    """One observation of a scene by hand, with all that a dataset stores of it."""

    observation: Observation
    scene: SceneSpec
    """As it was lit, with the views of all observations that were taken with it."""
    rig: RigConfig
    """What observed it."""
    renderer: str
    """Description of what rendered it."""
    backend: str
    """Name of that."""
    made: HandMade
    """The scene without light."""
    recipe: Recipe | None = None
    """What the scene was sampled from before it was changed."""


def labelled_models(take: Take) -> list[ObjectModel]:
    """Return each geometry that labels of a scene can name, undamaged and once; the recipe's names come first."""
    found = {} if take.recipe is None else {model.obj_id: model for model in target_models(take.recipe)}
    for item in take.scene.target_instances():
        model = take.scene.model_of(item)
        if model.obj_id not in found:
            base = model.name.partition("~")[0]
            found[model.obj_id] = catalog_object(base) if base != model.name else model
    return list(found.values())


def observe(
    made: HandMade,
    views: Sequence[Viewpoint],
    lights: LightingConfig,
    rig: RigConfig,
    recipe: Recipe | None = None,
    backend: str = "raster",
    is_requested: bool = False,
) -> list[Take]:
    """Return what a rig observes in a scene, one observation for each view.

    Args:
        made: The scene.
        views: From where.
        lights: In which light, no number of it left open.
        rig: The sensors.
        recipe: What the scene was sampled from.
        backend: What renders.
        is_requested: Whether views and occluders are chosen by the visible fractions that the recipe requires.

    Raises:
        RenderError: No renderer can be opened.
    """
    seen = replace(made.scene, viewpoints=tuple(views))
    stream = partial(scene_rng, seen.seed, seen.scene_index, attempt=seen.attempt)
    camera, caster = rig.make_camera(), RayCaster(seen)
    if is_requested and recipe is not None and recipe.occlusion is not None and made.settings is not None:
        seen, _ = request_views(seen, made.settings, camera, recipe.occlusion, caster, stream("occlusion"))
        caster = RayCaster(seen)
    lit = light_scene(seen, lights, caster, camera, stream("lighting"))
    variant = base_variant(lit, rig.sample_sensor(stream("sensor")))
    with open_renderer(backend) as renderer:
        return [
            Take(observation, lit, rig, renderer.description, backend, made, recipe)
            for observation in observe_scene(lit, rig, renderer, (variant,), caster=caster)
        ]


def _sampled(recipe: Recipe | None, seed: int, attempt: int) -> HandMade:
    assert recipe is not None
    settings = recipe.scene.sampled(partial(scene_rng, seed, 0, attempt=attempt))
    # One view is sampled and left out: a recipe without any target to look at is rejected here.
    spec = sample_scene(replace(settings, observations_per_scene=1), seed, 0, attempt)
    return HandMade(replace(spec, viewpoints=()), settings)


def _at_rest(made: HandMade, recipe: Recipe | None, is_changed: bool, settle_seed: int) -> HandMade:
    spec = made.scene
    if settle_seed:
        spec = nudged(spec, scene_rng(spec.seed, spec.scene_index, f"settle {settle_seed}", spec.attempt))
    if recipe is not None and not is_changed:
        settled, report = settle_scene(spec, recipe.settle)
    else:
        config = SETTLE if recipe is None else replace(SETTLE, impulses=recipe.settle.impulses)
        settled, report = settle_scene(cleared(spec), config, _REACH)
    report.require_ok()
    return HandMade(settled, made.settings, report)
