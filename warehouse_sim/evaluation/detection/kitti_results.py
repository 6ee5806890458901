"""From a folder of KITTI result files to average precision: who has a detector of boxes needs no pose CSV."""

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from warehouse_sim.dataset.files.json_file import write_json
from warehouse_sim.dataset.files.plain import decimal
from warehouse_sim.dataset.formats.kitti.layout import KittiLayout, kitti_layout
from warehouse_sim.dataset.formats.kitti.tolerant import read_labels, read_text
from warehouse_sim.dataset.reader import ALL
from warehouse_sim.dataset.split import SPLITS
from warehouse_sim.errors import EvaluationError
from warehouse_sim.evaluation.detection.kitti_ap import ENOUGH, KittiScore, kitti_scores
from warehouse_sim.evaluation.detection.kitti_overlap import KittiObjects
from warehouse_sim.output import make_folder

KITTI_SCORES_FILE = "kitti_scores.json"
_FORMAT = 1
_OVERLAPS = {"car": 0.7}
_OVERLAP = 0.5
"""Of all classes but cars, as in KITTI."""


def evaluate_kitti_results(results: Path, data: Path, split: str) -> list[KittiScore]:
    """Score the result files of the frames of a split, ``000000.txt`` ..., 16 fields a row; no file is no detection.

    Args:
        results: Folder of the files.
        data: A dataset with KITTI files, or a folder as KITTI's own.
        split: "train", "val" or "test", or "all" of those that there are.

    Raises:
        EvaluationError: A file is of no frame of the split, a row has no score, or there is nothing to be found.
        DatasetError: A file cannot be read.
    """
    layout = _layout(data, split)
    listed = [name for name in SPLITS if layout.image_set(name).is_file()]
    parts = listed if split == ALL and listed else [split]
    frames = {frame: part for part in parts for frame in _frames(layout, part)}
    lists = " and ".join(str(layout.image_set(part)) for part in parts)
    paths = sorted(results.glob("*.txt"))
    if not paths:
        raise EvaluationError(f"{results}: holds no file of results, 000000.txt ...; a pose CSV is a file, no folder")
    for path in paths:
        if not path.stem.isdecimal() or int(path.stem) not in frames:
            raise EvaluationError(f"{path}: is of no frame of split {split!r}, see {lists}; check --split")
    gt = [_objects(layout.file(part, "label_2", frame), scored=False) for frame, part in frames.items()]
    found = [_objects(results / f"{frame:06d}.txt", scored=True) for frame in frames]
    names = sorted({name for objects in gt for name in objects.type[~objects.is_dont_care].tolist()})
    scores = kitti_scores(gt, found, {name: _OVERLAPS.get(name.lower(), _OVERLAP) for name in names})
    if not scores:
        raise EvaluationError(f"{layout.root}: split {split!r} has nothing that KITTI's levels require; take another")
    return scores


def write_kitti_scores(scores: Sequence[KittiScore], folder: Path) -> Path:
    """Write ``kitti_scores.json`` and return its path."""
    make_folder(folder)
    data: dict[str, Any] = {"format": _FORMAT, "enough": ENOUGH, "scores": [asdict(score) for score in scores]}
    write_json(folder / KITTI_SCORES_FILE, data, depth=2)
    return folder / KITTI_SCORES_FILE


def kitti_lines(scores: Sequence[KittiScore]) -> list[str]:
    """Return a table that a person can read, shares in percent."""
    lines = [f"{'class':<16} {'level':<9} {'view':<6} {'wanted':>6} {'AP R40':>7} {'AP R11':>7} {'AOS R40':>8}"]
    for row in scores:
        turn = "-" if row.aos_40 is None else f"{100 * row.aos_40:.2f}"
        few = "" if row.wanted >= ENOUGH else f"  at most {100 * (row.wanted - 1) / (ENOUGH - 1):.1f}: few objects"
        lines.append(
            f"{row.class_name:<16} {row.level:<9} {row.view:<6} {row.wanted:>6} {100 * row.ap_40:>7.2f} "
            f"{100 * row.ap_11:>7.2f} {turn:>8}{few}"
        )
    return lines


def _layout(data: Path, split: str) -> KittiLayout:
    """Return where the KITTI files lie that have the split: in a dataset of this package, or as KITTI's own."""
    names = SPLITS if split == ALL else (split,)
    layouts = kitti_layout(data), KittiLayout(data)
    return next((one for one in layouts if any(one.image_set(name).is_file() for name in names)), layouts[0])


def _frames(layout: KittiLayout, split: str) -> list[int]:
    path = layout.image_set(split)
    words = read_text(path).split()
    if not all(word.isdecimal() for word in words):
        raise EvaluationError(f"{path}: must hold numbers of frames; generate with --formats kitti")
    return [int(word) for word in words]


def _objects(path: Path, scored: bool) -> KittiObjects:
    if scored and not path.is_file():
        return KittiObjects.of([])
    text = read_text(path)
    rows, scores = [line.split() for line in text.splitlines() if line.split()], []
    for number, words in enumerate(rows if scored else [], start=1):
        try:
            scores.append(decimal(words[15]))
        except (IndexError, ValueError):
            raise EvaluationError(f"{path}: row {number}: needs a score as its sixteenth field") from None
    return KittiObjects.of(read_labels(text, str(path)), scores)
