"""Write one self-contained page of what was made, trained and scored; its sections on datasets and runs are here."""

import json
import shlex
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.dataset.reader import DatasetReader, ImageRecord
from warehouse_sim.dataset.stored.contents import ReadingContents
from warehouse_sim.dataset.viewing.page.gallery import FRAMES, Shown, gallery
from warehouse_sim.dataset.viewing.page.template import Chart, filled
from warehouse_sim.errors import EvaluationError
from warehouse_sim.evaluation.report import charts
from warehouse_sim.evaluation.report.answers import answers_of
from warehouse_sim.evaluation.report.numbers import NOTHING, counted
from warehouse_sim.evaluation.report.score_sections import evaluation_section, score_row
from warehouse_sim.evaluation.report.sources import EvaluationSource, RunSource, Sources, read_sources
from warehouse_sim.output import make_folder, write_bytes
from warehouse_sim.schema import MountedReading, Reading

_MANY = 3
"""From more evaluations than this on, each shows one case a group, to keep the page small."""


def write_report(folders: Sequence[str | Path], out: str | Path, frames: int | None = FRAMES) -> Path:
    """Write one HTML page about dataset, run and evaluation folders; it needs no other file and no network.

    Args:
        folders: The folders, or folders that hold them; an evaluation needs its dataset among them.
        out: The page to write.
        frames: How many frames the gallery has at most, those of all datasets together; None for all.

    Returns:
        ``out``.

    Raises:
        EvaluationError: No folder is named, one holds nothing to report, or an evaluation's dataset was not given.
        DatasetError: A dataset that is named cannot be read.
        MissingPackageError: plotly or jinja2 is not installed.
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
        frames=gallery(_shown(sources, named), frames),
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


def _shown(sources: Sources, named: Sequence[tuple[EvaluationSource, str]]) -> list[Shown]:
    """Return the datasets with what methods say of them; of one that was scored, the splits that were."""
    shown = []
    for data in sources.datasets.values():
        mine = [(source, label) for source, label in named if source.data is data]
        splits = dict.fromkeys(source.scores.dataset["split"] for source, _ in mine) or data.parts
        images = {(item.split, item.scene_id, item.image_id): item for name in splits for item in data.images(name)}
        answers = {label: answers_of(source.scores) for source, label in mine}
        shown.append(Shown(data, list(images.values()), answers))
    return shown


def _comparison(named: Sequence[tuple[EvaluationSource, str]]) -> list[tuple[str, Chart]]:
    if not named:
        return []
    tables = {label: source.scores.table for source, label in named}
    marks = sorted({k for source, _ in named for k in source.scores.settings["metrics"]["diameter_percent"]})
    drawings = [("Accuracy over threshold", charts.accuracy_chart(tables, marks))]
    dockable = {label: table for label, table in tables.items() if table.dockable.any()}
    if dockable:
        drawings.append(("Docking over the clearance to spare", charts.docking_chart(dockable)))
    return drawings


def dataset_section(data: DatasetReader) -> dict[str, Any]:
    """Describe a dataset."""
    images = [image for split in data.parts for image in data.images(split)]
    manifest, targets = data.manifest, [target for image in images for target in image.targets]
    per_split = {
        split: f"{counted(len(data.splits[split]), 'scene')}, {counted(len(data.images(split)), 'image')}"
        for split in data.parts
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
        "readings": _reading_rows(data, images),
        "command": "" if manifest is None or manifest.converted_from else _generate_command(data, manifest),
        "recipe": "" if manifest is None else json.dumps(manifest.recipe, indent=2, ensure_ascii=False),
    }


def _generate_command(data: DatasetReader, manifest: Manifest) -> str:
    """Return what makes a dataset again from its resolved recipe, which the page has as a file."""
    backend = [] if manifest.backend in ("", "raster") else ["--backend", manifest.backend]
    options = [f"{name}={value}" for name, value in manifest.backend_options.items()]
    words = ["warehouse-sim", "generate", "recipe.yaml", "--seed", str(manifest.seed), "--scenes", str(manifest.scenes)]
    words += ["--formats", *manifest.formats, *backend, *(["--backend-options", *options] if options else [])]
    return shlex.join([*words, "--out", data.root.resolve().name])


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


def _training_charts(curves: list[dict[str, float]]) -> list[tuple[str, Chart]]:
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
    """Return the page of some sections: scores, comparison, evaluations, runs, frames, datasets."""
    return filled(__package__, "report.html.j2", title="warehouse-sim report", **context)
