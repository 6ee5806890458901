"""The questions that predictions raise, and what both judges say of each, asked once and kept line by line."""

import hashlib
import json
import time
import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, replace
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from warehouse_sim.annotate.dockable import accessibility
from warehouse_sim.annotate.trucks import TRUCKS
from warehouse_sim.benchmark.docking.drive import dock
from warehouse_sim.benchmark.docking.questions import Question, swept_answer, why_not
from warehouse_sim.benchmark.docking.station import Station, station_of
from warehouse_sim.benchmark.docking.truck import TRUCK
from warehouse_sim.benchmark.rows.simulated import Verdict
from warehouse_sim.config import from_mapping
from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.dataset.manifest import read_manifest
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.results import predictions as prediction_file
from warehouse_sim.dataset.stored.scene_record import SceneRecord, read_scene_record
from warehouse_sim.errors import ConfigError, DatasetError, PlacementError
from warehouse_sim.evaluation.docking.fork import approached_face, docking_faces
from warehouse_sim.evaluation.errors.pose_error import estimates_in_object, nearest_symmetry
from warehouse_sim.evaluation.errors.surface import ErrorModels
from warehouse_sim.evaluation.pairing import pair_up
from warehouse_sim.generation.recipe import Recipe
from warehouse_sim.generation.scene import prepare_scene
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.scene import sample_scene, scene_rng
from warehouse_sim.scene.layouts.site import Truck
from warehouse_sim.scene.solids import Solids
from warehouse_sim.schema import Accessibility, SceneSpec
from warehouse_sim.schema.things import is_damaged

_LEAST_VISIBLE = 0.1
"""As the scores have it."""
Seen = tuple[int, int, str, Transform]
"""Image, instance, face and estimate."""


def questions(data: Path, predictions: Path, split: str, a_scene: int) -> Iterator[tuple[Question, Station]]:
    """Yield questions scene by scene; the same ones for the same arguments.

    Args:
        data: A dataset.
        predictions: A CSV of poses; what it is called are the folders that a score keeps it in, else the file.
        split: Which images.
        a_scene: Predictions of at most so many pallets of a scene are evaluated, of the same ones whoever predicts.
    """
    parts = predictions.parts[-4:-1] if predictions.stem == "predictions" else (predictions.stem,)
    label = f"{data.name} {'/'.join(parts)}"
    for index, seen in sorted(_predicted(data, predictions, split).items()):
        scene, truck = scene_of(data, index)
        reach = accessibility(scene, TRUCKS[truck])
        seen.sort(key=lambda item: zlib.crc32(f"{index} {item[:3]}".encode()))
        yield from islice(_of_scene(label, scene, reach, seen), a_scene)


def _of_scene(
    label: str, scene: SceneSpec, reach: Mapping[int, Accessibility], seen: list[Seen]
) -> Iterator[tuple[Question, Station]]:
    solids = Solids.of(scene.instances, scene.models)
    for image, instance, name, estimate in seen:
        station = station_of(scene, instance, solids)
        if not why_not(station, station.face(name), reach[instance].faces[name]):
            yield Question(label, scene.scene_index, image, instance, name, "predicted", estimate), station


def _predicted(data: Path, predictions: Path, split: str) -> dict[int, list[Seen]]:
    """Return by scene what a file of predictions says of pallets with pockets, under the best symmetry."""
    reader, estimates = DatasetReader(data), prediction_file.read(predictions)
    models = ErrorModels(reader.objects, 0)
    rows: dict[int, list[Seen]] = {}
    for pair in pair_up(estimates, reader.images(split), models, _LEAST_VISIBLE):
        info, target = models.info(pair.target), pair.target
        if not info.pockets or pair.prediction < 0 or not target.instance_id:
            continue
        estimated = estimates[pair.prediction].T_camera_object[None]
        alike = estimates_in_object(estimated, target.T_camera_object[None], info.symmetry)
        best, _ = nearest_symmetry(alike, models.points(target).hull)
        faces = docking_faces(info.size, info.pockets)
        face = faces[int(approached_face(target.T_camera_object[None], faces)[0])].name
        rows.setdefault(pair.image.scene_id, []).append((pair.image.image_id, target.instance_id, face, best[0]))
    return rows


def scene_of(root: Path, scene_index: int) -> tuple[SceneSpec, Truck]:
    """Return a scene of a dataset with everything where its record has it, and what takes pallets there.

    Raises:
        DatasetError: The recipe does not give the scene that is recorded.
    """
    record, where = read_scene_record(root, scene_index), str(DatasetLayout(root).scene_record(scene_index))
    recipe = from_mapping(Recipe, read_manifest(root).recipe, f"{root}: recipe")
    try:
        settings = recipe.scene.sampled(partial(scene_rng, record.seed, scene_index, attempt=record.attempt))
        if recipe.occlusion is None:
            sampled = sample_scene(recipe.scene, record.seed, scene_index, record.attempt)
        else:  # what is put before the camera is chosen in the settled scene
            sampled = prepare_scene(recipe, record.seed, scene_index).scene
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


Row = dict[str, Any]


class Kept:
    """Rows in a file of JSON lines, by key; a line that a stopped run left unfinished is passed over."""

    def __init__(self, path: Path) -> None:
        self._path = path
        path.parent.mkdir(parents=True, exist_ok=True)
        text = path.read_text(encoding="utf-8") if path.is_file() else ""
        self._rows: dict[str, Row] = {}
        for line in text.splitlines():
            try:
                row = json.loads(line)
            except json.JSONDecodeError:
                continue
            self._rows[row["key"]] = row
        self._is_cut = not text.endswith("\n") and bool(text)

    def __contains__(self, key: str) -> bool:
        return key in self._rows

    def __getitem__(self, key: str) -> Row:
        return self._rows[key]

    def add(self, key: str, row: Row) -> Row:
        """Keep a row and return it."""
        self._rows[key] = kept = {"key": key, **row}
        with self._path.open("a", encoding="utf-8") as file:
            # The next row would otherwise be lost with the one that was cut off.
            file.write("\n" * self._is_cut + json.dumps(kept) + "\n")
        self._is_cut = False
        return kept


def answer(kept: Kept, question: Question, station: Station) -> Row:
    """Return what both judges say of a question; the simulation runs if it has not before."""
    key = _key(question, station)
    return kept[key] if key in kept else kept.add(key, _ask(question, station))


def stream(question: Question) -> np.random.Generator:
    """Return the random stream of a docking: where the forks hang in their play."""
    digest = hashlib.sha256(json.dumps(question.place).encode()).digest()
    return np.random.default_rng(list(digest[:8]))


def _ask(question: Question, station: Station) -> Row:
    face = station.face(question.face)
    start = time.process_time()
    found = dock(station, face, question.T_object_estimated, stream(question))
    seconds = time.process_time() - start
    return {
        **question.place,
        "stack": station.carries_pallets,
        "load_kg": float(sum(station.scene.model_of(item).mass for item in station.load)),
        "height": float(station.pallet.T_world_object[2, 3]),
        "damaged": is_damaged(station.pallet.model),
        "swept": swept_answer(question, station),
        "simulated": asdict(found),
        "cpu_s": seconds,
    }


def _key(question: Question, station: Station) -> str:
    """Digest what the answer depends on: the question, the pallet, where it stands, and the truck."""
    settings = json.dumps([question.place, asdict(TRUCK), station.pallet.model], sort_keys=True)
    poses = np.round(np.stack([question.T_object_estimated, station.pallet.T_world_object]), 9) + 0.0
    return hashlib.sha256(settings.encode() + poses.tobytes()).hexdigest()[:20]


def truck_verdicts(data: Path, predictions: Path, split: str, most: int) -> Sequence[Verdict]:
    """Return a verdict for each predicted pose that docking is evaluated of; answers are kept beside the predictions.

    Args:
        data: The dataset.
        predictions: A CSV of poses.
        split: Which images.
        most: How many poses, about as many of each scene; which pallets does not depend on who predicts.
    """
    scenes = {image.scene_id for image in DatasetReader(data).images(split)}
    evaluated = islice(questions(data, predictions, split, -(-most // max(len(scenes), 1))), most)
    kept = Kept(predictions.parent / "answers.jsonl")
    rows = [answer(kept, question, station) for question, station in evaluated]
    return [Verdict(row["scene"], simulated_docks(row), swept_docks(row)) for row in rows]


def swept_docks(row: Row) -> bool:
    """Return whether the swept-volume check says of an answer that the truck takes the pallet."""
    clearance = row["swept"]["clearance"].values()
    return all(value is not None and value >= 0.0 for value in clearance)


def simulated_docks(row: Row) -> bool:
    """Return whether the simulated truck took the pallet."""
    return bool(row["simulated"]["outcome"] == "docked")
