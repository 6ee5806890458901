"""What a generated dataset came out as, in a few lines: counts, light and camera heights."""

from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.dataset.split import SPLITS
from warehouse_sim.dataset.stored.scene_record import SceneRecord, read_scene_record


def realised(root: Path, manifest: Manifest) -> list[str]:
    """Return lines on the scenes of a dataset, or of a shard of it, that stand in its folder.

    Heights are those of the cameras' origins above the floor (m), lux is the mean illuminance of the floor.

    Args:
        root: Folder of the dataset.
        manifest: What it is to be.

    Raises:
        DatasetError: A scene's record is malformed.
    """
    layout = DatasetLayout(root)
    found = [index for index in manifest.scene_indices if layout.scene_record(index).is_file()]
    records = [read_scene_record(root, index, objects=False) for index in found]
    seen = [observation for record in records for observation in record.observations]
    lux = [item.conditions.floor_lux for item in seen if item.conditions.floor_lux is not None]
    lines = [_counts(records), _objects(records)]
    if lux:
        lines.append(f"floor:   {_spread(lux, '.3g', 'lx')}")
    if seen:
        kinds = Counter(item.kind for item in seen if item.kind)
        named = ", ".join(f"{kind} {count}" for kind, count in kinds.most_common())
        heights = _spread([float(item.T_world_camera[2, 3]) for item in seen], ".2f", "m")
        lines.append(f"cameras: {heights} above the floor{f'; {named}' if named else ''}")
    return lines


def missing_test(manifest: Manifest) -> str | None:
    """Return a warning where the recipe wants scenes to test on and there is none, else None."""
    wanted = manifest.recipe.get("split", {}).get("test", 0.0)
    if manifest.splits["test"] or not wanted:
        return None
    warning = "warning: the split test is empty; use --split all in predict and evaluate"
    return warning if manifest.scenes > 1 else f"{warning}, or generate two scenes or more (--scenes 2)"


def _counts(records: Sequence[SceneRecord]) -> str:
    images = {name: sum(len(record.observations) for record in records if record.split == name) for name in SPLITS}
    splits = ", ".join(f"{name} {count:,}" for name, count in images.items())
    return f"scenes:  {len(records):,} with {sum(images.values()):,} observations ({splits})"


def _objects(records: Sequence[SceneRecord]) -> str:
    placed: Counter[str] = Counter()
    for record in records:
        for look, count in record.tally.looks.items():
            placed[look.class_name] += count.placed
    labels = sum(len(observation.targets) for record in records for observation in record.observations)
    most = ", ".join(f"{name} {count:,}" for name, count in placed.most_common(5))
    rest = len(placed) - 5
    more = f" and {rest} class{'es' if rest > 1 else ''} more" if rest > 0 else ""
    return f"objects: {placed.total():,} ({most}{more}); {labels:,} labels of targets"


def _spread(values: Iterable[float], form: str, unit: str) -> str:
    """Return least, median and most of some values, which are one where all are equal."""
    low, middle, high = np.quantile(list(values), (0.0, 0.5, 1.0)).tolist()
    if low == high:
        return f"{low:{form}} {unit}"
    return f"{low:{form}} to {high:{form}} {unit}, median {middle:{form}} {unit}"
