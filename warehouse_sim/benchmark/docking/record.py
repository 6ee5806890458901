"""The results of both judges for one pose, computed once."""

import hashlib
import json
import time
from dataclasses import asdict
from pathlib import Path

import numpy as np

from warehouse_sim.benchmark.docking.drive import dock
from warehouse_sim.benchmark.docking.kept_rows import Kept, Row
from warehouse_sim.benchmark.docking.questions import Question, swept_answer
from warehouse_sim.benchmark.docking.station import Station
from warehouse_sim.benchmark.docking.truck import TruckConfig
from warehouse_sim.schema.things import is_damaged


class Record:
    """The answers in a file."""

    def __init__(self, path: Path, truck: TruckConfig) -> None:
        self.truck, self._kept = truck, Kept(path)

    def answer(self, question: Question, station: Station) -> Row:
        """Return what both judges say of a question; the simulation runs if it has not before."""
        key = _key(question, station, self.truck)
        return self._kept[key] if key in self._kept else self._kept.add(key, _ask(question, station, self.truck))


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
        "damaged": is_damaged(station.pallet.model),
        "swept": swept_answer(question, station, truck),
        "simulated": asdict(answer),
        "cpu_s": seconds,
    }


def _key(question: Question, station: Station, truck: TruckConfig) -> str:
    """Digest what the answer depends on: the question, the pallet, where it stands, and the truck."""
    settings = json.dumps([question.place, asdict(truck), station.pallet.model], sort_keys=True)
    poses = np.round(np.stack([question.T_object_estimated, station.pallet.T_world_object]), 9) + 0.0
    return hashlib.sha256(settings.encode() + poses.tobytes()).hexdigest()[:20]
