"""MLCommons' own reader opens the Croissant metadata of a dataset, and every image behind them."""

import json
from pathlib import Path

import pytest

from tests.dataset.toy import make_dataset
from warehouse_sim.dataset.card.croissant import FILE, write_croissant

from .conftest import RunTool

pytestmark = pytest.mark.ecosystem


def test_mlcroissant_reads_every_image(run_tool: RunTool, tmp_path: Path) -> None:
    root = make_dataset(tmp_path / "data")
    found = json.loads(run_tool("read_croissant.py", write_croissant(root, tmp_path / FILE)))
    assert found["errors"] == []
    images = sorted(root.glob("bop/*/*/rgb/*.png"))
    count, size = found["records"]["bop-rgb-images"]
    assert count == len(images) > 0
    assert len(size) == 2
