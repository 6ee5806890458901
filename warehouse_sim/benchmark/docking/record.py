"""What both judges say of a question, asked once and kept line by line."""

import hashlib
import json
import time
from collections.abc import Sequence
from dataclasses import asdict
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from warehouse_sim.benchmark.docking.drive import dock
from warehouse_sim.benchmark.docking.questions import Question, swept_answer
from warehouse_sim.benchmark.docking.sources import questions
from warehouse_sim.benchmark.docking.station import Station
from warehouse_sim.benchmark.docking.truck import TRUCK
from warehouse_sim.benchmark.rows.simulated import Verdict
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.schema.things import is_damaged

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
