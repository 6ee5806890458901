"""Weights for any layout: cards that hide no layout, and results that come out of the weights."""

import json
import re
import shutil
from pathlib import Path

import pytest

from benchmarks.front_ends import layouts
from benchmarks.front_ends.layout_card import write
from benchmarks.speed.result import RESULTS
from trainings.data import made
from warehouse_sim.resources import model_dir, model_names

NAMES = [name for name in model_names() if name.endswith("-warehouses")]


def stored() -> dict[str, dict]:
    rows = json.loads((RESULTS / "layouts.json").read_text(encoding="utf-8"))["rows"]
    return {row["name"]: row for row in rows}


@pytest.mark.parametrize("name", NAMES)
def test_a_card_holds_every_layout_worst_first(name: str) -> None:
    text = (model_dir(name) / "card.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| `(\w+)` \| ([0-9.]+)", text, re.MULTILINE)
    assert sorted(layout for layout, _ in rows) == sorted(layouts.LAYOUTS)
    values = [float(value) for _, value in rows]
    assert values == sorted(values)
    assert "| licence | Apache-2.0" in text


@pytest.mark.parametrize("name", NAMES)
def test_a_card_is_that_of_the_stored_results(name: str, tmp_path: Path) -> None:
    folder = Path(shutil.copytree(model_dir(name), tmp_path / name))
    before = (folder / "card.md").read_bytes(), (folder / "card.yaml").read_bytes()
    write(folder, name.removesuffix("-warehouses"), list(stored().values()))
    assert before == ((folder / "card.md").read_bytes(), (folder / "card.yaml").read_bytes())


@pytest.mark.slow
@pytest.mark.gl
def test_stored_precision_comes_out_of_the_weights(tmp_path: Path) -> None:
    root = made(layouts.data("conveyor_pickup"), tmp_path, 2)
    found = layouts._found("boxes", "warehouses", root, tmp_path / "found.json")
    row = stored()["conveyor_pickup: boxes (warehouses)"]
    assert found["n"] == row["n"]
    assert found["value"] == pytest.approx(row["value"], abs=0.02)
