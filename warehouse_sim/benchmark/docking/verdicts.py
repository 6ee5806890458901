"""The simulated truck on a file of predictions, for suites."""

from collections.abc import Sequence
from pathlib import Path

from warehouse_sim.benchmark.docking.agreement import simulated_docks, swept_docks
from warehouse_sim.benchmark.docking.record import Record
from warehouse_sim.benchmark.docking.sources import Source
from warehouse_sim.benchmark.docking.truck import TruckConfig
from warehouse_sim.benchmark.rows.simulated import Verdict
from warehouse_sim.dataset.reader import DatasetReader


def truck_verdicts(data: Path, predictions: Path, split: str, most: int) -> Sequence[Verdict]:
    """Return a verdict for each predicted pose that docking is evaluated of; answers are kept beside the predictions.

    Args:
        data: The dataset.
        predictions: A CSV of poses.
        split: Which images.
        most: How many poses, about as many of each scene; which pallets does not depend on who predicts.
    """
    truck = TruckConfig()
    scenes = {image.scene_id for image in DatasetReader(data).images(split)}
    source = Source(f"{data}={predictions}", truck, split=split, a_scene=-(-most // max(len(scenes), 1)))
    record = Record(predictions.parent / "answers.jsonl", truck)
    rows = [record.answer(question, station) for question, station in source.questions(most)]
    return [Verdict(row["scene"], simulated_docks(row), swept_docks(row)) for row in rows]
