"""Halls in which each kind of thing stands before the same camera, and which estimates of it are accepted."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from warehouse_sim.benchmark.negatives.things import (
    BLOCKED,
    DECK,
    GHOST,
    KINDS,
    MODEL,
    NOTHING,
    PALLET,
    Placed,
    stands_at,
    things,
)
from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.materials import materials_of
from warehouse_sim.dataset.objects import ObjectInfo, object_info
from warehouse_sim.estimators.api import PoseEstimator
from warehouse_sim.estimators.image import Detection, RgbdImage
from warehouse_sim.generation.observe import observe_scene
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.generation.scene import prepare_scene
from warehouse_sim.geometry.boxes import mask_box_xyxy
from warehouse_sim.geometry.pose import Transform, invert, level_camera
from warehouse_sim.render.renderer import Renderer
from warehouse_sim.schema import ObjectInstance, Observation, SceneSpec, Viewpoint

_CLEAR = 1.9
"""Loads and traffic nearer to the place are taken away (m)."""
_NEAR = 1.2
"""Estimates this near to the place are of what stands there (m)."""
_OTHERS = len(KINDS) - 1
_VIEWS = 4
"""Of the hall's recipe, which say where its truck comes."""


@dataclass(frozen=True, eq=False)
class Trial:
    """One thing before one camera."""

    kind: str
    observation: Observation
    ids: tuple[int, ...]
    """Instances of what was put there."""
    T_camera_pallet: Transform | None
    """Pose of the pallet among them; None where there is none."""
    place: np.ndarray
    """Where it stands (camera frame, m)."""


def trials(recipe_name: str, seed: int, index: int, places: int, renderer: Renderer) -> Iterator[Trial]:
    """Put each kind before cameras in a hall, and look.

    Args:
        recipe_name: Where the hall comes from.
        seed: Of the halls.
        index: Which of them.
        places: How many cameras.
        renderer: Renders the images.
    """
    recipe = load_recipe(recipe_name)
    recipe = replace(recipe, scene=replace(recipe.scene, observations_per_scene=_VIEWS))
    rig = replace(recipe.sensors, lidar=None)
    hall = prepare_scene(recipe, seed, index).scene
    rng = np.random.default_rng([seed, index])
    for number in range(places):
        place, viewpoint = _place_and_view(hall, rng)
        for kind in KINDS:
            scene, ids = _with(hall, things(kind, rng), place, viewpoint)
            observation = next(iter(observe_scene(scene, rig, renderer)))
            # Empty places come after all others.
            image = _OTHERS * places + number if kind == NOTHING else _OTHERS * number + KINDS.index(kind)
            observation = replace(observation, observation_index=image)
            T_camera_world = invert(observation.T_world_camera)
            T = T_camera_world @ scene.instances[ids[0] - 1].T_world_object if has_pallet(kind) else None
            yield Trial(kind, observation, ids, T, (T_camera_world @ place)[:3, 3])


def pallet_info() -> dict[int, ObjectInfo]:
    """Return the pallet as estimators learn it from a dataset; here there is none."""
    model = catalog_object(MODEL)
    info = replace(object_info(model, Path()), read_mesh=lambda obj_id, even: model.mesh())
    return {info.obj_id: info}


def accepted(trial: Trial, estimator: PoseEstimator) -> tuple[float, float]:
    """Return the best score of an estimate that is right, and of one that must not be accepted; 0 where there is none.

    Right is a pallet that can be taken, found within 5 cm and 5 degrees. Every other estimate within 1.2 m of what was
    put there must not be accepted; of what else stands in the hall nothing is evaluated.
    """
    image = RgbdImage.from_observation(trial.observation)
    mask = np.isin(trial.observation.buffers.instance_mask, trial.ids)
    detections: tuple[Detection, ...] = ()
    if not estimator.finds_objects:
        # An estimator without detector gets all of the thing up to a pallet's height as detection.
        seen = mask & _low(image, trial.observation.T_world_camera)
        box = mask_box_xyxy(seen)
        if box is None:
            return 0.0, 0.0
        detections = (Detection(mask=seen, class_name="pallet", box_xyxy=box, may_be=(MODEL,)),)
    points = image.camera.unproject(image.depth)[mask & (image.depth > 0)]
    centre = np.median(points, axis=0) if len(points) else trial.place
    right = wrong = 0.0
    for item in estimator.estimate(replace(image, detections=detections)):
        if item.rejected or np.linalg.norm(item.T_camera_object[:3, 3] - centre) > _NEAR:
            continue
        if trial.T_camera_pallet is not None and _alike(item.T_camera_object, trial.T_camera_pallet):
            if trial.kind == BLOCKED:
                wrong = max(wrong, item.score)
            else:
                right = max(right, item.score)
        elif trial.kind != PALLET:
            wrong = max(wrong, item.score)
    return right, wrong


def _place_and_view(hall: SceneSpec, rng: np.random.Generator) -> tuple[Transform, Viewpoint]:
    """Draw a place on the aisle's floor, a heading, and a level camera 2.5 to 7 m before it."""
    assert hall.aisle is not None
    x_min, x_max, y_min, y_max = hall.aisle
    while True:
        at = np.array([rng.uniform(x_min + 1.0, x_max - 1.0), rng.uniform(y_min + 1.0, y_max - 1.0)])
        distance, ahead = rng.uniform(2.5, 7.0), rng.uniform(-np.pi, np.pi)
        eye = at - distance * np.array([np.cos(ahead), np.sin(ahead)])
        if x_min + 0.3 < eye[0] < x_max - 0.3 and y_min + 0.3 < eye[1] < y_max - 0.3:
            break
    # Low enough for the floor before the thing to be in the image.
    height = rng.uniform(0.25, max(0.3, 0.22 * (distance - 0.7)))
    yaw = ahead + np.deg2rad(rng.uniform(-6, 6))
    heading = ahead + np.deg2rad(rng.uniform(-25, 25))
    T_world_camera = level_camera(np.array([*eye, height]), yaw)
    return stands_at(at[0], at[1], 0.0, heading), Viewpoint(T_world_camera)


def _with(hall: SceneSpec, placed: Placed, place: Transform, viewpoint: Viewpoint) -> tuple[SceneSpec, tuple[int, ...]]:
    """Return the hall with the things at a place, without what stood there or between it and the camera."""
    eye, at = viewpoint.T_world_camera[:2, 3], place[:2, 3]
    near = [
        item
        for item in hall.instances
        if _movable(hall, item) and _off_segment(item.T_world_object[:2, 3], eye, at) < _CLEAR
    ]
    gone, groups = {item.instance_id for item in near}, {item.group for item in near if item.group}
    kept = [item for item in hall.instances if item.instance_id not in gone and item.group not in groups]
    models = dict(hall.models) | {model.name: model for model, _ in placed}
    instances = [replace(item, instance_id=number) for number, item in enumerate(kept, start=1)]
    start = len(instances) + 1
    for number, (model, T) in enumerate(placed):
        instances.append(ObjectInstance(start + number, model.name, place @ T, dynamic=True, group=9999))
    materials = dict(materials_of(model for model, _ in placed)) | dict(hall.materials)
    scene = replace(
        hall, models=models, materials=materials, instances=tuple(instances), viewpoints=(viewpoint,), settled=True
    )
    return scene, tuple(range(start, start + len(placed)))


def _movable(hall: SceneSpec, item: ObjectInstance) -> bool:
    model = hall.model_of(item)
    return (item.dynamic or model.mass > 0.0) and model.class_name not in ("rack", "luminaire", "wall", "floor")


def _off_segment(point: np.ndarray, a: np.ndarray, b: np.ndarray) -> float:
    along = np.clip((point - a) @ (b - a) / max(float((b - a) @ (b - a)), 1e-9), 0.0, 1.0)
    return float(np.linalg.norm(point - a - along * (b - a)))


def has_pallet(kind: str) -> bool:
    """Return whether a pallet is among the things of a kind."""
    return kind in (PALLET, GHOST, BLOCKED)


def _alike(T: Transform, gt: Transform) -> bool:
    """Return whether two poses of an EPAL 1 are 5 cm and 5 degrees apart at most; a half turn maps it onto itself."""
    turn = gt[:3, :3].T @ T[:3, :3]
    angle = np.arccos(np.clip(abs(turn[0, 0]), -1.0, 1.0))
    return bool(np.linalg.norm(T[:3, 3] - gt[:3, 3]) < 0.05 and np.rad2deg(angle) < 5.0 and turn[2, 2] > 0.9)


def _low(image: RgbdImage, T_world_camera: Transform) -> np.ndarray:
    points = image.camera.unproject(image.depth) @ T_world_camera[:3, :3].T + T_world_camera[:3, 3]
    low: np.ndarray = points[..., 2] < DECK + 0.02
    return low
