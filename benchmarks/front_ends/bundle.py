"""Put trained front ends into models/, with cards of what benchmarks/results/front_ends.json says of them.

python -m benchmarks.front_ends.bundle [--methods detector-depth ...] [--cards-only]
"""

import json
from pathlib import Path

import tyro

from benchmarks.front_ends import card
from benchmarks.result import RESULTS
from trainings.bundle import bundle
from trainings.data import FRONT_ENDS
from trainings.front_ends import PLANS, in_order
from warehouse_sim.resources import data_folder


def main(folder: Path = FRONT_ENDS, methods: tuple[str, ...] = (), cards_only: bool = False) -> None:
    """Bundle the runs that are complete, and write the cards of all that are bundled.

    Args:
        folder: Where runs are.
        methods: Which front ends; all by default.
        cards_only: Leave the weights as they are.
    """
    result = RESULTS / "front_ends.json"
    rows = json.loads(result.read_text(encoding="utf-8"))["rows"] if result.is_file() else []
    for name in in_order(methods or tuple(PLANS)):
        run, model = folder / "runs" / name, data_folder("models") / name
        if not cards_only and (run / "result.json").is_file():
            bundle(run, name)
        if (model / "result.json").is_file():
            print(f"output: {card.write(model, rows)}")


if __name__ == "__main__":
    tyro.cli(main)
