"""Every tutorial runs from top to bottom, on small data."""

import sys
from pathlib import Path

import pytest

from tests.docs.tutorial import blocks, run
from tests.shared import Shared
from warehouse_sim.benchmark.suite import load_suite

FOLDER = Path(__file__).resolve().parents[2] / "docs" / "tutorials"
PAGES = sorted(path for path in FOLDER.glob("*.md") if path.name != "index.md")
SLOW = {"04_train", "05_photographs", "06_your_own_estimator", "09_dissertation"}
"""What trains or runs a suite."""
SMALL = {
    "--scenes 20": "--scenes 4",
    "--scenes 3": "--scenes 2",
    "--scenes 4 --formats bop --out": "--scenes 2 --formats bop --out",
    "--max-minutes 5": "--max-steps 3 --batch 4 --cache none",
    "--max-minutes 20": "--max-steps 2 --batch 2 --cache none --input-wh 320 96",
}
"""What stands in for what would take long."""


@pytest.mark.gl
@pytest.mark.pages
@pytest.mark.parametrize(
    "page",
    [pytest.param(page, marks=[pytest.mark.slow] if page.stem in SLOW else [], id=page.stem) for page in PAGES],
)
def test_a_tutorial_runs(page: Path, shared: Shared, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.delitem(sys.modules, "my", raising=False)
    recipe = "smoke" if page.stem in SLOW else shared.small  # networks need pixels
    run(page, SMALL | {" demo ": f" {recipe} "})


def test_tutorials_are_numbered_and_hold_code() -> None:
    assert [page.name[:2] for page in PAGES] == [f"{number:02d}" for number in range(1, 10)]
    assert all(blocks(page) for page in PAGES)
    assert {page.stem for page in PAGES} >= SLOW


def test_each_table_of_the_dissertation_is_that_of_its_suite() -> None:
    rows = [line.split(" | ") for line in (FOLDER / "09_dissertation.md").read_text().splitlines() if "`" in line[:90]]
    named = {row[1].strip("`"): row[0].strip("| ") for row in rows if line_is_a_table(row)}
    assert len(named) == 9
    for suite, tables in named.items():
        assert load_suite(suite).dissertation == tables


def line_is_a_table(row: list[str]) -> bool:
    return len(row) == 3 and row[0].startswith("| ")
