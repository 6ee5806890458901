"""Write one self-contained page of what was made, trained and scored; its sections on datasets and runs are here."""

import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.dataset.reader import DatasetReader, ImageRecord
from warehouse_sim.dataset.stored.contents import ReadingContents
from warehouse_sim.errors import EvaluationError
from warehouse_sim.evaluation.report import charts
from warehouse_sim.evaluation.report.images import depth_frame, frame_with_boxes, jpeg_uri
from warehouse_sim.evaluation.report.numbers import NOTHING, counted
from warehouse_sim.evaluation.report.score_sections import evaluation_section, score_row
from warehouse_sim.evaluation.report.sources import EvaluationSource, RunSource, read_sources
from warehouse_sim.optional import require
from warehouse_sim.output import make_folder, write_bytes
from warehouse_sim.schema import MountedReading, Reading

_MANY = 3
"""From more evaluations than this on, each shows one case a group, to keep the page small."""


def write_report(folders: Sequence[str | Path], out: str | Path) -> Path:
    """Write one HTML page about dataset, run and evaluation folders; it needs no other file and no network.

    Args:
        folders: The folders, or folders that hold them; an evaluation needs its dataset among them.
        out: The page to write.

    Returns:
        ``out``.

    Raises:
        EvaluationError: No folder is named, one holds nothing to report, or an evaluation's dataset was not given.
        MissingPackageError: matplotlib or jinja2 is not installed.
    """
    if not folders:
        raise EvaluationError("there is nothing to report: name at least one dataset, run or evaluation folder")
    out = Path(out)
    sources = read_sources([Path(folder) for folder in folders])
    labels = _labels(sources.evaluations)
    named = list(zip(sources.evaluations, labels, strict=True))
    case_count = 3 if len(named) <= _MANY else 1
    html = render(
        scores=[score_row(source, label) for source, label in named],
        comparison=_comparison(named),
        evaluations=[evaluation_section(source, label, case_count) for source, label in named],
        runs=[run_section(run) for run in sources.runs],
        datasets=[dataset_section(data) for data in sources.datasets.values()],
    )
    make_folder(out.parent)
    write_bytes(out, html.encode("utf-8"))
    return out


def _labels(evaluations: Sequence[EvaluationSource]) -> list[str]:
    """Name each evaluation by its method; where methods repeat, by as much of the folders as tells them apart."""
    methods = [source.scores.method for source in evaluations]
    if len(set(methods)) == len(methods):
        return methods
    parts = [source.folder.parts for source in evaluations]
    length = next(n for n in range(1, max(map(len, parts)) + 1) if len({part[-n:] for part in parts}) == len(parts))
    return [f"{method} ({'/'.join(part[-length:])})" for method, part in zip(methods, parts, strict=True)]


def _comparison(named: Sequence[tuple[EvaluationSource, str]]) -> list[tuple[str, str]]:
    if not named:
        return []
    tables = {label: source.scores.table for source, label in named}
    marks = sorted({k for source, _ in named for k in source.scores.settings["metrics"]["diameter_percent"]})
    drawings = [("Accuracy over threshold", charts.accuracy_chart(tables, marks))]
    dockable = {label: table for label, table in tables.items() if table.dockable.any()}
    if dockable:
        drawings.append(("Docking over the clearance to spare", charts.docking_chart(dockable)))
    return drawings


_GALLERY_FRAMES, _GALLERY_WIDTH = 7, 900


def dataset_section(data: DatasetReader) -> dict[str, Any]:
    """Describe a dataset and show frames from all over it, with ground-truth boxes and one depth image."""
    images = [image for split in data.splits for image in data.images(split)]
    shown = _spread([image for image in images if image.targets] or images, _GALLERY_FRAMES)
    frames = [
        {"uri": jpeg_uri(frame_with_boxes(data, image, _GALLERY_WIDTH)), "caption": _frame_caption(image)}
        for image in shown
    ]
    if shown:
        depth = jpeg_uri(depth_frame(data, shown[0], _GALLERY_WIDTH))
        frames.insert(1, {"uri": depth, "caption": "Depth of the first: near is warm, no reading is black"})
    manifest, targets = data.manifest, [target for image in images for target in image.targets]
    per_split = {
        split: f"{counted(len(data.splits[split]), 'scene')}, {counted(len(data.images(split)), 'image')}"
        for split in data.splits
    }
    facts = {
        **({} if manifest is None else {"Recipe": data.name, "Seed": manifest.seed}),
        **{split.capitalize(): text for split, text in per_split.items()},
        "Labelled objects": f"{len(targets):,}",
        **({} if manifest is None else _origin(manifest)),
    }
    return {
        "name": data.root.resolve().name,
        "description": "" if manifest is None else manifest.contents.description,
        "facts": facts,
        "frames": frames,
        "readings": _reading_rows(data, images),
        "recipe": "" if manifest is None else json.dumps(manifest.recipe, indent=2, ensure_ascii=False),
    }


def _reading_rows(data: DatasetReader, images: list[ImageRecord]) -> list[dict[str, str]]:
    """Describe what sensors gave that no format holds; nothing where there are none."""
    contents = {} if data.manifest is None else data.manifest.contents.readings
    return reading_rows(contents, (data.readings(image) for image in images)) if contents else []


def _origin(manifest: Manifest) -> dict[str, str]:
    """Say how a dataset of this package was made."""
    return {
        "Formats": ", ".join(manifest.formats),
        "Renderer": "; ".join(manifest.renderers),
        "Packages": ", ".join(f"{name} {version}" for name, version in manifest.packages.items()),
    }


def run_section(run: RunSource) -> dict[str, Any]:
    """Describe a training run with its curves."""
    return {
        "name": run.name,
        "estimator": run.config.get("estimator", "unnamed"),
        "facts": {name.replace("_", " ").capitalize(): value for name, value in run.result.items()},
        "charts": _training_charts(run.curves),
        "config": json.dumps(run.config, indent=2, ensure_ascii=False, default=str),
    }


def _training_charts(curves: list[dict[str, float]]) -> list[tuple[str, str]]:
    """Draw the training and validation columns, those of one unit (the last part of their names) together."""
    names = dict.fromkeys(name for row in curves for name in row if name.startswith(("train_", "val_")))
    by_unit: dict[str, list[str]] = {}
    for name in names:
        by_unit.setdefault(name.rsplit("_", 1)[-1], []).append(name)
    titles = {"loss": "Training loss", "percent": "Validation accuracy", "mm": "Validation error"}
    return [
        (titles.get(unit, unit.capitalize()), charts.training_chart(curves, columns, unit))
        for unit, columns in sorted(by_unit.items())
    ]


def _frame_caption(image: ImageRecord) -> str:
    return f"{image.split}, scene {image.scene_id}, image {image.image_id}: {counted(len(image.targets), 'object')}"


def _spread(images: list[ImageRecord], count: int) -> list[ImageRecord]:
    if not images:
        return []
    picks = np.unique(np.linspace(0, len(images) - 1, count).round().astype(int))
    return [images[index] for index in picks]


def reading_rows(
    contents: Mapping[str, ReadingContents], readings: Iterable[Mapping[str, MountedReading[Reading]]]
) -> list[dict[str, str]]:
    """Return a row for each channel of each sensor, with the range of all its values.

    Args:
        contents: Sensors by name, as the manifest has them.
        readings: What they gave at each observation, by the name of the sensor.
    """
    ranges: dict[tuple[str, str], tuple[float, float]] = {}
    for given in readings:
        for name, item in given.items():
            for channel, values in item.reading.channels.items():
                if values.size:
                    low, high = ranges.get((name, channel), (np.inf, -np.inf))
                    ranges[name, channel] = min(low, float(values.min())), max(high, float(values.max()))
    return [
        {
            "sensor": name,
            "kind": sensor.kind,
            "channel": channel,
            "shape": " x ".join("any" if length is None else str(length) for length in array.shape) or "one number",
            "type": np.dtype(array.dtype).name,
            "unit": array.unit or NOTHING,
            "range": "{:.4g} to {:.4g}".format(*ranges[name, channel]) if (name, channel) in ranges else NOTHING,
        }
        for name, sensor in contents.items()
        for channel, array in sensor.channels.items()
    ]


def render(**context: Any) -> str:
    """Return the page of some sections: scores, comparison, evaluations, runs, datasets."""
    return filled(__package__, "page.html.j2", **context)


_LOOK = "warehouse_sim.evaluation.report"


def filled(package: str, name: str, **context: Any) -> str:
    """Return a page; whatever it is filled with is escaped.

    Args:
        package: Package that the template lies in.
        name: File name of the template; it may include ``look.css.j2``.
        **context: What the template shows.

    Raises:
        MissingPackageError: jinja2 is not installed.
    """
    jinja2 = require("jinja2", "report", "to write a report")
    loader = jinja2.ChoiceLoader([jinja2.PackageLoader(place, "") for place in dict.fromkeys((package, _LOOK))])
    environment = jinja2.Environment(loader=loader, autoescape=True, trim_blocks=True, lstrip_blocks=True)
    return environment.get_template(name).render(**context)
