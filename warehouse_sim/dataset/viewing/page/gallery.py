"""Frames of datasets for the gallery of a page: which ones, and what the browser shows of each."""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from warehouse_sim.dataset.card.tally import BINS, bin_names
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.records import ImageRecord, TargetRecord
from warehouse_sim.dataset.viewing.page.arrays import depth_of, outline, picture_of, sweep_of
from warehouse_sim.dataset.viewing.panels import size_of
from warehouse_sim.dataset.viewing.survey import class_of, distance_of, illuminances, place_of
from warehouse_sim.geometry.boxes import box_corners, box_edges
from warehouse_sim.geometry.pose import Transform, invert, transform_points

FRAMES = 300
"""Frames on a page by default."""
_WORST = 100
"""Frames that each filter may bring, those in which it finds its worst object."""
_BUDGET = 11_500_000
"""Characters of a page that ``FRAMES`` frames may take together; a page of 15 MB also has a library of 2 MB."""
_PACKED = 3
"""How many characters of numbers and words become one on a page."""
_MOST_EACH = 90_000
_SEED = 0
_MOVED = 0.05
"""Metres that an object moves in its scene before its way is shown."""
_COLORS = ("#ff9600", "#33b5ff", "#ff5fa2", "#c58bff", "#ffe14d", "#4de3d0")


@dataclass(frozen=True, eq=False)
class Answer:
    """What a method says of a target."""

    T_camera_object: Transform | None
    """None for a miss."""
    failure: str
    """What is wrong with it, "missed" for a miss; "" where nothing is."""
    words: str
    """The errors, as a person reads them."""
    badness: float
    """Which is worse: larger is; infinite for a miss."""


Label = tuple[int, int, int]
"""Scene, image and place of the target among the image's labels."""


@dataclass(frozen=True, eq=False)
class Shown:
    """A dataset in the gallery."""

    reader: DatasetReader
    images: Sequence[ImageRecord]
    answers: Mapping[str, Mapping[Label, Answer]] = field(default_factory=dict)
    """By the name of the method."""

    def answer(self, method: str, image: ImageRecord, target: TargetRecord) -> Answer | None:
        """Return what a method says of a target that it was scored on."""
        return self.answers.get(method, {}).get((image.scene_id, image.image_id, target.gt_index))


def gallery(shown: Sequence[Shown], frames: int | None = FRAMES) -> dict[str, Any]:
    """Return what the template ``gallery`` and ``gallery.js`` take.

    Args:
        shown: Datasets with what methods say of them.
        frames: How many frames at most, those of several datasets together; None for all.

    Raises:
        DatasetError: A file of a dataset is missing or malformed.
    """
    methods = list(dict.fromkeys(name for item in shown for name in item.answers))
    counts = [len(item.images) for item in shown]
    most = _shares(counts, sum(counts) if frames is None else frames)
    budget = min(_MOST_EACH, _BUDGET // max(min(sum(most), FRAMES), 1))
    rows, words = [], []
    for item, count in zip(shown, most, strict=True):
        lux = illuminances(item.reader, item.images)
        chosen, how = choose(item, lux, count)
        words.append(f"{item.reader.root.resolve().name}: {how}" if len(shown) > 1 else how.capitalize())
        scenes = _by_scene(item)
        rows += [_frame(item, image, lux, scenes[image.scene_id], methods, budget) for image in chosen]
    return {
        "chosen": f"{'. '.join(words)}.",
        "methods": {name: _COLORS[number % len(_COLORS)] for number, name in enumerate(methods)},
        "edges": box_edges(),
        "frames": rows,
    }


def _shares(counts: Sequence[int], most: int) -> list[int]:
    """Return how many of each count are taken, ``most`` together: small ones as a whole, of the others equally many."""
    taken = [0] * len(counts)
    for place, index in enumerate(sorted(range(len(counts)), key=counts.__getitem__)):
        taken[index] = min(counts[index], (most - sum(taken)) // (len(counts) - place))
    return taken


def choose(shown: Shown, lux: Mapping[Label, float], most: int) -> tuple[list[ImageRecord], str]:
    """Choose frames, and say which: all of few; of many the worst by each filter, and a sample of the others.

    Args:
        shown: The dataset.
        lux: Illuminance (lx) of the targets that have one.
        most: How many frames may be chosen.
    """
    images = list(shown.images)
    if len(images) <= most:
        return images, f"all {len(images):,} frames are here"
    by = {name: _worst(images, measure) for name, measure in _measures(shown, lux).items()}
    each = min(_WORST, most * 4 // (5 * max(len(by), 1)))
    kept: dict[int, None] = {}
    for ranked in by.values():
        kept |= dict.fromkeys([index for index in ranked if index not in kept][:each])
    others = np.random.default_rng(_SEED).permutation([index for index in range(len(images)) if index not in kept])
    sample = others[: most - len(kept)].tolist()
    how = (
        f"{most:,} of {len(images):,} frames are here: up to {each} worst by each of {', '.join(by)}, "
        f"and {len(sample)} sampled from the others with seed {_SEED}"
    )
    return [images[index] for index in sorted([*kept, *sample])], how


def _measures(shown: Shown, lux: Mapping[Label, float]) -> dict[str, Callable[[ImageRecord], list[float]]]:
    """Return for each filter what gives the badness of an image's objects; a filter without values is left out."""
    rare: dict[str, int] = {}
    for image in shown.images:
        for target in image.targets:
            name = class_of(target, shown.reader.objects)
            rare[name] = rare.get(name, 0) + 1
    found: dict[str, Callable[[ImageRecord], list[float]]] = {
        "failure": lambda image: [
            answer.badness
            for method in shown.answers
            for target in image.targets
            if (answer := shown.answer(method, image, target)) is not None
        ],
        "distance": lambda image: [item for target in image.targets if (item := distance_of(target)) is not None],
        "visibility": lambda image: [
            -target.visible_fraction for target in image.targets if target.visible_fraction >= 0
        ],
        "light": lambda image: [-lux[label] for target in image.targets if (label := _label(image, target)) in lux],
        "class": lambda image: [-rare[class_of(target, shown.reader.objects)] for target in image.targets],
    }
    if len(rare) < 2:
        del found["class"]
    return {name: measure for name, measure in found.items() if any(measure(image) for image in shown.images)}


def _worst(images: Sequence[ImageRecord], measure: Callable[[ImageRecord], list[float]]) -> list[int]:
    """Return the indices of the images that have a value, the largest first."""
    worst = {index: max(values) for index, image in enumerate(images) if (values := measure(image))}
    return sorted(worst, key=lambda index: (-worst[index], index))


def _label(image: ImageRecord, target: TargetRecord) -> Label:
    return image.scene_id, image.image_id, target.gt_index


def _by_scene(shown: Shown) -> dict[int, list[ImageRecord]]:
    """Return the images of each scene."""
    found: dict[int, list[ImageRecord]] = {}
    for image in shown.images:
        found.setdefault(image.scene_id, []).append(image)
    return found


def _frame(
    shown: Shown,
    image: ImageRecord,
    lux: Mapping[Label, float],
    scene: Sequence[ImageRecord],
    methods: Sequence[str],
    budget: int,
) -> dict[str, Any]:
    """Return what is shown of an image."""
    reader = shown.reader
    objects = [
        _object(shown, image, target, lux.get(_label(image, target)), scene, methods) for target in image.targets
    ]
    depth, sweep = depth_of(reader, image, budget), sweep_of(reader, image)
    way = [invert(image.T_world_camera) @ item.T_world_camera for item in scene]
    moved = max(np.linalg.norm(T[:3, 3]) for T in way) > _MOVED
    kept = budget - len(json.dumps([depth, sweep])) - len(json.dumps(objects)) // _PACKED
    return {
        "name": place_of(image),
        "data": reader.root.resolve().name,
        "size": [image.camera.width, image.camera.height],
        "picture": picture_of(reader, image, kept),
        "depth": depth,
        "sweep": sweep,
        "way": _points([T[:3, 3] for T in way]) if moved else [],
        "badness": max((row["badness"] for row in objects), default=0.0),
        "objects": objects,
    }


def _object(
    shown: Shown,
    image: ImageRecord,
    target: TargetRecord,
    lux: float | None,
    scene: Sequence[ImageRecord],
    methods: Sequence[str],
) -> dict[str, Any]:
    """Return what is shown of a target: its tags, by which filters find it, outlines, corners and answers."""
    distance, visible = distance_of(target), target.visible_fraction
    known = {
        "distance": (distance, "distance", " m"),
        "visibility": (visible if visible >= 0 else None, "visible_fraction", ""),
        "light": (lux, "lux", " lx"),
    }
    size = size_of(shown.reader.objects, target)
    given = {name: answer for name in methods if (answer := shown.answer(name, image, target)) is not None}
    badness = [min(answer.badness, 1e9) for answer in given.values()]
    return {
        "tags": {
            "class": class_of(target, shown.reader.objects),
            **{name: f"{_bin(value, bins)}{unit}" for name, (value, bins, unit) in known.items() if value is not None},
        },
        "values": [_rounded(value) for value, _, _ in known.values()],
        **_drawn(image, target, target.T_camera_object if target.has_pose else None, size),
        "way": _trail(image, target, scene),
        "answers": {
            name: {
                "failure": answer.failure or "right",
                "words": answer.words,
                **_drawn(image, None, answer.T_camera_object, size),
            }
            for name, answer in given.items()
        },
        "badness": max(badness, default=0.0),
    }


def _drawn(
    image: ImageRecord, target: TargetRecord | None, T: Transform | None, size: np.ndarray | None
) -> dict[str, Any]:
    """Return the outline (px) and the corners (m) of a box in space; of a target without, its box in the image."""
    if T is None or size is None:
        return {"path": "" if target is None else _rectangle(target), "corners": []}
    corners = transform_points(T, box_corners(size))
    return {"path": outline(image.camera, corners), "corners": _points(corners)}


def _rectangle(target: TargetRecord) -> str:
    left, top, right, bottom = (round(value, 1) for value in target.box_visible_xyxy)
    return f"M{left} {top}H{right}V{bottom}H{left}Z"


def _trail(image: ImageRecord, target: TargetRecord, scene: Sequence[ImageRecord]) -> list[list[float]]:
    """Return where a moving object is in the images of its scene, in the frame of this camera; none if it stands."""
    if not target.instance_id or not target.has_pose:
        return []
    T_camera_world = invert(image.T_world_camera)
    places = [
        (T_camera_world @ other.T_world_camera @ same.T_camera_object)[:3, 3]
        for other in scene
        for same in other.targets
        if same.instance_id == target.instance_id and same.has_pose
    ]
    moved = max(np.linalg.norm(place - places[0]) for place in places) > _MOVED
    return _points(places) if moved else []


def _bin(value: float, name: str) -> str:
    names = bin_names(BINS[name], last_open=name != "visible_fraction")
    return " ".join(names[min(max(int(np.searchsorted(BINS[name], value, "right")) - 1, 0), len(names) - 1)].split())


def _points(points: Sequence[np.ndarray] | np.ndarray) -> list[list[float]]:
    return np.round(np.asarray(points, float), 3).tolist()


def _rounded(value: float | None) -> float | None:
    return None if value is None else float(f"{value:.3g}")
