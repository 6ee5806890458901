"""The page of suites: whole, self-contained, safe with any name, and the same for the same results."""

import json
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.benchmark.report.made import everything, result, row
from tests.pages import Page, needs_nothing_else, opened
from warehouse_sim.benchmark.report import is_results, write_suite_report
from warehouse_sim.benchmark.result import LeftOut, SuiteResult, write_result
from warehouse_sim.cli.main import main
from warehouse_sim.errors import EvaluationError

HOSTILE = (
    "oracle",
    "<script>alert(1)</script>",
    "$\\frac{1}{",
    "_hidden & \"quoted\" 'twice'",
    "]]></svg><img src=x onerror=alert(1)>",
    "|[a](javascript:x)|\n# head",
    "long " * 60,
)


def page_of(tmp_path: Path, *results: SuiteResult) -> str:
    files = [write_result(item, tmp_path / f"{number}.json") for number, item in enumerate(results)]
    return write_suite_report(files, tmp_path / "page.html").read_text(encoding="utf-8")


def test_the_page_is_whole_needs_nothing_else_and_has_every_number_of_a_leaderboard(tmp_path: Path) -> None:
    made = everything()
    text = page_of(tmp_path, made, replace(everything(seed=1), suite="second-v1"))
    page = Page(text)
    needs_nothing_else(text)
    assert len(page.figures) > 10
    assert "warehouse-sim bench made" in text or "bench made" in text
    words = " ".join(" ".join(page.words).split())
    for item in made.rows:
        if item.table in ("simulated", "driven", "detection") or (item.table == "scores" and item.group == "all"):
            low, high = item.interval
            assert f"{100 * item.value:.1f} {100 * low:.0f}–{100 * high:.0f}" in words
        if item.table == "confusion" and item.group in ("carton", "pallet"):
            assert f"{100 * item.value:.1f} {100 * item.interval[0]:.0f}–{100 * item.interval[1]:.0f}" in words


def test_a_hostile_name_is_only_ever_text(tmp_path: Path) -> None:
    made = everything(HOSTILE)
    rng = np.random.default_rng(0)
    evil = "</h3><script>1</script>"
    rows = [
        *made.rows,
        row(rng, "scores", "oracle", evil, "dock_0mm"),
        row(rng, "scores", HOSTILE[2], evil, "dock_0mm"),
    ]
    made = replace(
        made, rows=tuple(rows), question=evil, notes=(evil,), left_out=(LeftOut(evil, evil, evil),), command=evil
    )
    text = page_of(tmp_path, made)
    page = Page(text)
    assert "img" not in page.tags
    assert page.tags.count("script") == 2 + len(page.data), "the library, the page's own, and data"
    assert not any(name.startswith("on") for name, _ in page.attributes)
    words = "".join(page.words)
    for name in HOSTILE:
        assert name in words
    plotted = json.dumps(page.figures)
    assert "&lt;script&gt;alert(1)&lt;/script&gt;" in plotted
    assert "<" not in plotted, "a name is no markup of a chart"
    with opened(tmp_path / "page.html") as shown:
        shown.locator(".chart").first.scroll_into_view_if_needed()
        shown.wait_for_selector(".chart .main-svg", timeout=60_000)


def test_a_result_without_numbers_has_no_charts_and_says_why(tmp_path: Path) -> None:
    empty = replace(result([]), notes=("no recorded frames were given",))
    text = page_of(tmp_path, empty)
    assert Page(text).figures == []
    assert "table" not in Page(text).tags
    assert "no recorded frames were given" in text


def test_markdown_has_the_leaderboards_and_no_name_breaks_its_table(tmp_path: Path) -> None:
    path = write_result(everything(HOSTILE), tmp_path / "r.json")
    lines = write_suite_report([path], tmp_path / "boards.md").read_text().splitlines()
    tables = [line for line in lines if line.startswith("|")]
    counts = [len(re.findall(r"(?<!\\)\|", line)) for line in tables]
    heads = [number for number, line in enumerate(tables) if line.startswith("|---")]
    for first, after in zip(heads, [*heads[1:], len(tables) + 1], strict=True):
        assert len(set(counts[first - 1 : after - 1])) == 1
    assert not any(line.startswith("# head") for line in lines)
    assert sum("oracle" in line for line in tables) == 5


def test_markdown_says_what_a_result_notes(tmp_path: Path) -> None:
    noted = replace(result([row(np.random.default_rng(0), "scores", "net", "all", "dock_0mm")]), notes=("net is old",))
    path = write_result(noted, tmp_path / "r.json")
    assert "- net is old" in write_suite_report([path], tmp_path / "boards.md").read_text().splitlines()


def test_of_a_folder_a_quick_result_gives_way_to_the_full_one(tmp_path: Path) -> None:
    full = result([row(np.random.default_rng(0), "scores", "net", "all", "dock_0mm")])
    write_result(full, tmp_path / "results" / "made.json")
    write_result(replace(full, quick=True), tmp_path / "results" / "made-quick.json")
    write_result(replace(full, quick=True, suite="other-v1"), tmp_path / "results" / "other-quick.json")
    (tmp_path / "results" / "more.json").write_text('{"suite": 1}')
    text = write_suite_report([tmp_path], tmp_path / "p.html").read_text()
    assert re.findall(r'<h2 id="[^"]*">(.*?)</h2>', text) == ["Across suites", "made-v1", "other-v1 (quick)"]


def test_what_is_no_result_and_what_comes_twice_is_rejected(tmp_path: Path) -> None:
    path = write_result(everything(), tmp_path / "r.json")
    other = write_result(everything(seed=1), tmp_path / "s.json")
    with pytest.raises(EvaluationError, match=r"s\.json: is of made-v1, as .*r\.json is"):
        write_suite_report([path, other], tmp_path / "p.html")
    (tmp_path / "t.json").write_text("[]")
    with pytest.raises(EvaluationError, match=r"t\.json"):
        write_suite_report([tmp_path / "t.json"], tmp_path / "p.html")
    assert not is_results(tmp_path / "nowhere")


def test_the_command_draws_the_same_page_of_the_same_results_and_rejects_a_mixture(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    made = everything(("oracle", "net"))
    write_result(made, tmp_path / "results" / "r.json")
    out = tmp_path / "p.html"
    assert main(["report", str(tmp_path / "results"), "--out", str(out)]) == 0
    assert Page(out.read_text()).figures
    assert out.read_text() == page_of(tmp_path, made)
    (tmp_path / "empty").mkdir()
    assert main(["report", str(tmp_path / "results"), str(tmp_path / "empty"), "--out", str(out)]) == 2
    assert "holds no results of suites" in capsys.readouterr().err


def test_results_are_drawn_and_scored_without_what_made_them() -> None:
    heavy = "torch, mujoco, moderngl, embreex, open3d, sklearn, plotly, jinja2"
    code = (
        "import sys, warehouse_sim.benchmark.report, warehouse_sim.evaluation.report\n"
        f"loaded = [name for name in '{heavy}'.split(', ') if name in sys.modules]\n"
        "sys.exit(str(loaded) if loaded else 0)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
