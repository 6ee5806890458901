"""Scores of detections: average precision of boxes and masks, panoptic quality of masks; misses count.

Ground truth that is hardly seen is not requested: what is found on it is neither right nor wrong, as on COCO's crowds.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Bool, Float

from warehouse_sim.dataset.reader import DatasetReader, ImageRecord, TargetRecord
from warehouse_sim.dataset.results.detections import FoundObject
from warehouse_sim.dataset.results.precision_recall import Matches, average_precision, match
from warehouse_sim.geometry.boxes import box_coverage, box_ious, mask_box_xyxy, mask_intersections

OVERLAPS = (0.5, 0.75)
_ALL_OVERLAPS = tuple(np.linspace(0.5, 0.95, 10).round(2).tolist())
"""Of COCO's mean."""
_MIN_SCORE = 0.5
"""Of detections that count for panoptic quality, which knows no scores."""


@dataclass(frozen=True)
class Evaluated:
    """Which true objects are to be found."""

    visible: float = 0.1
    """Least visible fraction, 0-1."""
    height_px: float = 8.0
    """Least height of the visible part (px)."""
    distance: tuple[float, float] = (0.0, 1e9)
    """From the camera (m), of objects with a pose."""
    measured: float = 0.0
    """Least fraction of the visible pixels that have a depth reading, 0-1."""

    def takes(self, target: TargetRecord) -> bool:
        """Return whether a true object is to be found."""
        _, top, _, bottom = target.box_visible_xyxy
        far = float(np.linalg.norm(target.T_camera_object[:3, 3])) if target.has_pose else self.distance[0]
        seen = target.visible_fraction >= self.visible and bottom - top + 1 >= self.height_px
        return seen and target.pixels_visible > 0 and self.distance[0] <= far < self.distance[1]


@dataclass(frozen=True)
class DetectionScore:
    """How well the objects of one class are found."""

    class_name: str
    wanted: int
    """How many were to be found."""
    precision: Mapping[str, float]
    """Average precision (0-1) by name: box_50, box_75, box, and where there are masks mask_50, mask_75, mask."""
    panoptic_quality: float | None = None
    """Of masks with a score of a half or more (Kirillov et al., CVPR 2019); None without masks."""


@dataclass(frozen=True, eq=False)
class Seen:
    """What was found and what was to be found of a class in one image."""

    scene_id: int
    scores: Float[np.ndarray, " n"]
    wanted: Bool[np.ndarray, " m"]
    boxes: Float[np.ndarray, "n m"]
    """Overlap of boxes."""
    masks: Float[np.ndarray, "n m"] | None = field(default=None)
    """Overlap of masks."""


def score_detections(
    found: Iterable[FoundObject],
    reader: DatasetReader,
    images: Sequence[ImageRecord],
    evaluated: Evaluated = Evaluated(),
) -> list[DetectionScore]:
    """Return the scores of each class that is to be found in some images, in alphabetical order.

    Args:
        found: Detections; those in other images do not count.
        reader: The dataset.
        images: Where to look.
        evaluated: Which true objects are to be found.
    """
    seen = seen_by_class(found, reader, images, evaluated)
    return [_score(name, parts) for name, parts in sorted(seen.items()) if wanted_in(parts)]


def seen_by_class(
    found: Iterable[FoundObject], reader: DatasetReader, images: Sequence[ImageRecord], evaluated: Evaluated
) -> dict[str, list[Seen]]:
    """Return what was found and to be found of each class, image by image; arguments as ``score_detections``."""
    by_image: dict[tuple[int, int], list[FoundObject]] = {}
    for item in found:
        by_image.setdefault((item.scene_id, item.image_id), []).append(item)
    of_model = model_classes(reader)
    seen: dict[str, list[Seen]] = {}
    for image in images:
        mine = by_image.get((image.scene_id, image.image_id), [])
        names = {reader.objects[target.obj_id].class_name for target in image.targets}
        labels = [item.class_name or of_model.get(item.model or 0, "") for item in mine]
        for name in names | {label for label in labels if label}:
            alike = [item for item, label in zip(mine, labels, strict=True) if label == name]
            seen.setdefault(name, []).append(_compare(alike, name, reader, image, evaluated))
    return seen


def _compare(
    found: Sequence[FoundObject], name: str, reader: DatasetReader, image: ImageRecord, evaluated: Evaluated
) -> Seen:
    targets = [
        item for item in image.targets if item.pixels_visible > 0 and reader.objects[item.obj_id].class_name == name
    ]
    wanted = np.array([evaluated.takes(item) for item in targets], dtype=bool)
    if evaluated.measured and wanted.any():
        readings = reader.depth(image) > 0
        wanted &= [readings[reader.mask_visible(image, item.gt_index)].mean() >= evaluated.measured for item in targets]
    gt = np.array([item.box_visible_xyxy for item in targets], dtype=float).reshape(-1, 4)
    gt[:, 2:] += 1.0
    boxes = np.array([edges_of(item) for item in found], dtype=float).reshape(-1, 4)
    overlap = np.where(wanted, box_ious(boxes, gt), box_coverage(boxes, gt))
    scores = np.array([item.score for item in found])
    if not found or any(item.mask is None for item in found):
        # Without detections, there may be masks or not: nothing is found of either kind.
        return Seen(image.scene_id, scores, wanted, overlap, None if found else overlap)
    shape = image.camera.height, image.camera.width
    masks = np.stack([np.asarray(item.mask, dtype=bool) for item in found])
    gt_masks = [reader.mask_visible(image, item.gt_index) for item in targets]
    other = np.stack(gt_masks) if gt_masks else np.zeros((0, *shape), dtype=bool)
    shared, size = mask_intersections(masks, other), masks.sum(axis=(1, 2))[:, None].astype(float)
    union = np.where(wanted, size + other.sum(axis=(1, 2)) - shared, size)
    return Seen(image.scene_id, scores, wanted, overlap, shared / np.maximum(union, 1.0))


def _score(name: str, parts: Sequence[Seen]) -> DetectionScore:
    precision = _precisions("box", [(item.scores, item.boxes, item.wanted) for item in parts])
    masked = [(item.scores, item.masks, item.wanted) for item in parts if item.masks is not None]
    quality = None
    if len(masked) == len(parts):
        precision |= _precisions("mask", masked)
        quality = _panoptic_quality(masked)
    return DetectionScore(name, wanted_in(parts), precision, quality)


def _precisions(kind: str, parts: Sequence[tuple[np.ndarray, np.ndarray, np.ndarray]]) -> dict[str, float]:
    values = {t: average_precision([_match(part, t) for part in parts]) for t in _ALL_OVERLAPS}
    found = {f"{kind}_{round(100 * t)}": values[t] for t in OVERLAPS}
    return found | {kind: float(np.mean(list(values.values())))}


def _match(part: tuple[np.ndarray, np.ndarray, np.ndarray], min_overlap: float) -> Matches:
    scores, overlap, wanted = part
    return match(scores, overlap, wanted, min_overlap)


def _panoptic_quality(parts: Sequence[tuple[np.ndarray, np.ndarray, np.ndarray]]) -> float:
    """Return sum of overlaps of matched masks / (matched + half of the others, found and true)."""
    total, matched, others = 0.0, 0, 0
    for scores, overlap, wanted in parts:
        kept = overlap[scores >= _MIN_SCORE]
        # Above a half, a match is the only one.
        pairs = (kept > 0.5) & wanted
        ignored = ((kept > 0.5) & ~wanted).any(axis=1) & ~pairs.any(axis=1)
        total += float(kept[pairs].sum())
        matched += int(pairs.sum())
        others += int(wanted.sum() - pairs.any(axis=0).sum()) + int((~pairs.any(axis=1) & ~ignored).sum())
    return total / (matched + others / 2) if matched + others else float("nan")


def wanted_in(parts: Sequence[Seen]) -> int:
    """Return how many objects were to be found."""
    return sum(int(item.wanted.sum()) for item in parts)


def model_classes(reader: DatasetReader) -> dict[int | str, str]:
    """Return the class of each object by its number and by its name."""
    return {key: info.class_name for number, info in reader.objects.items() for key in (number, info.name)}


def edges_of(item: FoundObject) -> tuple[float, float, float, float]:
    """Return the box of a detection, or of its mask: left, top, right and bottom edge (px)."""
    if item.edges is not None:
        return item.edges
    assert item.mask is not None
    left, top, right, bottom = mask_box_xyxy(item.mask) or (0, 0, -1, -1)
    return float(left), float(top), right + 1.0, bottom + 1.0


def precision_intervals(
    parts: Sequence[Seen], resamples: int, rng: np.random.Generator
) -> dict[str, tuple[float, float, float]]:
    """Return average precision (0-1) and the ends of its 95 % interval by name: box_50, box_75, mask_50, mask_75.

    Percentiles of a bootstrap over scenes (Cameron, Gelbach and Miller 2008: resample clusters, not rows). It has no
    width where every scene has the same score.

    Args:
        parts: Of one class, image by image.
        resamples: Bootstrap resamples.
        rng: Source of the resamples.
    """
    scenes = sorted({item.scene_id for item in parts})
    picks = rng.integers(len(scenes), size=(resamples, len(scenes)))
    kinds = ["box"] if any(item.masks is None for item in parts) else ["box", "mask"]
    found: dict[str, tuple[float, float, float]] = {}
    for kind in kinds:
        for overlap in OVERLAPS:
            pairs = [(item.boxes if kind == "box" else item.masks) for item in parts]
            matches = [
                match(item.scores, np.asarray(pair), item.wanted, overlap)
                for item, pair in zip(parts, pairs, strict=True)
            ]
            of_scene = [[m for m, item in zip(matches, parts, strict=True) if item.scene_id == s] for s in scenes]
            sampled = [average_precision([m for number in row for m in of_scene[number]]) for row in picks]
            low, high = np.nanpercentile(sampled, [2.5, 97.5])
            found[f"{kind}_{round(100 * overlap)}"] = average_precision(matches), float(low), float(high)
    return found
