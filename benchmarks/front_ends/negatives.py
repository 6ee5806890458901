"""Show estimators look-alikes of pallets, or none that can be taken: how much of it is accepted.

python -m benchmarks.front_ends.negatives [--estimators densefusion-depth rectangle-fit] [--scenes 10] [--write]

Four things stand in halls of `industrial`, each before a camera, 2.5 to 7 m away: a ghost pocket (a gap as wide as one
beside a pallet, under one load), three cartons in a row under a load, a shelf, and pallets with something in a pocket
or close before it. The same halls with a pallet in their place say from which score on 95 of 100 are accepted.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import tyro

from benchmarks.result import RESULTS, rounded, write_result
from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.materials import materials_of
from warehouse_sim.catalog.parts import box_part
from warehouse_sim.catalog.traffic.shapes import assembled
from warehouse_sim.dataset.objects import object_info
from warehouse_sim.estimators.api import PoseEstimator
from warehouse_sim.estimators.image import Detection, RgbdImage
from warehouse_sim.estimators.load import load_estimator
from warehouse_sim.estimators.settings import PredictConfig, Refinement
from warehouse_sim.evaluation.intervals import wilson
from warehouse_sim.generation.observe import observe_scene
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.generation.scene import prepare_scene
from warehouse_sim.geometry.boxes import OrientedBox, mask_box_xyxy
from warehouse_sim.geometry.pose import Transform, level_camera, make_transform, rotation_z
from warehouse_sim.render import open_renderer
from warehouse_sim.schema import ObjectInstance, ObjectModel, Observation, SceneSpec, Viewpoint

RECIPE, SEED = "industrial", 1921
KINDS = ("pallet", "ghost pocket", "three cartons", "shelf", "blocked pocket")
"""The first is what is to be accepted."""
RECALL = 0.95
WITHOUT_STAGES = ("rectangle-fit", "icp-multistart", "front-fit")
"""Trivial and classical methods; they neither choose among predictions nor reject."""
_KIND = "epal1"
_POCKET, _DECK, _FRONT = 0.2275, 0.144, 0.8
"""Width of a pocket, height and width of the front of an EPAL 1 (m), UIC 435-2."""
_CLEAR = 1.9
"""Loads and traffic nearer to the place are taken away (m)."""

Placed = list[tuple[ObjectModel, Transform]]


@dataclass(frozen=True, eq=False)
class Trial:
    """One thing before one camera."""

    kind: str
    observation: Observation
    ids: tuple[int, ...]
    """Instances of what was put there."""
    T_camera_pallet: Transform | None
    """Pose of the pallet among them; None where there is none."""


def things(kind: str, rng: np.random.Generator) -> Placed:
    """Return what is put on the floor, about the origin, its front towards -x; the pallet, if there is one, first."""
    if kind == "pallet":
        return [*_pallet(), *_load()]
    if kind == "blocked pocket":
        side = rng.choice([-1.0, 1.0]) * (_POCKET / 2 + 0.0725)
        return [*_pallet(), *_load(), *_blocking(side, rng)]
    if kind == "ghost pocket":
        return [*_pallet(), *_load(), *_ghost(rng)]
    if kind == "shelf":
        bay = catalog_object("shelf_bay")
        return [(bay, _at(0.0, 0.0, bay.size[2] / 2, np.pi / 2 if bay.size[0] > bay.size[1] else 0.0))]
    return _cartons(rng)


def trials(scenes: int) -> Iterator[Trial]:
    """Draw halls, put each kind before cameras in them, and look."""
    recipe = load_recipe(RECIPE)
    recipe = replace(recipe, scene=replace(recipe.scene, observations_per_scene=4))
    rig = replace(recipe.sensors, lidar=None)
    with open_renderer("raster") as renderer:
        for index in range(scenes):
            hall = prepare_scene(recipe, SEED, index).scene
            rng = np.random.default_rng([SEED, index])
            for number in range(2):
                place, viewpoint = _place_and_view(hall, rng)
                for kind in KINDS:
                    scene, ids = _with(hall, things(kind, rng), place, viewpoint)
                    observation = next(iter(observe_scene(scene, rig, renderer)))
                    observation = replace(observation, observation_index=number * len(KINDS) + KINDS.index(kind))
                    T = np.linalg.inv(observation.T_world_camera) @ scene.instances[ids[0] - 1].T_world_object
                    yield Trial(kind, observation, ids, T if _has_pallet(kind) else None)


def accepted(trial: Trial, estimator: PoseEstimator) -> tuple[float, float]:
    """Return the best score of an estimate that is right, and of one that must not be accepted.

    Right is a pallet that can be taken, found within 5 cm and 5 degrees. Every other estimate within 1.2 m of what was
    put there must not be accepted; of what else stands in the hall nothing is evaluated.
    """
    image = RgbdImage.from_observation(trial.observation)
    ids = trial.observation.buffers.instance_mask
    mask = np.isin(ids, trial.ids)
    detections: tuple[Detection, ...] = ()
    if not getattr(estimator, "finds_objects", False):
        # An estimator without detector gets all of the thing up to a pallet's height as detection.
        mask &= _low(image, trial.observation.T_world_camera)
        box = mask_box_xyxy(mask)
        if box is None:
            return 0.0, 0.0
        detections = (Detection(mask=mask, class_name="pallet", box_xyxy=box, may_be=(_KIND,)),)
    centre = np.median(_points(image, np.isin(ids, trial.ids)), axis=0)
    right = wrong = 0.0
    for item in estimator.estimate(replace(image, detections=detections)):
        if item.rejected or np.linalg.norm(item.T_camera_object[:3, 3] - centre) > 1.2:
            continue
        if trial.T_camera_pallet is not None and _alike(item.T_camera_object, trial.T_camera_pallet):
            if trial.kind == "blocked pocket":
                wrong = max(wrong, item.score)
            else:
                right = max(right, item.score)
        elif trial.kind != "pallet":
            wrong = max(wrong, item.score)
    return right, wrong


def main(
    estimators: tuple[str, ...] = ("densefusion-depth", "rectangle-fit"),
    refine: Refinement = "icp",
    scenes: int = 10,
    write: bool = False,
    pictures: Path | None = None,
) -> None:
    """Measure all estimators on the same things, those that can also with `--reject-blocked`, and print.

    Args:
        estimators: Chains that find pallets themselves, and estimators, which get the place of the thing.
        refine: As of `predict`, of those that have stages.
        scenes: Halls; ten things stand in each.
        write: Store the result file.
        pictures: Folder for a picture of each trial, with the scores of the first way.
    """
    ways = {label: way for name in estimators for label, way in opened(name, refine).items()}
    scores: dict[str, dict[str, list[tuple[float, float]]]] = {way: {kind: [] for kind in KINDS} for way in ways}
    for trial in trials(scenes):
        for label, way in ways.items():
            scores[label][trial.kind].append(accepted(trial, way))
        if pictures is not None:
            _picture(pictures, trial, *scores[next(iter(ways))][trial.kind][-1])
    rows = [row for label, item in scores.items() for row in summary(item, label)]
    for row in rows:
        print(row)
    if write:
        names = " ".join(estimators)
        command = f"python -m benchmarks.front_ends.negatives --estimators {names} --scenes {scenes} --write"
        write_result(RESULTS / "negatives.json", command, rounded(rows), data={"recipe": RECIPE, "seed": SEED})


def opened(name: str, refine: Refinement) -> dict[str, PoseEstimator]:
    """Return an estimator as it is and, where it can reject what is blocked, doing so; by what tables call them."""
    if name.removeprefix("segment-") in WITHOUT_STAGES:
        return {name: _shown(load_estimator(name, PredictConfig(objects=(_KIND,))))}
    config = PredictConfig(selection="consensus", refine=refine, objects=(_KIND,))
    return {
        name: load_estimator(name, config),
        f"{name} --reject-blocked": load_estimator(name, replace(config, reject_blocked=True)),
    }


def _shown(estimator: PoseEstimator) -> PoseEstimator:
    """Show a pallet to an estimator that learns objects from a dataset; here there is none."""
    if estimator.learns_objects:
        model = catalog_object(_KIND)
        info = replace(object_info(model, Path()), read_mesh=lambda obj_id, even: model.mesh())
        estimator.onboard({info.obj_id: info})
    return estimator


def summary(scores: dict[str, list[tuple[float, float]]], estimator: str) -> list[dict[str, Any]]:
    """Return how many of each kind are accepted from the score on that accepts 95 of 100 pallets."""
    right = np.array([good for good, _ in scores["pallet"]])
    least = float(np.quantile(right, 1.0 - RECALL, method="lower"))
    recall = float((right >= max(least, 1e-9)).mean())
    rows = [{"kind": "pallet", "min_score": least, "n": len(right), "value": recall}]
    for kind in KINDS[1:]:
        wrong = np.array([bad for _, bad in scores[kind]])
        fraction = float((wrong >= max(least, 1e-9)).mean())
        rows.append({"kind": kind, "n": len(wrong), "value": fraction})
    named = ({"name": f"{estimator}: {row['kind']}", "estimator": estimator} | row for row in rows)
    return [row | {"interval": list(wilson(row["value"], row["n"]))} for row in named]


def _pallet() -> Placed:
    pallet = catalog_object("epal1")
    return [(pallet, _at(0.0, 0.0, pallet.size[2] / 2))]


def _load() -> Placed:
    carton = catalog_object("carton_600x400x320")
    height = _DECK + carton.size[2] / 2
    return [(carton, _at(x, y, height)) for x in (-0.3, 0.3) for y in (-0.2, 0.2)]


def _ghost(rng: np.random.Generator) -> Placed:
    """Return a low carton beside the pallet, a pocket's width away, and a carton that spans the gap."""
    side, gap = rng.choice([-1.0, 1.0]), _POCKET + rng.uniform(-0.03, 0.03)
    low, upper = catalog_object("carton_300x200x150"), catalog_object("carton_600x400x320")
    beside = _FRONT / 2 + gap + low.size[1] / 2
    over = _FRONT / 2 + (gap + low.size[1]) / 2
    x = -0.6 + low.size[0] / 2
    return [
        (low, _at(x, side * beside, low.size[2] / 2)),
        (upper, _at(-0.6 + upper.size[1] / 2, side * (over + 0.1), low.size[2] + upper.size[2] / 2, np.pi / 2)),
    ]


def _cartons(rng: np.random.Generator) -> Placed:
    """Return three low cartons as far apart as the blocks of a pallet, twice as deep as they are wide, under a load."""
    low, gap = catalog_object("carton_300x200x150"), _POCKET + rng.uniform(-0.04, 0.06)
    steps = np.array([-1.0, 0.0, 1.0]) * (gap + low.size[1])
    rows = [(low, _at(x, y, low.size[2] / 2)) for x in (-0.45, 0.0, 0.45) for y in steps]
    upper = catalog_object("carton_600x400x320")
    height = low.size[2] + upper.size[2] / 2
    return [*rows, *((upper, _at(x, y, height)) for x in (-0.3, 0.3) for y in (-0.2, 0.2))]


def _blocking(y: float, rng: np.random.Generator) -> Placed:
    """Return a block of wood in the pocket, or a carton on the floor close before it."""
    if rng.random() < 0.5:
        carton = catalog_object("carton_300x200x200")
        return [(carton, _at(-0.6 - carton.size[0] / 2 - rng.uniform(0.01, 0.2), y, carton.size[2] / 2))]
    size = (0.3, 0.2, 0.094)
    part = box_part(size, (0.0, 0.0, size[2] / 2), "pallet_wood_grey")
    body = OrientedBox(make_transform(translation=np.array([0.0, 0.0, size[2] / 2])), np.array(size))
    block = assembled("pocket_block", "clutter", 9990, [part], [body], 3.0)
    return [(block, _at(-0.6 + 0.15 + rng.uniform(-0.1, 0.1), y, size[2] / 2))]


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
    return _at(at[0], at[1], 0.0, heading), Viewpoint(T_world_camera)


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


def _at(x: float, y: float, z: float, yaw: float = 0.0) -> Transform:
    return make_transform(rotation_z(yaw), np.array([x, y, z]))


def _has_pallet(kind: str) -> bool:
    return kind in ("pallet", "ghost pocket", "blocked pocket")


def _alike(T: Transform, gt: Transform) -> bool:
    """Return whether two poses of an EPAL 1 are 5 cm and 5 degrees apart at most; a half turn maps it onto itself."""
    turn = gt[:3, :3].T @ T[:3, :3]
    angle = np.arccos(np.clip(abs(turn[0, 0]), -1.0, 1.0))
    return bool(np.linalg.norm(T[:3, 3] - gt[:3, 3]) < 0.05 and np.rad2deg(angle) < 5.0 and turn[2, 2] > 0.9)


def _points(image: RgbdImage, mask: np.ndarray) -> np.ndarray:
    points: np.ndarray = image.camera.unproject(image.depth)[mask & (image.depth > 0)]
    return points if len(points) else np.full((1, 3), 1e6)


def _low(image: RgbdImage, T_world_camera: Transform) -> np.ndarray:
    points = image.camera.unproject(image.depth) @ T_world_camera[:3, :3].T + T_world_camera[:3, 3]
    low: np.ndarray = points[..., 2] < _DECK + 0.02
    return low


def _picture(folder: Path, trial: Trial, right: float, wrong: float) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    rgb = cv2.cvtColor(trial.observation.rgbd.rgb, cv2.COLOR_RGB2BGR)
    cv2.putText(rgb, f"{trial.kind} right {right:.2f} wrong {wrong:.2f}", (8, 24), 0, 0.7, (255, 255, 255), 2)
    name = f"{trial.observation.scene_index}_{trial.observation.observation_index}_{trial.kind.replace(' ', '_')}.png"
    cv2.imwrite(str(folder / name), rgb)


if __name__ == "__main__":
    tyro.cli(main)
