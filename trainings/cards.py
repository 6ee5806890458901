"""The cards of the bundled weights and the table of models/README.md, written of stored results alone.

python -m trainings.cards [NAME ...] [--headlines]

Scores are those of the suites in benchmarks/results/suites; of detectors and segmenters those in layouts beside them,
and of what is scored in no other way those of the chain that it is a part of.
"""

import json
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from statistics import median
from typing import Any

import tyro
import yaml

from benchmarks.speed.result import RESULTS
from trainings.facts import POSES, description
from trainings.headline import LIMIT, RECIPE, SCENES, SEED, Headline, headline, observations
from warehouse_sim.benchmark.result import SuiteResult, read_result
from warehouse_sim.benchmark.rows.row import SECONDS, WORST, Row
from warehouse_sim.estimators.lidar.direct import LIDAR_DIRECT
from warehouse_sim.estimators.load import DETECT_KEYPOINTS
from warehouse_sim.learning.run_folder import read_kind
from warehouse_sim.resources import data_folder, model_names
from warehouse_sim.yaml_file import read_yaml

BY_LAYOUT = "-warehouses"
"""Ending of weights whose cards ``benchmarks.front_ends.layout_card`` writes."""
COMMAND, END = "python -m trainings.cards", "<!-- end of table -->"
_METRICS = {
    "add_10pct": "ADD < 10 % d", "add_5pct": "< 5 % d", "add_2pct": "< 2 % d",
    "add_shape_10pct": "< 10 % d in shape", "dock_0mm": "docked", "dock_20mm": "docked, 20 mm clear",
}  # fmt: skip
_PRECISIONS = {"box_50": "boxes AP50", "box_75": "AP75", "mask_50": "masks AP50", "mask_75": "AP75"}
_IN_LAYOUTS = {"detector-depth": "boxes", "segmenter-depth": "masks"}
"""What ``benchmarks.front_ends.layouts`` calls the scores of front ends whose cards are written here."""
_CHAINS = {LIDAR_DIRECT.detector: "lidar-direct", DETECT_KEYPOINTS.network: "detect-keypoints"}
"""Chains by the part that nothing scores alone."""
_OVERVIEW = (
    ("industrial", "industrial", "all", "add_10pct", "`industrial`: ADD < 10 % d"),
    ("industrial", "industrial", "all", "add_5pct", "ADD < 5 % d"),
    ("industrial", "industrial", "all", "dock_0mm", "docked"),
    ("industrial", "industrial", "2-7 m", "dock_0mm", "docked, 2-7 m"),
    ("docking", "mixed", "all", "dock_0mm", "`mixed_pallets`: docked"),
    ("docking", "docks", "all", "dock_0mm", "`dock_staging`: docked"),
    ("multimodal", "cartons", "carton", "add_10pct", "cartons: ADD < 10 % d"),
    ("multimodal", "cartons", "carton", "add_shape_10pct", "in shape"),
)
"""Columns of the table: suite, condition, group, metric, heading."""


def main(names: tyro.conf.Positional[tuple[str, ...]] = (), headlines: bool = False) -> None:
    """Write the cards and the table.

    Args:
        names: Models; all by default.
        headlines: Measure the headlines of pose estimators again, instead of taking those of their cards.
    """
    seen = observations() if headlines else []
    for name in names or [name for name in model_names() if not name.endswith(BY_LAYOUT)]:
        model = data_folder("models") / name
        measured = headline(model, seen) if headlines and read_kind(model) == POSES else None
        print(f"output: {write(model, measured)}")
    print(f"output: {write_table(data_folder('models') / 'README.md')}")


def write(model: Path, measured: Headline | None = None) -> Path:
    """Write ``card.md`` and, for programs, ``card.yaml`` of a model's folder; without a new headline that stays."""
    card = _stored_headline(model) if measured is None else _facts(measured)
    if read_kind(model) == POSES:
        scores, brief = _of_poses(model)
        limits = ["Scored with ground-truth visible masks unless a suite says otherwise; a detector's are worse."]
    else:
        scores, brief = _of_front_end(model.name)
        limits = ["It may miss objects that are unlike its training data, or report them as pallets."]
    limits.insert(0, "Not tested on real images: trained and scored on synthetic images of this package only.")
    lines = [f"# {model.name}", "", *_headline(card), *description(model), "", "## Scores", "", *scores]
    lines += ["", "## Limits", "", *(f"- {line}" for line in limits)]
    if whole := brief | ({"headline": card} if card else {}):
        (model / "card.yaml").write_text(yaml.safe_dump(whole, sort_keys=False), encoding="utf-8")
    else:
        (model / "card.yaml").unlink(missing_ok=True)
    path = model / "card.md"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def _stored_headline(model: Path) -> dict[str, Any]:
    path = model / "card.yaml"
    return read_yaml(path).get("headline", {}) if path.is_file() else {}


def _facts(measured: Headline) -> dict[str, Any]:
    numbers = {"fraction": round(measured.fraction, 4), "count": measured.count}
    return {"recipe": RECIPE, "seed": SEED, "scenes": SCENES} | numbers


def _of_poses(model: Path) -> tuple[list[str], dict[str, Any]]:
    """Return the lines of the scores, and what programs read."""
    lines = [
        "Of [suites](../../docs/benchmark.md#suites): unseen scenes, objects at least 10 % visible; what has no "
        "estimate counts as a failure. In % with 95 % intervals over scenes.",
    ]
    for name, result in suites().items():
        mine = [row for row in result.rows if row.table == "scores" and row.estimator.split("+")[0] == model.name]
        mine = [row for row in mine if ", " not in row.group and row.metric in _METRICS]
        lines += ["", f"### `{name}`", "", *_by_place(mine)] if mine else []
    return lines, _brief(model.name)


def _headline(card: dict[str, Any]) -> list[str]:
    if not card:
        return []
    return [
        f"**ADD < {LIMIT:.0%} of the diameter for {100 * card['fraction']:.1f} % of {card['count']} pallets** on "
        f"{card['scenes']} unseen scenes of `{card['recipe']}` (consensus, no ICP), with ground-truth masks and the "
        "camera of its training (`tests/test_models.py`).",
        "",
    ]


def _by_place(rows: Sequence[Row]) -> list[str]:
    """Return a table: a line for each estimator, condition and group, a column for each metric."""
    metrics = [name for name in _METRICS if any(row.metric == name for row in rows)]
    places: dict[tuple[str, str, str], dict[str, Row]] = {}
    for row in rows:
        places.setdefault((row.estimator, row.condition, row.group), {})[row.metric] = row
    lines = ["| estimator | condition | of | n | " + " | ".join(_METRICS[name] for name in metrics) + " |"]
    lines.append("|---|---|---|---|" + "---|" * len(metrics))
    for (estimator, condition, group), found in places.items():
        cells = [_cell(found.get(name)) for name in metrics]
        n = max(row.n for row in found.values())
        lines.append(f"| `{estimator}` | {condition} | {group} | {n} | " + " | ".join(cells) + " |")
    return lines


def _brief(name: str) -> dict[str, Any]:
    """Return score and time of the last way that the model is used in: on the reference set, or the worst layout."""
    for suite, condition in (("industrial", "industrial"), ("warehouses", WORST)):
        rows = suites()[suite].rows if suite in suites() else ()
        mine = [row for row in rows if row.estimator.split("+")[0] == name and row.condition == condition]
        mine = [row for row in mine if row.group == "all"]
        if mine:
            found = {row.metric: row for row in mine if row.estimator == mine[-1].estimator}
            texts = [f"{_METRICS[metric]} {100 * found[metric].value:.1f} %" for metric in ("add_10pct", "dock_0mm")]
            speed = {"speed": f"{1000 * found[SECONDS].value:.0f} ms an image"} if SECONDS in found else {}
            return {"score": f"{condition}, {mine[-1].estimator}: {', '.join(texts)}"} | speed
    return {}


def _of_front_end(name: str) -> tuple[list[str], dict[str, Any]]:
    """Return the lines of the scores of what finds objects, and what programs read."""
    layouts = _in_layouts(name)
    found = [*_in_suites(name), *layouts]
    if not found and name not in _CHAINS:
        raise SystemExit(f"{name}: no stored result scores it; run a suite that does, or name its chain in _CHAINS")
    if not found:
        return _of_chain(_CHAINS[name])
    lines = [
        "Unseen scenes, average precision in % with 95 % intervals over scenes; misses count, and hardly visible "
        "objects are ignored."
        + (" Layouts: pallets within 10 m (`python -m benchmarks.front_ends.layouts`)." if layouts else ""),
        "",
        "| evaluated on | n | " + " | ".join(_PRECISIONS.values()) + " |",
        "|---|---|" + "---|" * len(_PRECISIONS),
    ]
    for row in found:
        cells = [percent_cell(row.get(metric)) for metric in _PRECISIONS]
        lines.append(f"| {row['name']} | {row['n']} | {' | '.join(cells)} |")
    best = found[0]
    kind = "mask_50" if "mask_50" in best else "box_50"
    speed = {"speed": f"{median(row['median_ms'] for row in layouts):.0f} ms an image"} if layouts else {}
    return lines, {"score": f"{best['name']}: {_PRECISIONS[kind]} {100 * best[kind]['value']:.1f} %"} | speed


def _of_chain(chain: str) -> tuple[list[str], dict[str, Any]]:
    """Return the lines of the scores of a chain by suite, and what programs read."""
    lines = [f"Scored as a part of the chain `{chain}`: unseen scenes, in % with 95 % intervals over scenes."]
    brief: dict[str, Any] = {}
    for name, result in suites().items():
        mine = [row for row in result.rows if (row.table, row.estimator) == ("scores", chain)]
        mine = [row for row in mine if row.metric in _METRICS]
        lines += ["", f"### `{name}`", "", *_by_place(mine)] if mine else []
        for row in mine:
            if (row.group, row.metric) == ("all", "dock_0mm"):
                brief.setdefault("score", f"suite `{name}`, {chain}: docked {100 * row.value:.1f} %")
    return lines, brief


def _in_suites(name: str) -> list[dict[str, Any]]:
    """Return a row for each suite, condition and class that a detector or segmenter was scored on."""
    places: dict[str, dict[str, Any]] = {}
    for suite, result in suites().items():
        for row in result.rows:
            if row.table == "detection" and row.estimator.split("+")[-1] == name:
                key = f"suite `{suite}`, {row.estimator}, {row.condition}: {row.group}"
                place = places.setdefault(key, {"name": key, "n": row.n})
                place[row.metric.removeprefix("ap_")] = {"value": row.value, "interval": row.interval}
    return list(places.values())


def _in_layouts(name: str) -> list[dict[str, Any]]:
    """Return a row for each layout, the worst first."""
    rows = json.loads((RESULTS / "layouts.json").read_text(encoding="utf-8"))["rows"]
    method = _IN_LAYOUTS.get(name)
    mine = [row for row in rows if (row["method"], row["weights"]) == (method, "industrial")]
    mine.sort(key=lambda row: float(row["value"]))
    kind = "mask_50" if method == "masks" else "box_50"
    return [
        {"name": f"layout `{row['layout']}`", "n": row["n"], "median_ms": row["median_ms"]}
        | {kind: {"value": row["value"], "interval": row["interval"]}}
        for row in mine
    ]


@cache
def suites() -> dict[str, SuiteResult]:
    """Return the stored results of suites, the reference set first."""
    paths = sorted((RESULTS / "suites").glob("*.json"), key=lambda path: (path.stem != "industrial", path.stem))
    return {path.stem: read_result(path) for path in paths}


def as_table() -> str:
    """Return the table of pose estimators: a line for each and each way that the reference set has."""
    found = {
        (suite, row.estimator, row.condition, row.group, row.metric): row
        for suite, result in suites().items()
        for row in result.rows
        if row.table == "scores"
    }
    poses = [name for name in model_names() if read_kind(data_folder("models") / name) == POSES]
    ways = dict.fromkeys(name for _, name, *_ in found if name.split("+")[0] in poses)
    lines = ["| | " + " | ".join(heading for *_, heading in _OVERVIEW) + " |", "|---|" + "---|" * len(_OVERVIEW)]
    for name in sorted(ways):
        places = [(suite, name, condition, group, metric) for suite, condition, group, metric, _ in _OVERVIEW]
        cells = [_cell(found.get(place)) for place in places]
        if set(cells) != {"-"}:
            lines.append(f"| [`{name}`]({name.split('+')[0]}/card.md) | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def write_table(path: Path) -> Path:
    """Put the table between its marks in a document.

    Raises:
        ValueError: The document has no such marks.
    """
    start = f"<!-- table: {COMMAND} -->"
    before, marked, rest = path.read_text(encoding="utf-8").partition(start)
    _, ended, after = rest.partition(END)
    if not marked or not ended:
        raise ValueError(f"{path}: has no lines {start!r} and {END!r}")
    path.write_text(f"{before}{start}\n\n{as_table()}\n\n{END}{after}", encoding="utf-8")
    return path


def _cell(row: Row | None) -> str:
    return percent_cell(None if row is None else {"value": row.value, "interval": row.interval})


def percent_cell(row: dict[str, Any] | None) -> str:
    """Return a fraction with its interval as a cell of a table, in per cent; "-" where there is none."""
    if row is None:
        return "-"
    low, high = row["interval"]
    return f"{100 * row['value']:.1f} [{100 * low:.0f}, {100 * high:.0f}]"


if __name__ == "__main__":
    tyro.cli(main)
