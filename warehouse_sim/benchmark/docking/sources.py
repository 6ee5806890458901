"""Where questions come from: scenes of a recipe, sampled here, or a dataset with a predictions file."""

import json
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from itertools import islice
from pathlib import Path

import numpy as np

from warehouse_sim.annotate.dockable import accessibility
from warehouse_sim.annotate.trucks import TRUCKS
from warehouse_sim.benchmark.docking.questions import KINDS, Question, planted, why_not
from warehouse_sim.benchmark.docking.station import Station, station_of
from warehouse_sim.config import from_mapping
from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.dataset.manifest import read_manifest
from warehouse_sim.dataset.reader import DatasetReader, ImageRecord, ObjectInfo
from warehouse_sim.dataset.results import predictions as prediction_file
from warehouse_sim.dataset.stored.scene_record import SceneRecord, read_scene_record
from warehouse_sim.errors import ConfigError, DatasetError, PlacementError
from warehouse_sim.evaluation.docking.fork import approached_face, docking_faces
from warehouse_sim.evaluation.errors.pose_error import estimates_in_object, nearest_symmetry
from warehouse_sim.evaluation.errors.surface import ErrorModels
from warehouse_sim.evaluation.pairing import pair_up
from warehouse_sim.generation.recipe import Recipe, load_recipe
from warehouse_sim.generation.scene import prepare_scene, sample_settled_scene
from warehouse_sim.geometry.pose import Transform, invert
from warehouse_sim.scene import sample_scene, scene_rng
from warehouse_sim.scene.layouts.site import Truck
from warehouse_sim.scene.solids import Solids
from warehouse_sim.schema import Accessibility, ObjectModel, SceneSpec

_LEAST_VISIBLE = 0.1
"""As the scores have it."""
_SIDES_A_SCENE = 5
"""Sides of pallets on which errors are planted in one scene: poses of one scene are alike, so more scenes say more."""
_FARTHEST, _LEAST_AHEAD = 10.0, 0.5
"""Pallets between these distances before a viewpoint (m) are evaluated in a drawn scene, seen or hidden."""

Evaluated = tuple[Question, Station]
Seen = tuple[int, int, str, str, Transform | None]
"""Image, instance, face, kind and estimate; without an estimate errors are planted."""


@dataclass
class Source:
    """``RECIPE`` or ``DATA=PREDICTIONS.csv``."""

    name: str
    seed: int = 0
    split: str = "test"
    a_scene: int | None = None
    """Predictions of at most so many pallets of a scene are evaluated, of the same ones whoever predicts; None asks
    all."""

    def __post_init__(self) -> None:
        data, _, file = self.name.partition("=")
        self.root, self.predictions = Path(data), Path(file) if file else None
        self.label = f"{self.root.name} {self.root_method}" if file else self.root.stem

    @property
    def root_method(self) -> str:
        """What the predictions are called: the folders that a score keeps them in, else the file."""
        path = self.predictions
        return "" if path is None else "/".join(path.parts[-4:-1] if path.stem == "predictions" else (path.stem,))

    def questions(self, most: int) -> Iterator[Evaluated]:
        """Yield up to ``most`` questions, scene by scene; the same ones for the same arguments."""
        found = 0
        for scene, truck, seen in self._scenes():
            reach = accessibility(scene, TRUCKS[truck])
            if self.a_scene is not None:
                seen = sorted(seen, key=lambda item: zlib.crc32(f"{scene.scene_index} {item[:3]}".encode()))
            for question, station in islice(self._of_scene(scene, reach, seen), self.a_scene):
                yield question, station
                found += 1
                if found == most:
                    return

    def _of_scene(self, scene: SceneSpec, reach: Mapping[int, Accessibility], seen: list[Seen]) -> Iterator[Evaluated]:
        evaluated: dict[tuple[int, str], str] = {}
        solids = Solids.of(scene.instances, scene.models)
        for image, instance, name, kind, estimate in seen:
            if estimate is None and sum(not reason for reason in evaluated.values()) == _SIDES_A_SCENE:
                return
            station = station_of(scene, instance, solids)
            face = station.face(name)
            if (instance, name) not in evaluated:
                evaluated[instance, name] = why_not(station, face, reach[instance].faces[name])
            if evaluated[instance, name]:
                continue
            for kind_evaluated in KINDS if estimate is None else (kind,):
                # Each question has a stream of its own, so that it is the same whatever was evaluated before.
                stream = [self.seed, scene.scene_index, instance, zlib.crc32(f"{name} {kind_evaluated}".encode())]
                rng = np.random.default_rng(stream)
                T = planted(kind_evaluated, face, rng) if estimate is None else estimate
                yield Question(self.label, scene.scene_index, image, instance, name, kind_evaluated, T), station

    def _scenes(self) -> Iterator[tuple[SceneSpec, Truck, list[Seen]]]:
        if self.predictions is not None:
            yield from self._recorded(self.predictions)
            return
        recipe = load_recipe(self.name)
        for index in range(1_000_000):
            sampled = sample_settled_scene(recipe, self.seed, index)
            yield sampled.scene, sampled.settings.layout.truck, list(_before_viewpoints(sampled.scene))

    def _recorded(self, file: Path) -> Iterator[tuple[SceneSpec, Truck, list[Seen]]]:
        reader = DatasetReader(self.root)
        rows = self._predicted(reader, reader.images(self.split), file)
        for index in sorted(rows):
            yield *scene_of(self.root, index), rows[index]

    def _predicted(self, reader: DatasetReader, images: list[ImageRecord], file: Path) -> dict[int, list[Seen]]:
        estimates = prediction_file.read(file)
        models = ErrorModels(reader.objects, 0)
        rows: dict[int, list[Seen]] = {}
        for pair in pair_up(estimates, images, models, _LEAST_VISIBLE):
            info, target = models.info(pair.target), pair.target
            if not info.pockets or pair.prediction < 0 or not target.instance_id:
                continue
            estimated = estimates[pair.prediction].T_camera_object[None]
            alike = estimates_in_object(estimated, target.T_camera_object[None], info.symmetry)
            best, _ = nearest_symmetry(alike, models.points(target).hull)
            face = _face_before(info, target.T_camera_object)
            row = (pair.image.image_id, target.instance_id, face, "predicted", best[0])
            rows.setdefault(pair.image.scene_id, []).append(row)
        return rows


def scene_of(root: Path, scene_index: int) -> tuple[SceneSpec, Truck]:
    """Return a scene of a dataset as its record says that it came to rest, and what takes pallets there.

    Raises:
        DatasetError: This version draws another scene.
    """
    path = DatasetLayout(root).scene_record(scene_index)
    attempt = json.loads(path.read_text(encoding="utf-8")).get("attempt", 0)
    recipe = from_mapping(Recipe, read_manifest(root).recipe, f"{root}: recipe")
    return recorded_scene(recipe, read_scene_record(root, scene_index), attempt, str(path))


def _before_viewpoints(scene: SceneSpec) -> Iterator[Seen]:
    seen = set()
    for number, view in enumerate(scene.viewpoints):
        for item in scene.target_instances():
            model = scene.model_of(item)
            T = invert(view.T_world_camera) @ item.T_world_object
            if not model.pockets or T[2, 3] < _LEAST_AHEAD or np.linalg.norm(T[:3, 3]) > _FARTHEST:
                continue
            face = _face_before(model, T)
            if (item.instance_id, face) not in seen:
                seen.add((item.instance_id, face))
                yield number, item.instance_id, face, "", None


def _face_before(thing: ObjectInfo | ObjectModel, T_camera_object: Transform) -> str:
    faces = docking_faces(thing.size, thing.pockets)
    return faces[int(approached_face(T_camera_object[None], faces)[0])].name


def recorded_scene(recipe: Recipe, record: SceneRecord, attempt: int, where: str) -> tuple[SceneSpec, Truck]:
    """Return a recorded scene with everything where the record has it, and the truck of its aisle.

    Args:
        recipe: What the dataset was made by.
        record: Of the scene.
        attempt: Which attempt stood, as the record's file says.
        where: The record's file, for errors.

    Raises:
        DatasetError: The recipe does not give the scene that is recorded.
    """
    try:
        settings = recipe.scene.sampled(partial(scene_rng, record.seed, record.scene_index, attempt=attempt))
        if recipe.occlusion is None:
            sampled = sample_scene(recipe.scene, record.seed, record.scene_index, attempt)
        else:  # what is put before the camera is chosen in the settled scene
            sampled = prepare_scene(recipe, record.seed, record.scene_index).scene
    except (ConfigError, PlacementError) as problem:
        raise DatasetError(f"{where}: {problem}; generate the dataset again with this version") from problem
    return _as_recorded(sampled, record, where), settings.layout.truck


def _as_recorded(sampled: SceneSpec, record: SceneRecord, where: str) -> SceneSpec:
    """Return the sampled scene with everything where the record has it."""
    models = {item.instance_id: item.model for item in sampled.instances}
    other = {item.instance_id: item.model for item in record.objects}
    differing = sorted(number for number in models.keys() | other.keys() if models.get(number) != other.get(number))
    if differing:
        number = differing[0]
        raise DatasetError(
            f"{where}: object {number} is {other.get(number)!r}, sampled again it is {models.get(number)!r}: this "
            "version samples other scenes from the recipe; use the version that the manifest names, or generate again"
        )
    places = {item.instance_id: np.asarray(item.T_world_object) for item in record.objects}
    instances = tuple(replace(item, T_world_object=places[item.instance_id]) for item in sampled.instances)
    return replace(sampled, instances=instances, settled=True)
