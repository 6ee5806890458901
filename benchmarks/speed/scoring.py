"""What scoring costs: 100,000 estimates of pallets and cartons, with every error, docking by mesh and all groups."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from benchmarks.speed.cost import Cost
from benchmarks.speed.cost import measure as cost_of
from benchmarks.speed.subject import Settings
from warehouse_sim.catalog import catalog_object
from warehouse_sim.dataset.formats.bop.models import even_mesh
from warehouse_sim.dataset.objects import ObjectInfo, object_info
from warehouse_sim.dataset.records import ImageRecord, TargetRecord
from warehouse_sim.dataset.results import predictions
from warehouse_sim.evaluation.docking.standing import Standings
from warehouse_sim.evaluation.measuring import measure
from warehouse_sim.evaluation.summary import docking_failures, docking_left_out, summarise, summarise_groups
from warehouse_sim.evaluation.trust import trust_of
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import make_transform, rotation_x, rotation_y, rotation_z
from warehouse_sim.schema import PoseEstimate

_COUNT, _QUICK = 100_000, 500
_OBJECTS = ("epal1", "gma_48x40", "epal3", "carton_600x400x320")
_AN_IMAGE, _A_SCENE = 10, 10
"""Targets of an image, images of a scene."""
_WARM_UP = 100


def scoring(settings: Settings) -> dict[str, Any]:
    """Return the row: reading the CSV, pairing, all errors, docking, groups with intervals, trust; no VSD."""
    count = _QUICK if settings.quick else _COUNT
    objects = _objects()
    _score(*_subject(_WARM_UP, objects, settings.seed), objects)  # meshes are prepared once
    stages = _score(*_subject(count, objects, settings.seed), objects)
    cpu_s, wall_s = (sum(getattr(cost, name) for cost in stages.values()) for name in ("cpu_s", "wall_s"))
    return {
        "what": f"scores of {count:,} estimates, docking by mesh included, without VSD",
        "ours_cpu_s": cpu_s,
        "target": "<= 30 on the wall, 2 cores",
        "ours_wall_s": wall_s,
        "estimates": count,
        "stages_cpu_s": {name: cost.cpu_s for name, cost in stages.items()},
    }


def _score(images: Sequence[ImageRecord], estimates: Sequence[PoseEstimate], objects: dict) -> dict[str, Cost]:
    stages = {}
    with TemporaryDirectory() as folder:
        path = Path(folder) / "made_predictions-test.csv"
        predictions.write(path, estimates)
        stages["reading"], read = cost_of(predictions.read, path)
    stages["errors"], table = cost_of(measure, read, images, objects, None, Standings())

    def groups() -> None:
        summarise("all", table)
        summarise_groups(table)
        docking_failures(table)
        docking_left_out(table)

    stages["groups"], _ = cost_of(groups)
    stages["trust"], _ = cost_of(trust_of, table)
    return stages


def _objects() -> dict[int, ObjectInfo]:
    found = {}
    for name in _OBJECTS:
        model = catalog_object(name)
        meshes = {False: model.mesh(), True: even_mesh(model)}
        info = object_info(model, Path())
        found[model.obj_id] = replace(info, read_mesh=lambda _, even, meshes=meshes: meshes[even])
    return found


def _subject(count: int, objects: dict[int, ObjectInfo], seed: int) -> tuple[list[ImageRecord], list[PoseEstimate]]:
    """Return images with labels, and one estimate of each: off by some centimetres and degrees."""
    rng, numbers = np.random.default_rng(seed), sorted(objects)
    camera = PinholeCamera.from_focal(1280, 720, 900.0)
    images, estimates = [], []
    for number in range(-(-count // _AN_IMAGE)):
        scene, image = divmod(number, _A_SCENE)
        targets = []
        for index in range(min(_AN_IMAGE, count - number * _AN_IMAGE)):
            obj_id = numbers[int(rng.integers(len(numbers)))]
            T = _pose(rng)
            box = (0.0, 0.0, 99.0, 99.0)
            targets.append(TargetRecord(index, obj_id, index + 1, T, 0.9, 9000, box, box, 9000, 10_000))
            estimates.append(PoseEstimate(scene, image, obj_id, float(rng.random()), T @ _error(rng), 0.05))
        images.append(ImageRecord("test", scene, image, camera, np.eye(4), 1.0, tuple(targets)))
    return images, estimates


def _pose(rng: np.random.Generator) -> np.ndarray:
    """Return an upright object 2 to 9 m before a level camera."""
    upright = rotation_x(np.pi / 2) @ rotation_z(float(rng.uniform(-np.pi, np.pi)))
    return make_transform(upright, np.array([rng.uniform(-2, 2), rng.uniform(-0.5, 1.5), rng.uniform(2, 9)]))


def _error(rng: np.random.Generator) -> np.ndarray:
    x, y, z = rng.normal(0.0, np.deg2rad(2.0), 3)
    turn = rotation_z(z) @ rotation_y(y) @ rotation_x(x)
    return make_transform(turn, rng.normal(0.0, 0.03, 3))
