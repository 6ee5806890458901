"""What the page shows of each dataset and training run, ready for the template."""

import json
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.dataset.reader import DatasetReader, ImageRecord
from warehouse_sim.dataset.stored.contents import ReadingContents
from warehouse_sim.evaluation.report import charts
from warehouse_sim.evaluation.report.images import depth_frame, frame_with_boxes, jpeg_uri
from warehouse_sim.evaluation.report.numbers import NOTHING, counted
from warehouse_sim.evaluation.report.sources import RunSource
from warehouse_sim.schema import MountedReading, Reading

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
