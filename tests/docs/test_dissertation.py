"""The page of the dissertation's tables says what the stored rows say, of every table and figure."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

from docs.numbers import stored
from docs.numbers.dissertation import PAGE, page, published
from docs.numbers.freshness import unstored
from docs.numbers.insert import ROOT, inserted, tables
from docs.numbers.verdicts import FAILS, HOLDS, OPEN, Boxes, decide

PUBLISHED = published()
SECTIONS, LINEMOD = PUBLISHED.sections, PUBLISHED.linemod
AT = {"suite": "made", "condition": "c", "metric": "m"}


def row(estimator: str, low: float, value: float, high: float, **others: object) -> dict[str, object]:
    plain = {"table": "scores", "condition": "c", "group": "all", "metric": "m", "against": "", "n": 100}
    return {"estimator": estimator, "value": value, "interval": [low, high], **plain, "trainings": 0, **others}


@pytest.fixture
def made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Return what stores rows as the result of a suite."""

    def store(*rows: dict[str, object]) -> None:
        (tmp_path / "suites").mkdir(exist_ok=True)
        (tmp_path / "suites" / "made.json").write_text(json.dumps({"rows": rows}))
        stored.read.cache_clear()

    monkeypatch.setattr(stored, "RESULTS", tmp_path)
    stored.read.cache_clear()
    yield store
    stored.read.cache_clear()


def test_the_page_is_that_of_the_stored_results() -> None:
    names = {PAGE, tables()["unstored"].page}
    texts = {name: (ROOT / name).read_text(encoding="utf-8") for name in names}
    assert texts[PAGE] == page(), "run python -m docs.numbers.insert"
    sentence = tables()["unstored"].text()
    assert inserted(texts["docs/benchmark.md"], "unstored", sentence) == texts["docs/benchmark.md"]
    assert all(f"`{name}`" in sentence for name in unstored())


def test_every_table_and_figure_of_chapters_5_and_6_is_there() -> None:
    found: dict[str, set[str]] = {"Table": set(), "Fig": set()}
    for item in SECTIONS:
        for kind, numbers in re.findall(r"(Table|Fig)s?\.? ([\d., and-]+)", item.title.partition(":")[0]):
            for first, last in re.findall(r"(\d\.\d+)(?:-(\d\.\d+))?", numbers):
                chapter, start = first.split(".")
                found[kind] |= {f"{chapter}.{k}" for k in range(int(start), int((last or first).split(".")[1]) + 1)}
    assert found["Table"] == {"5.1", "5.2", *(f"6.{k}" for k in range(1, 12))}
    assert found["Fig"] >= {f"6.{k}" for k in range(1, 18)}


def test_a_claim_is_tested_or_says_why_it_cannot_be() -> None:
    for item in SECTIONS:
        for claim in item.claims:
            assert claim["says"].endswith(".")
            assert ("tests" in claim) != ("because" in claim)
    decided = [item.outcome(claim).verdict for item in SECTIONS for claim in item.claims]
    assert {HOLDS, FAILS, OPEN} == set(decided)


def test_no_number_of_ours_is_typed() -> None:
    for item in SECTIONS:
        assert not [row for row in item.rows if re.search(r"\d+[.]\d|\d %", row.get("none", ""))]
        for claim in item.claims:
            assert not re.search(r"\d", claim.get("because", ""))


def test_the_published_means_are_those_of_the_published_objects() -> None:
    """A digit that was copied wrongly moves a mean; the dissertation rounds or cuts to a tenth, but for one method."""
    means = {
        "original": 95.3, "depth": 90.0, "cloud": 94.8, "early": 95.8, "middle-1": 96.5, "middle-2": 97.2,
        "DeepIM": 88.6, "CDPN": 89.9, "HybridPose": 94.5, "MaskedFusion": 97.3, "FFB6D": 99.7, "CloudPose": 75.2,
        "CloudAAE": 92.5,
    }  # fmt: skip
    assert set(LINEMOD) == set(means)
    for name, values in LINEMOD.items():
        assert len(values) == 13
        assert np.mean(values) == pytest.approx(96.0 if name == "early" else means[name], abs=0.09), name
    shown = {row["theirs"] for item in SECTIONS for row in item.rows if "theirs" in row}
    assert {f"{mean:.1f}" for mean in means.values()} <= shown


def verdict(*tests: dict[str, object], boxes: Boxes | None = None) -> str:
    return decide(tests, AT, boxes).verdict


def test_a_paired_effect_decides_before_two_intervals_do(made) -> None:
    both = row("a", 0.5, 0.6, 0.7), row("b", 0.4, 0.55, 0.65)
    made(*both)
    assert verdict({"above": ["a", "b"]}) == OPEN
    made(*both, row("a", 0.01, 0.05, 0.09, table="effects", against="b", group="factor"))
    assert verdict({"above": ["a", "b"]}) == HOLDS
    assert verdict({"above": ["b", "a"]}) == FAILS
    assert verdict({"alike": ["a", "b"]}) == FAILS
    assert "+5.0 [+1.0, +9.0]" in decide([{"above": ["a", "b"]}], AT).why
    assert "-5.0 [-9.0, -1.0]" in decide([{"above": ["b", "a"]}], AT).why
    made(*both, row("a", -0.01, 0.005, 0.015, table="effects", against="b", group="factor"))
    assert verdict({"above": ["a", "b"]}) == OPEN
    assert verdict({"alike": ["a", "b"]}) == HOLDS
    assert verdict({"alike": ["a", "b"], "within": 1}) == OPEN


def test_effects_of_a_class_and_of_a_condition_are_found(made) -> None:
    effects = {"table": "effects", "against": "b"}
    made(
        row("a", 0.1, 0.5, 0.9, group="pallet"),
        row("b", 0.1, 0.5, 0.9, group="pallet"),
        row("a", 0.1, 0.5, 0.9),
        row("b", 0.1, 0.5, 0.9),
        row("a", 0.1, 0.5, 0.9, condition="d"),
        row("a", 0.1, 0.2, 0.3, group="input, pallet", **effects),
        row("a", -0.3, -0.2, -0.1, group="detections: c", table="effects", against="d"),
    )
    pallets = [{"group": "pallet", "estimator": "a"}, {"group": "pallet", "estimator": "b"}]
    assert verdict({"above": pallets}) == HOLDS
    assert verdict({"above": ["a", "b"]}) == OPEN, "an effect of a class says nothing of all"
    assert verdict({"above": ["a", {"estimator": "a", "condition": "d"}]}) == FAILS


def test_intervals_that_do_not_meet_decide(made) -> None:
    made(row("a", 0.5, 0.6, 0.7), row("b", 0.2, 0.3, 0.4), row("c", 0.7, 0.8, 0.9))
    assert verdict({"above": ["a", "b"]}) == HOLDS
    assert verdict({"above": ["b", "a"]}) == FAILS
    assert verdict({"above": ["c", "a"]}) == OPEN
    assert verdict({"alike": ["a", "b"]}) == FAILS
    assert verdict({"alike": ["a", "c"]}) == OPEN, "two intervals that meet do not make two numbers alike"


def test_one_comparison_that_contradicts_decides(made) -> None:
    made(row("a", 0.5, 0.6, 0.7), row("b", 0.2, 0.3, 0.4), row("c", 0.6, 0.8, 0.9))
    assert verdict({"above": ["a", "b"]}, {"above": ["c", "b"]}) == HOLDS
    assert verdict({"above": ["a", "b"]}, {"above": ["c", "a"]}) == OPEN
    assert verdict({"above": ["a", "b"]}, {"above": ["c", "a"]}, {"above": ["b", "c"]}) == FAILS


@pytest.mark.parametrize(
    ("kind", "percent", "low", "value", "high", "expected"),
    [
        ("at_least", 50, 0.5, 0.6, 0.7, HOLDS),
        ("at_least", 60, 0.5, 0.65, 0.7, OPEN),
        ("at_least", 88, 0.5, 0.6, 0.7, FAILS),
        ("at_least", 100, 0.99, 1.0, 1.0, HOLDS),
        ("at_least", 100, 0.95, 0.99, 1.0, OPEN),
        ("at_most", 0, 0.0, 0.0, 0.01, HOLDS),
        ("at_most", 0, 0.01, 0.02, 0.03, FAILS),
        ("at_most", 2, 0.01, 0.02, 0.03, OPEN),
    ],
)
def test_a_bound_is_for_the_whole_interval(
    made, kind: str, percent: int, low: float, value: float, high: float, expected: str
) -> None:
    made(row("a", low, value, high))
    assert verdict({kind: "a", "percent": percent}) == expected


def test_what_is_not_stored_decides_nothing_and_is_named(made) -> None:
    made(row("a", 0.5, 0.6, 0.7))
    outcome = decide([{"above": ["a", "b"]}], AT)
    assert outcome.verdict == OPEN
    assert outcome.why == "no stored result of `b`"


def test_the_narrower_box_is_found_over_objects(made) -> None:
    wide, narrow = np.linspace(0.1, 0.9, 20), np.linspace(0.7, 0.8, 20)
    rows = [row("wide", 0, v, 1, group=f"o{k}") for k, v in enumerate(wide)]
    rows += [row("narrow", 0, v, 1, group=f"o{k}") for k, v in enumerate(narrow)]
    few = [row("narrow", 0, 0.0, 1, group="few", n=3), row("wide", 0, 0.0, 1, group="few", n=3)]
    made(*rows, *few, row("wide", 0, 0.5, 1), row("narrow", 0, 0.75, 1))
    boxes = Boxes(("all",), 50)
    assert verdict({"narrower": ["narrow", "wide"]}, boxes=boxes) == HOLDS
    assert verdict({"narrower": ["wide", "narrow"]}, boxes=boxes) == FAILS
    assert verdict({"narrower": ["wide", "wide"]}, boxes=boxes) == OPEN
    assert "over 20 objects" in decide([{"narrower": ["narrow", "wide"]}], AT, boxes).why


def test_two_rows_of_one_place_are_an_error(made) -> None:
    made(row("a", 0.5, 0.6, 0.7), row("a", 0.5, 0.6, 0.7), row("b", 0.1, 0.2, 0.3))
    with pytest.raises(LookupError, match="2 rows"):
        verdict({"above": ["a", "b"]})
