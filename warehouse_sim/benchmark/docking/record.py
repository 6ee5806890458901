"""Answers as they are kept: a line of JSON each, so that a run that was stopped goes on where it was."""

import hashlib
import json
import time
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from warehouse_sim.benchmark.docking.drive import dock
from warehouse_sim.benchmark.docking.questions import Question, swept_answer
from warehouse_sim.benchmark.docking.station import Station
from warehouse_sim.benchmark.docking.truck import TruckConfig

Row = dict[str, Any]


class Record:
    """The answers in a file."""

    def __init__(self, path: Path, truck: TruckConfig) -> None:
        self.path, self.truck = path, truck
        path.parent.mkdir(parents=True, exist_ok=True)
        self._rows: dict[str, Row] = {}
        for line in path.read_text(encoding="utf-8").splitlines() if path.is_file() else ():
            try:
                row = json.loads(line)
            except json.JSONDecodeError:
                continue  # the last line of a run that was stopped
            self._rows[row["key"]] = row

    def answer(self, question: Question, station: Station) -> Row:
        """Return what both judges say of a question; the simulation runs if it has not before."""
        key = _key(question, station, self.truck)
        if key not in self._rows:
            self._rows[key] = row = {"key": key, **_ask(question, station, self.truck)}
            with self.path.open("a", encoding="utf-8") as file:
                file.write(json.dumps(row) + "\n")
        return self._rows[key]


def stream(question: Question) -> np.random.Generator:
    """Return the random stream of a docking: where the forks hang in their play."""
    digest = hashlib.sha256(json.dumps(question.place).encode()).digest()
    return np.random.default_rng(list(digest[:8]))


def _ask(question: Question, station: Station, truck: TruckConfig) -> Row:
    face = station.face(question.face)
    start = time.process_time()
    answer = dock(station, face, question.T_object_estimated, truck, stream(question))
    seconds = time.process_time() - start
    return {
        **question.place,
        "stack": station.carries_pallets,
        "load_kg": float(sum(station.scene.model_of(item).mass for item in station.load)),
        "height": float(station.pallet.T_world_object[2, 3]),
        "worn": "~" in station.pallet.model,
        "swept": swept_answer(question, station, truck),
        "simulated": asdict(answer),
        "cpu_s": seconds,
    }


def _key(question: Question, station: Station, truck: TruckConfig) -> str:
    """Digest what the answer depends on: the question, the pallet, where it stands, and the truck."""
    settings = json.dumps([question.place, asdict(truck), station.pallet.model], sort_keys=True)
    poses = np.round(np.stack([question.T_object_estimated, station.pallet.T_world_object]), 9) + 0.0
    return hashlib.sha256(settings.encode() + poses.tobytes()).hexdigest()[:20]
