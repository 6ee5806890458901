"""The site's pages from code and results hold what they are made of, and its check finds what is dead or elsewhere."""

import dataclasses
import json
from pathlib import Path

import pytest

from docs.site import recipe_reference, stored_results
from docs.site.check import problems
from docs.site.pages import api, commands, faults, with_site_links
from tests.dataset.faults.table import FAULTS, THIRD_PARTY_FAULTS
from warehouse_sim import __all__ as public
from warehouse_sim.cli.commands import COMMANDS
from warehouse_sim.scene.layouts.site import Layout
from warehouse_sim.sensors.rgbd.depth.models import MODELS

RESULTS = Path(__file__).resolve().parents[2] / "benchmarks" / "results"
GOOD = '<h1 id="top">A</h1><a href="#top">up</a><a href="b/c.html#there">on</a><a href="https://x.org">away</a>'


@pytest.fixture
def site(tmp_path: Path) -> Path:
    (tmp_path / "b").mkdir()
    (tmp_path / "a.html").write_text(GOOD)
    (tmp_path / "b" / "c.html").write_text('<p id="there">C</p><a href="../a.html">back</a><img src="data:,">')
    return tmp_path


def test_a_site_without_faults_passes(site: Path) -> None:
    assert problems(site) == []


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ('<a href="gone.html">x</a>', "a.html: gone.html is dead"),
        ('<a href="b/c.html#nowhere">x</a>', "a.html: b/c.html#nowhere is dead"),
        ('<img src="gone.png">', "a.html: gone.png is dead"),
        ('<script src="https://cdn.org/x.js"></script>', "a.html: loads https://cdn.org/x.js from elsewhere"),
        ('<link rel="stylesheet" href="//cdn.org/x.css">', "a.html: loads //cdn.org/x.css from elsewhere"),
    ],
)
def test_a_fault_of_a_page_is_named(site: Path, text: str, problem: str) -> None:
    (site / "a.html").write_text(GOOD + text)
    assert problems(site) == [problem]


def test_a_style_that_loads_from_elsewhere_is_named(site: Path) -> None:
    (site / "x.css").write_text("@font-face { src: url('https://fonts.org/a.woff2'); }")
    assert problems(site) == ["x.css: loads https://fonts.org/a.woff2 from elsewhere"]


def test_an_empty_folder_is_no_site(tmp_path: Path) -> None:
    assert problems(tmp_path) == [f"{tmp_path}: holds no page"]


def test_the_recipe_reference_describes_every_setting() -> None:
    sections = list(recipe_reference.sections())
    paths = [section.path for section in sections]
    assert len(set(paths)) == len(paths)
    assert {f"scene.layout (kind: {kind})" for kind in Layout.kinds} <= set(paths)
    assert {f"sensors.rgbd.depth (model: {model})" for model in MODELS} <= set(paths)
    for section in sections:
        said = recipe_reference.descriptions(section.settings)
        fields = {field.name for field in dataclasses.fields(section.settings) if field.init}
        assert fields - said.keys() == set(), section.path


def test_ranges_and_defaults_of_the_reference_are_those_of_the_code() -> None:
    rows = recipe_reference.page().splitlines()
    assert any(row.startswith("| `observations_per_scene` | whole number, 1-1,000 | `8` |") for row in rows)
    assert any(row.startswith("| `truck` | `any`, `counterbalance`, `reach`, `very_narrow`") for row in rows)


def test_every_row_of_every_result_is_shown() -> None:
    found = stored_results.pages(RESULTS)
    for path in RESULTS.glob("*.json"):
        lines = found[f"{path.stem}.md"].splitlines()
        start = next(number for number, line in enumerate(lines) if line.startswith("|---"))
        assert len(lines) - start - 1 == len(json.loads(path.read_text())["rows"])
        assert len({line.count("|") for line in lines[start:]}) == 1, path
        assert f"({path.stem}.md)" in found["index.md"]


def test_pages_of_the_code_hold_every_name() -> None:
    assert all(f"## {name}\n" in api() for name in public if not name.startswith("_"))
    text = commands()
    assert all(f"## {name}\n\n```text\nusage: warehouse-sim {name} " in text for name in COMMANDS)
    assert all(f"| {fault.name} | {fault.check} |" in faults() for fault in (*FAULTS, *THIRD_PARTY_FAULTS))


def test_links_to_results_lead_to_their_pages() -> None:
    source = ["[x](../benchmarks/results/speed.json), [y.md](y.md#z)"]
    with_site_links(None, "docs/tracking", source)
    assert source == ["[x](../docs/generated/results/speed.md), [](y.md#z)"]
