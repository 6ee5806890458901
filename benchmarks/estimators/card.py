"""The card of a bundled model: what it is, how it was made, what it reached where, and what it cannot do."""

import json
from pathlib import Path

import yaml

from benchmarks.estimators import bounds
from benchmarks.estimators.headline import RECIPE, SCENES, SEED, Headline
from trainings.bundle import FIRST_STAGE
from warehouse_sim.estimators.pose.densefusion.calibration import read_calibration
from warehouse_sim.estimators.pose.densefusion.networks.densefusion import PoseRun
from warehouse_sim.estimators.registries import ESTIMATORS
from warehouse_sim.evaluation import Scores
from warehouse_sim.evaluation.summary import Summary

_SPLITS = {
    "class": "class",
    "object": "object",
    "distance": "distance",
    "visible_fraction": "visible fraction",
    "illuminance": "light on the object",
}
_FRACTIONS = {
    "add_10pct": "ADD < 10 % d",
    "add_shape_10pct": "... in shape",
    "add_5pct": "ADD < 5 % d",
    "add_2pct": "ADD < 2 % d",
    "dock_0mm": "docked",
}
_BOUND = (
    "`PoseEstimate.error_bound` is fitted so that nine of ten objects of the val splits stay below it, over all "
    "distances ({best}). Fraction of objects below it in %, 95 % intervals over scenes:"
)


def write(
    model: Path,
    head: Headline,
    test: dict[tuple[str, str], Scores],
    val: dict[str, Scores],
    held: dict[str, list[dict]],
) -> Path:
    """Write ``card.md`` and, for programs, ``card.yaml`` of a model folder.

    Args:
        model: Folder of the model.
        head: Its number on the scenes that tests draw.
        test: Scores on test by dataset and setting; the first dataset has all settings.
        val: Scores on val by dataset, with the last of the settings.
        held: How often the error bound holds, by dataset, with the last of the settings.
    """
    config = PoseRun.read(model)
    best = next(reversed(test))[1]
    lines = [
        f"# {model.name}",
        "",
        f"**{head}** on {SCENES} unseen scenes of `{RECIPE}` (consensus, no ICP), "
        "with ground-truth masks and the camera of its training (`tests/test_models.py`).",
        "",
        *_description(model),
        "",
        "## Scores",
        "",
        "Ground-truth masks, unseen scenes, objects at least 10 % visible; objects without an estimate count as "
        f"failures. Fractions in %, 95 % intervals over scenes. All groups: {best}.",
        "*In shape*: over the symmetries of the shape without its print, which differ for cartons only.",
        "",
        *_header("data and setting"),
        *(
            _row(f"{data.removesuffix('_test')} test, {setting}", scores.overall)
            for (data, setting), scores in test.items()
        ),
        *(_row(f"{data} val, {best}", scores.overall) for data, scores in val.items()),
    ]
    for group, title in _SPLITS.items():
        lines += ["", f"By {title}:", "", *_header(title)]
        for (data, setting), scores in test.items():
            if setting == best:
                place = data.removesuffix("_test")
                lines += [_row(f"{place}: {item.label}", item) for item in scores.groups[group] if item.gt_count]
    lines += ["", "## How often the error bound holds", "", _BOUND.format(best=best), ""]
    lines += bounds.as_markdown([(f"{data.removesuffix('_test')} test", rows) for data, rows in held.items()])
    lines += ["", "## Limits", "", *_limits(config)]
    summary = {
        "score": _in_short(test),
        "speed": f"{1000 * (test[next(iter(test))].seconds_per_image or 0.0):.0f} ms an image",
        "headline": {
            "recipe": RECIPE,
            "seed": SEED,
            "scenes": SCENES,
            "fraction": round(head.fraction, 4),
            "count": head.count,
        },
    }
    (model / "card.yaml").write_text(yaml.safe_dump(summary, sort_keys=False), encoding="utf-8")
    path = model / "card.md"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def _in_short(test: dict[tuple[str, str], Scores]) -> str:
    (data, setting), scores = next(reversed([item for item in test.items() if item[0][0] == next(iter(test))[0]]))
    metrics = scores.overall.metrics
    return (
        f"{data}, {setting}: ADD < 5 % d {100 * metrics['add_5pct']:.1f} %, "
        f"< 10 % d {100 * metrics['add_10pct']:.1f} %, docked {100 * metrics['dock_0mm']:.1f} %"
    )


def _description(model: Path) -> list[str]:
    stages = [folder for folder in (model / FIRST_STAGE, model) if folder.is_dir()]
    configs = [PoseRun.read(folder) for folder in stages]
    results = [json.loads((folder / "result.json").read_text(encoding="utf-8")) for folder in stages]
    config, places = configs[-1], [stage.relative_to(model) for stage in stages]
    method, train = ESTIMATORS.get(config.estimator), config.train
    data = ", ".join(f"`{item.name}` ({item.sha256[:12]})" for item in config.datasets)
    facts = {
        "size": f"{train.size}, {results[-1]['parameters']:,} parameters",
        "trained on": f"train splits of {data}; seeds in `trainings/data.py`, digests of the manifests",
        "samples": " and then ".join(
            f"{result['samples']:,} samples in {result['steps']:,} steps of {train.batch} ({result['train_crops']:,} "
            "distinct crops)"
            for result in results
        ),
        "training time": " and ".join(f"{result['seconds'] / 60:.0f} min" for result in results)
        + " of wall time on {device}, {threads} thread(s), {precision}".format(**results[-1]),
        "refiner": _refiner(model, train.refiner_iterations),
        "seed": " and ".join(str(item.train.seed) for item in configs),
        "licence": "Apache-2.0; trained on synthetic data of this package alone",
        "all settings": " and ".join(f"[{place / 'config.yaml'}]({place / 'config.yaml'})" for place in places)
        + "; curves in "
        + " and ".join(f"[{place / 'curves.csv'}]({place / 'curves.csv'})" for place in places),
        "knows": ", ".join(shape.name for shape in config.objects),
    }
    summary = f"{method.summary[0].upper()}{method.summary[1:]}. Reads: {method.inputs}."
    return [summary, "", "| | |", "|---|---|", *(f"| {key} | {value} |" for key, value in facts.items())]


def _refiner(model: Path, trained: int) -> str:
    used = read_calibration(model).refined(trained)
    count = f"{used} corrections in prediction" if used else "not used in prediction"
    return f"{count}; `--refiner-iterations` changes this ({trained} in training)"


def _header(first: str) -> list[str]:
    return [
        f"| {first} | n | " + " | ".join(_FRACTIONS.values()) + " | median ADD |",
        "|---|---|" + "---|" * (len(_FRACTIONS) + 1),
    ]


def _row(label: str, summary: Summary) -> str:
    cells = [_fraction(summary, name) for name in _FRACTIONS]
    median = summary.metrics.get("median_add")
    length = f"{100 * median:.2f} cm" if median is not None and median < 100 else "-"
    return f"| {label} | {summary.gt_count} | " + " | ".join(cells) + f" | {length} |"


def _fraction(summary: Summary, name: str) -> str:
    if name not in summary.intervals:
        return "-"
    low, high = summary.intervals[name]
    return f"{100 * summary.metrics[name]:.1f} [{100 * low:.0f}, {100 * high:.0f}]"


def _limits(config: PoseRun) -> list[str]:
    return [
        "- Not tested on real images: all numbers above are from synthetic data of the same generator.",
        "- Scored with ground-truth visible masks. Masks of a detector are worse, and its misses count.",
        "- Knows only the objects above, upright within a few degrees; the camera is KITTI's, at 0.35 to 3.2 m.",
        f"- Targets with fewer than {config.crop.min_points} depth readings or less than "
        f"{config.crop.min_visible_fraction:.0%} visible get no estimate.",
    ]
