"""Scenes by hand: an empty lit hall, and objects that are added to a scene and cleared of others before it settles."""

import logging
from collections import defaultdict
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from warehouse_sim.catalog import catalog_object, shipped_classes
from warehouse_sim.catalog.materials import materials_of
from warehouse_sim.errors import PlacementError
from warehouse_sim.geometry.pose import Transform, invert, make_transform, rotation_z
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.scene.building.hall import HallConfig, build_hall
from warehouse_sim.scene.distribution import Distribution
from warehouse_sim.scene.draft import Area, SceneDraft
from warehouse_sim.scene.layouts.site import Site
from warehouse_sim.scene.lighting.config import LightingConfig
from warehouse_sim.scene.lighting.luminaires import add_luminaires
from warehouse_sim.scene.lighting.switching import light_without_shadows
from warehouse_sim.scene.solids import Solids
from warehouse_sim.scene.streams import scene_rng
from warehouse_sim.scene.viewpoints.config import ViewpointsConfig
from warehouse_sim.schema import ObjectInstance, ObjectModel, SceneSpec

LOOSE = frozenset((
    "pallet", "carton", "tote", "drum", "sack", "ibc", "octabin", "big_bag", "gitterbox", "roll_container",
    "long_goods", "clutter", "cone", "bin", "slip_sheet", "corner_post",
))  # fmt: skip
"""Classes of the catalog that physics moves by default; all else of it stands fixed."""
HALL = HallConfig(floor="jointed", walls="cladding", roof=True, length=24.0, width=16.0, height=7.0)
"""Around the origin, x along it."""
LIGHTS = LightingConfig(rows=2, luminaires=4, mounting_height=None)
VIEWPOINTS = ViewpointsConfig(
    kind="free", distance=Distribution.uniform(1.5, 4.5), elevation_deg=Distribution.uniform(5.0, 45.0)
)
"""Where cameras stand when they are to look at what was added."""
_MARGIN = 0.5
"""From the walls to the floor that cameras stay over and light is measured on (m)."""
_AIR = 0.0005
"""Gap under what is put on the floor (m); physics closes it."""
_NUDGE, _NUDGE_TURN = 0.002, np.deg2rad(0.3)
"""Standard deviations of how far loads are shifted along each axis (m) and turned (rad); practical priors."""
_LARGER = 0.002
"""By how much (m) an object may be larger than the one whose place it takes."""


def empty_scene(seed: int) -> SceneSpec:
    """Return an empty hall with a floor, walls, a roof and luminaires, lit; its middle is the origin.

    Args:
        seed: Decides all that is random in the scene.
    """
    draft = SceneDraft()
    assert HALL.width is not None
    floor = build_hall(draft, HALL, HALL.width / 2, -HALL.width / 2, ())
    area = Area(*(edge + (_MARGIN if edge < 0 else -_MARGIN) for edge in _edges(floor)))
    add_luminaires(draft, LIGHTS, Site(aisle=area, hall=floor), HALL.clear_height)
    scene = SceneSpec(
        scene_index=0,
        seed=seed,
        models=draft.models,
        materials=materials_of(draft.models.values()),
        instances=tuple(draft.instances),
        lights=(),
        viewpoints=(),
        targets=(),
        aisle=_edges(area),
    )
    return light_without_shadows(scene, LIGHTS, scene_rng(seed, 0, "lighting"))


def is_loose(model: ObjectModel) -> bool:
    """Return whether physics moves an object by default: what people and trucks set down."""
    own = model.class_name not in shipped_classes()
    return model.mass > 0.0 and bool(model.collision) and (own or model.class_name in LOOSE)


def with_object(
    scene: SceneSpec, name: str, x: float, y: float, z: float | None, yaw: float, loose: bool | None = None
) -> SceneSpec:
    """Return the scene with one more object; its class is a target if it is loose or new to the scene.

    Args:
        scene: Not settled yet.
        name: Of the catalog, or the file of a user's own object.
        x: Of its origin in the world (m).
        y: Of its origin in the world (m).
        z: Of its origin in the world (m); None stands it on the loose object under it, or else on the floor.
        yaw: About the upward axis (rad).
        loose: Whether physics may move it; None leaves it to what it is.

    Raises:
        PlacementError: It would move, but has no mass or no solid body, or nothing is under it.
    """
    model = catalog_object(name)
    moves = is_loose(model) if loose is None else loose
    if moves and not (model.mass > 0.0 and model.collision):
        raise PlacementError(f"{name}: has no mass or no solid body, so that physics cannot move it; leave it fixed")
    if moves and not any(_is_over(scene, item, x, y) for item in scene.instances):
        raise PlacementError(f"{name}: nothing is under x = {x:g} m, y = {y:g} m; {_reach(scene)}")
    top, below = support(scene, x, y) if z is None else (0.0, 0)
    height = top + float(model.size[2]) / 2 + (_AIR if moves else 0.0) if z is None else z
    number = max((item.instance_id for item in scene.instances), default=0) + 1
    group = (below or max((item.group for item in scene.instances), default=0) + 1) if moves else 0
    placed = ObjectInstance(
        number, model.name, make_transform(rotation_z(yaw), np.array([x, y, height])), dynamic=moves, group=group
    )
    is_new = all(scene.model_of(item).class_name != model.class_name for item in scene.instances)
    targets = _joined(scene.targets, model.class_name) if moves or is_new else scene.targets
    return replace(_knowing(scene, model), instances=(*scene.instances, placed), targets=targets)


def support(scene: SceneSpec, x: float, y: float) -> tuple[float, int]:
    """Return height (m) and group of the highest loose object over a point of the floor; 0 and 0 without one."""
    found = 0.0, 0
    for item in scene.instances:
        if item.dynamic and _is_over(scene, item, x, y):
            found = max(found, (float(item.T_world_object[2, 3] + scene.model_of(item).size[2] / 2), item.group))
    return found


def _is_over(scene: SceneSpec, item: ObjectInstance, x: float, y: float) -> bool:
    """Return whether a point of the floor plan is over the box of an object."""
    place = invert(item.T_world_object) @ np.array([x, y, item.T_world_object[2, 3], 1.0])
    return bool((np.abs(place[:2]) <= scene.model_of(item).size[:2] / 2).all())


def _reach(scene: SceneSpec) -> str:
    """Say how far the floor reaches, which is the largest object of any scene."""
    floor = max(scene.instances, key=lambda item: float(np.prod(scene.model_of(item).size[:2])))
    half, centre = scene.model_of(floor).size[:2] / 2, floor.T_world_object[:2, 3]
    (left, near), (right, far) = centre - half, centre + half
    return f"the floor reaches from x = {left:g} to {right:g} m and from y = {near:g} to {far:g} m"


def with_replaced(scene: SceneSpec, old: str, new: str) -> tuple[SceneSpec, int]:
    """Return the scene with another object in the place of each of one kind, and how many there were.

    What takes a place stands on the same ground, about the same middle, and is a target from now on.

    Args:
        scene: Not settled yet.
        old: Catalog name; variants of its look and wear count.
        new: Catalog name, or the file of a user's own object.

    Raises:
        PlacementError: The new object is larger than what it replaces.
    """
    before, model = catalog_object(old), catalog_object(new)
    if (model.size > before.size + _LARGER).any():
        raise PlacementError(
            f"{new}: is {_size(model)} m and does not fit the place of {old}, {_size(before)} m; "
            "replace something larger, or export the mesh in metres"
        )
    down = np.array([0.0, 0.0, float(model.size[2] - before.size[2]) / 2])

    def changed(item: ObjectInstance) -> ObjectInstance:
        T = item.T_world_object @ make_transform(translation=down)
        return replace(item, model=model.name, T_world_object=T, paint={})

    is_old = [is_kind(item, before.name) for item in scene.instances]
    if not any(is_old):
        return scene, 0
    instances = tuple(changed(item) if found else item for item, found in zip(scene.instances, is_old, strict=True))
    used = {item.model for item in instances}
    known = _knowing(scene, model)
    models = {name: kept for name, kept in known.models.items() if name in used}
    targets = _joined(scene.targets, model.class_name)
    return replace(known, models=models, instances=instances, targets=targets), sum(is_old)


def without_kind(scene: SceneSpec, name: str) -> tuple[SceneSpec, int]:
    """Return the scene without the objects of one kind, and how many there were."""
    known = catalog_object(name).name
    kept = tuple(item for item in scene.instances if not is_kind(item, known))
    used = {item.model for item in kept}
    models = {key: model for key, model in scene.models.items() if key in used}
    return replace(scene, instances=kept, models=models), len(scene.instances) - len(kept)


def nudged(scene: SceneSpec, rng: np.random.Generator) -> SceneSpec:
    """Return the scene with each load shifted and turned a little where it stands."""
    moves: dict[int, Transform] = {}
    for item in scene.instances:
        if item.group and item.group not in moves:
            shift, turn = rng.normal(0.0, _NUDGE, 2), float(rng.normal(0.0, _NUDGE_TURN))
            T = item.T_world_object
            upright = make_transform(translation=T[:3, 3])
            moved = make_transform(rotation_z(turn), T[:3, 3] + np.array([*shift, 0.0]))
            moves[item.group] = moved @ invert(upright)
    return replace(
        scene,
        instances=tuple(
            replace(item, T_world_object=moves[item.group] @ item.T_world_object) if item.group else item
            for item in scene.instances
        ),
    )


def is_kind(item: ObjectInstance, name: str) -> bool:
    """Return whether an object is of the catalog name, whatever its look and wear."""
    return item.model.partition("~")[0] == name


def _knowing(scene: SceneSpec, model: ObjectModel) -> SceneSpec:
    """Return the scene with a model and its materials among its own.

    Raises:
        PlacementError: Another object of the scene has its name.
    """
    if scene.models.get(model.name, model).obj_id != model.obj_id:
        raise PlacementError(f"two objects of the scene are called {model.name!r}; give your own another name")
    materials = {**materials_of([model]), **scene.materials}
    return replace(scene, models={**scene.models, model.name: model}, materials=materials)


def _joined(targets: tuple[str, ...], class_name: str) -> tuple[str, ...]:
    return targets if class_name in targets else (*targets, class_name)


def _edges(area: Area) -> tuple[float, float, float, float]:
    return area.x_min, area.x_max, area.y_min, area.y_max


def _size(model: ObjectModel) -> str:
    return " x ".join(f"{edge:.3g}" for edge in model.size)


Change = Callable[[SceneSpec], SceneSpec]
"""One step from a scene to the next, before it settles."""


_DEEP = 0.002
"""Boxes that overlap by less (m) are left to physics."""
_FARTHEST, _STEP = 1.0, 0.02
"""How far a load is slid at most, and in which steps (m)."""
_WAYS = 24
"""Directions that are tried."""

_log = logging.getLogger(__name__)


def cleared(scene: SceneSpec) -> SceneSpec:
    """Return the scene with each load that overlaps something else slid along the floor to where it does not.

    What is fixed stays; of two loads the one that was added later gives way. A warning says what was moved.

    Raises:
        PlacementError: A load has no free place within a metre.
    """
    loads: dict[int, list[ObjectInstance]] = defaultdict(list)
    for item in scene.instances:
        if item.dynamic:
            loads[item.group or -item.instance_id].append(item)
    solids, ways = Solids.of(scene.instances, scene.models), _ways()
    waiting = {item.instance_id for load in loads.values() for item in load}
    moved: dict[int, ObjectInstance] = {}
    for load in loads.values():
        mine = Solids.of(load, scene.models)
        waiting -= {item.instance_id for item in load}
        others = ~solids.of_objects([*waiting, *(item.instance_id for item in load)])
        low, high = solids.extent_of([item.instance_id for item in load])
        around = solids.boxes.subset(others & solids.near(low, high, _FARTHEST))
        way = next((way for way in ways if _is_clear(mine.boxes, way, around)), None)
        if way is None:
            raise PlacementError(
                f"{load[0].model} (object {load[0].instance_id}) at {_place(load[0])} m overlaps what stands there, "
                f"and has no free place within {_FARTHEST:g} m; put it elsewhere"
            )
        if way.any():
            _log.warning(
                "%s (object %d) at %s m overlapped what stands there; it was moved by %.2f m",
                load[0].model, load[0].instance_id, _place(load[0]), float(np.hypot(way[0], way[1])),
            )  # fmt: skip
            there = [_shifted(item, way) for item in load]
            solids = solids.moved(there, scene.models)
            moved |= {item.instance_id: item for item in there}
    return replace(scene, instances=tuple(moved.get(item.instance_id, item) for item in scene.instances))


def _ways() -> list[Float[np.ndarray, " 3"]]:
    """Return the ways to try, the shortest first."""
    angles = 2.0 * np.pi * np.arange(_WAYS) / _WAYS
    circle = np.stack([np.cos(angles), np.sin(angles), np.zeros(_WAYS)], axis=1)
    lengths = np.arange(_STEP, _FARTHEST + _STEP / 2, _STEP)
    return [np.zeros(3), *(length * way for length in lengths for way in circle)]


def _is_clear(boxes: BoxStack, way: Float[np.ndarray, " 3"], others: BoxStack) -> bool:
    """Return whether boxes that are slid a way overlap none of the others by more than physics closes."""
    there = BoxStack(boxes.centre + way, boxes.rotation, boxes.half)
    pairs = there.pairs(others, 0.0)
    return bool(np.min(there.separation(others, pairs).distance, initial=np.inf) > -_DEEP)


def _shifted(item: ObjectInstance, way: Float[np.ndarray, " 3"]) -> ObjectInstance:
    return replace(item, T_world_object=make_transform(translation=way) @ item.T_world_object)


def _place(item: ObjectInstance) -> str:
    return ", ".join(f"{value:.2f}" for value in item.T_world_object[:3, 3])
