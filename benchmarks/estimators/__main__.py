"""Score every bundled estimator on unseen scenes, and write models/README.md's table and the models' cards.

python -m benchmarks.estimators [--write]        # generates out/estimators/data first if it is missing
"""

import json
import os
from pathlib import Path

import torch
import tyro

from benchmarks.estimators import bounds, card, table
from benchmarks.estimators.headline import headline, observations
from benchmarks.estimators.score import SETTINGS, VERIFICATION, bound_rows, rows, score
from trainings.data import CARTONS, FOLDER, SCORED, made
from warehouse_sim.estimators.registries import trained_names
from warehouse_sim.evaluation import Scores
from warehouse_sim.resources import data_folder

RESULT = Path(__file__).parents[1] / "results" / "estimators.json"


def main(folder: Path = FOLDER, only: tuple[str, ...] = (), verification: bool = True, write: bool = False) -> None:
    """Score the models and print the table.

    Args:
        folder: Where data, predictions and scores are kept.
        only: Names of models; all by default.
        verification: Whether pallets are scored with verification, too, which takes half of the time.
        write: Store the result, the table and the cards. With ``only``, rows of other models stay.
    """
    found: list[dict] = []
    seen, best = observations() if write else [], SETTINGS[-1]
    of_pallets = (*SETTINGS, VERIFICATION) if verification else SETTINGS
    for name in only or trained_names():
        model = data_folder("models") / name
        scored, held = {}, {}
        for data, settings, class_name in (
            *((data, of_pallets, "pallet") for data in SCORED),
            *((data, SETTINGS[-1:], "carton") for data in CARTONS),
        ):
            root, place = made(data, folder), folder / "scores" / name / data.folder_name
            for setting, scores in score(model, root, "test", settings, place).items():
                scored[data.folder_name, setting] = scores
                found += rows(scores, name, setting, class_name)
                print(*scores.summary(), sep="\n")
            held[data.folder_name] = bounds.covered(model, root, scored[data.folder_name, best.name], best)
            found += bound_rows(held[data.folder_name], scores, name, best.name)
        if write:
            card.write(model, headline(model, seen), scored, _on_val(model, folder), held)
    print(table.as_markdown(found))
    if write:
        result = _merged(found)
        RESULT.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
        table.write(result["rows"])
        print(f"output: {RESULT}")


def _on_val(model: Path, folder: Path) -> dict[str, Scores]:
    scores = {}
    for data in SCORED:
        place = folder / "scores-val" / model.name / data.folder_name
        scores[data.folder_name] = score(model, made(data, folder), "val", SETTINGS[-1:], place)[SETTINGS[-1].name]
    return scores


def _merged(found: list[dict]) -> dict:
    old = json.loads(RESULT.read_text(encoding="utf-8"))["rows"] if RESULT.is_file() else []
    renewed = {row["method"] for row in found}
    return {
        "machine": {"cores": os.cpu_count(), "torch": torch.__version__},
        "command": "python -m benchmarks.estimators --write",
        "data": "test splits of trainings/data.py: unseen scenes, ground-truth masks, objects at least "
        "10 % visible; missed objects count as failures; intervals: 95 %, bootstrap over scenes",
        "rows": [row for row in old if row["method"] not in renewed] + found,
    }


if __name__ == "__main__":
    tyro.cli(main)
