"""Average precision as KITTI's object benchmark counts it: boxes in the image, on the ground, in space, and their turn.

Geiger, Lenz and Urtasun, CVPR 2012, and the rules of its development kit: recall is sampled at up to 41 scores, and the
precision at a recall is the best at that or a higher one. Fewer than 41 objects leave samples empty, which count as
nought: of n < 41 perfectly found objects AP is about n / 40.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from jaxtyping import Bool, Float, Int

from warehouse_sim.dataset.files.json_file import write_json
from warehouse_sim.dataset.files.plain import decimal
from warehouse_sim.dataset.formats.kitti import KittiLayout, kitti_layout
from warehouse_sim.dataset.formats.kitti.external import external_folder, frames_by_split
from warehouse_sim.dataset.formats.kitti.tolerant import read_labels, read_text
from warehouse_sim.dataset.reader import ALL
from warehouse_sim.dataset.split import SPLITS
from warehouse_sim.errors import EvaluationError
from warehouse_sim.evaluation.detection.kitti_overlap import KittiObjects, fraction_in, overlaps
from warehouse_sim.output import make_folder

View = Literal["image", "ground", "space"]
VIEWS: tuple[View, ...] = ("image", "ground", "space")
LEVELS = ("easy", "moderate", "hard")
_LEAST_HEIGHT_PX, _MOST_OCCLUDED, _MOST_TRUNCATED = (40.0, 25.0, 25.0), (0, 1, 2), (0.15, 0.3, 0.5)
_STEPS = 40
ENOUGH = _STEPS + 1
"""Objects of a class and level from which AP can reach 1."""
_NEIGHBOURS = {"car": "van", "pedestrian": "person_sitting"}
"""What is so much alike that finding it is no fault."""


@dataclass(frozen=True)
class KittiScore:
    """Of one class, level of difficulty and view; shares 0-1."""

    class_name: str
    level: str
    view: View
    wanted: int
    """Objects that are to be found; see ``ENOUGH``."""
    ap_40: float
    """Mean precision at recalls of 1/40, 2/40 ... 1 (the benchmark's since 2019)."""
    ap_11: float
    """The same at 0, 0.1 ... 1 (before)."""
    aos_40: float | None
    """With each right detection counted by (1 + cos of its error in alpha) / 2; of the image only."""
    aos_11: float | None
    """The same at 0, 0.1 ... 1."""


def kitti_scores(
    gt: Sequence[KittiObjects], found: Sequence[KittiObjects], min_overlap: Mapping[str, float]
) -> list[KittiScore]:
    """Score detections of some images; those with nothing to be found are left out.

    Args:
        gt: Labels of each image, with "DontCare" regions among them.
        found: Detections of each.
        min_overlap: Overlap that a detection must exceed, by class: KITTI requires 0.7 of cars and 0.5 of others.
    """
    rows = []
    for class_name, least in min_overlap.items():
        for view in VIEWS:
            shared = [overlaps(view, b, a) for a, b in zip(gt, found, strict=True)]
            stuff = [fraction_in(view, b, a.only(a.is_dont_care)) for a, b in zip(gt, found, strict=True)]
            for level in range(len(LEVELS)):
                images = [
                    _Image.of(class_name, level, a, b, over, dont_care, least)
                    for a, b, over, dont_care in zip(gt, found, shared, stuff, strict=True)
                ]
                wanted = sum(int((image.role == 1).sum()) for image in images)
                if wanted:
                    precision, orientation = _curves(images, wanted)
                    aos = _means(orientation) if view == "image" else (None, None)
                    rows.append(KittiScore(class_name, LEVELS[level], view, wanted, *_means(precision), *aos))
    return rows


@dataclass(frozen=True, eq=False)
class _Image:
    """Of one image, class and level: what counts, and what overlaps by more than is evaluated."""

    role: Int[np.ndarray, " g"]
    """Of the ground truth: 1 is to be found, 0 may be found, -1 is another class."""
    counts: Int[np.ndarray, " d"]
    """Of the detections: 1 counts, 0 is too low to count, -1 is another class."""
    score: Float[np.ndarray, " d"]
    overlap: Float[np.ndarray, "d g"]
    """0 where it is no more than is evaluated."""
    on_stuff: Bool[np.ndarray, " d"]
    """Whether a detection lies on a region that nobody labelled."""
    alpha: tuple[Float[np.ndarray, " g"], Float[np.ndarray, " d"]]
    """Of ground truth and detections (rad)."""

    @classmethod
    def of(
        cls,
        class_name: str,
        level: int,
        gt: KittiObjects,
        found: KittiObjects,
        shared: Float[np.ndarray, "d g"],
        stuff: Float[np.ndarray, "d s"],
        least: float,
    ) -> "_Image":
        """Decide what counts."""
        height = gt.box_xyxy[:, 3] - gt.box_xyxy[:, 1]
        fits = (
            (gt.occluded <= _MOST_OCCLUDED[level])
            & (gt.truncated <= _MOST_TRUNCATED[level])
            & (height >= _LEAST_HEIGHT_PX[level])
        )
        named = np.char.lower(gt.type) if len(gt) else gt.type
        mine, alike = named == class_name.lower(), named == _NEIGHBOURS.get(class_name.lower(), "")
        # Whole pixels, as the development kit has it.
        low = np.trunc(np.abs(found.box_xyxy[:, 3] - found.box_xyxy[:, 1])) < _LEAST_HEIGHT_PX[level]
        own = np.char.lower(found.type) == class_name.lower() if len(found) else np.zeros(0, dtype=bool)
        return cls(
            role=np.where(mine & fits, 1, np.where(mine | alike, 0, -1)),
            counts=np.where(low, 0, np.where(own, 1, -1)),
            score=found.score,
            overlap=np.where(shared > least, shared, 0.0),
            on_stuff=np.any(stuff > least, axis=1),
            alpha=(gt.alpha, found.alpha),
        )


def _curves(images: Sequence[_Image], wanted: int) -> tuple[Float[np.ndarray, " s"], Float[np.ndarray, " s"]]:
    """Return precision and orientation similarity at the sampled recalls, nought beyond the last."""
    precision, orientation = np.zeros((2, ENOUGH))
    for step, least in enumerate(_sampled_scores(np.concatenate([_right_scores(image) for image in images]), wanted)):
        right, wrong, alike = np.sum([_count(image, least) for image in images], axis=0)
        precision[step], orientation[step] = np.array([right, alike]) / max(right + wrong, 1)
    return np.maximum.accumulate(precision[::-1])[::-1], np.maximum.accumulate(orientation[::-1])[::-1]


def _means(curve: Float[np.ndarray, " s"]) -> tuple[float, float]:
    return float(curve[1:].mean()), float(curve[::4].mean())


def _sampled_scores(scores: Float[np.ndarray, " n"], wanted: int) -> list[float]:
    """Return the scores at which the recall comes nearest to 0, 1/40, 2/40 ..."""
    ordered, recall, chosen = np.sort(scores)[::-1], 0.0, []
    for place, score in enumerate(ordered.tolist()):
        last = place == len(ordered) - 1
        before, after = (place + 1) / wanted, (place + (1 if last else 2)) / wanted
        if not last and after - recall < recall - before:
            continue
        chosen.append(score)
        recall += 1.0 / _STEPS
    return chosen[:ENOUGH]


def _right_scores(image: _Image) -> Float[np.ndarray, " k"]:
    """Return the scores of what is right when every detection is kept: of each ground truth the surest that is free."""
    free, right = image.counts >= 0, []
    for gt in np.flatnonzero(image.role >= 0):
        open_ones = np.flatnonzero(free & (image.overlap[:, gt] > 0.0))
        if len(open_ones) == 0:
            continue
        best = open_ones[np.argmax(image.score[open_ones])]
        free[best] = False
        if image.role[gt] == 1 and image.counts[best] == 1:
            right.append(image.score[best])
    return np.array(right, dtype=float)


def _count(image: _Image, min_score: float) -> tuple[float, float, float]:
    """Return how many detections of at least a score are right and wrong, and how well the right ones are turned."""
    kept = image.score >= min_score
    free, right, alike = (image.counts >= 0) & kept, 0, 0.0
    for gt in np.flatnonzero(image.role >= 0):
        over = np.where(free, image.overlap[:, gt], 0.0)
        of_use = np.where(image.counts == 1, over, 0.0)
        if not over.any():
            continue
        # What is too low to count is taken only where nothing else overlaps.
        best = int(of_use.argmax()) if of_use.any() else int(np.flatnonzero(over)[0])
        free[best] = False
        if image.role[gt] == 1 and image.counts[best] == 1:
            right += 1
            alike += (1.0 + np.cos(image.alpha[0][gt] - image.alpha[1][best])) / 2.0
    return right, int((free & (image.counts == 1) & ~image.on_stuff).sum()), alike


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
    if listed or external_folder(layout.root) is None:
        frames = {frame: part for part in parts for frame in _frames(layout, part)}
    else:  # Without lists, the reader's own splits.
        own = frames_by_split(layout.root)
        frames = {frame.number: part for part in (own if split == ALL else parts) for frame in own.get(part, ())}
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
    unlisted = KittiLayout(external_folder(data) or layouts[0].root)
    return next((one for one in layouts if any(one.image_set(name).is_file() for name in names)), unlisted)


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
