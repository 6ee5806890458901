"""What the labels of a dataset count: classes, distances, visible fractions, sizes of boxes, light."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import cv2
import numpy as np
from jaxtyping import Bool, Float32

from warehouse_sim.dataset.card.tally import BINS, bin_names, count_in_bins, text_bars
from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.records import ImageRecord, TargetRecord
from warehouse_sim.dataset.stored.scene_record import read_scene_record
from warehouse_sim.errors import DatasetError

_FAR = 1000.0
"""Metres beyond which a pose or a size is probably in another unit."""
_BESIDE = 1.0
"""Widths of its box that an object's centre may lie beside it in the image."""
_FEW = 20
"""Readings of depth that a label needs to be compared with them."""
_EDGE_PX = 5
"""How near the edge of a mask readings may be of what stands before it: half the eleven pixels that the matching window
of a depth camera covers in an image of KITTI's focal length, by which near things grow over far ones."""
_OFF = 1.5
"""Diameters that a pose may lie before or behind what depth shows of the object."""


@dataclass
class Oddities:
    """Counts each kind of oddity and keeps where it came first."""

    found: dict[str, tuple[int, str]] = field(default_factory=dict)
    """What is odd -> how often, and where first."""

    def note(self, what: str, where: str) -> None:
        """Note one case."""
        count, first = self.found.get(what, (0, where))
        self.found[what] = count + 1, first

    def lines(self) -> list[str]:
        """Return a line for each kind, the most frequent first."""
        kinds = sorted(self.found.items(), key=lambda item: -item[1][0])
        return [f"{count:,} x {what}; first: {where}" for what, (count, where) in kinds]

    def of_image(self, image: ImageRecord) -> None:
        """Note what is odd about an image."""
        if not image.targets:
            self.note("images without a label", place_of(image))

    def of_target(self, image: ImageRecord, target: TargetRecord, objects: Mapping[int, ObjectInfo]) -> None:
        """Note what is odd about a label, from its numbers alone."""
        where = f"{place_of(image)}, label {target.gt_index}"
        if target.obj_id not in objects and target.geometry is None:
            self.note("labels of an object that the dataset does not list", where)
        left, top, right, bottom = target.box_visible_xyxy
        if right < left or bottom < top:
            self.note("labels with an empty box", where)
        elif right < 0 or bottom < 0 or left > image.camera.width or top > image.camera.height:
            self.note("labels with a box outside the image", where)
        if not 0.0 <= target.visible_fraction <= 1.0:
            self.note("labels whose visible fraction is not stated", where)
        self._pose(image, target, where)

    def of_depth(self, image: ImageRecord, depth: Float32[np.ndarray, "h w"]) -> None:
        """Note what is odd about a depth image (m)."""
        valid = depth[depth > 0]
        if not valid.size:
            self.note("depth images without a reading", place_of(image))
        elif not 0.05 < float(np.median(valid)) < 200.0:
            self.note(f"depth images of about {np.median(valid):.3g} m: is the unit right?", place_of(image))

    def of_reading(
        self,
        image: ImageRecord,
        target: TargetRecord,
        depth: Float32[np.ndarray, "h w"],
        visible: Bool[np.ndarray, "h w"],
        diameter: float,
    ) -> None:
        """Note a label whose pose is elsewhere than the depth (m, 0 = none) inside its visible mask says.

        Sensors read what is nearer over an edge, too, so that a label too small for pixels far from its edges has none
        that are its own.
        """
        inner = cv2.erode(visible.astype(np.uint8), np.ones((2 * _EDGE_PX + 1,) * 2, np.uint8)) > 0
        readings = depth[inner & (depth > 0)]
        if diameter <= 0.0 or readings.size < _FEW or not target.has_pose:
            return
        if abs(float(np.median(readings)) - float(target.T_camera_object[2, 3])) > _OFF * diameter:
            self.note("labels whose pose is not where the depth is", f"{place_of(image)}, label {target.gt_index}")

    def _pose(self, image: ImageRecord, target: TargetRecord, where: str) -> None:
        T = target.T_camera_object
        if not target.has_pose:
            self.note("labels without a pose", where)
            return
        if T[2, 3] <= 0:
            self.note("labels whose centre is behind the camera", where)
            return
        if np.linalg.norm(T[:3, 3]) > _FAR:
            self.note(f"labels more than {_FAR:g} m away: is the unit right?", where)
        u, v = image.camera.project(T[None, :3, 3])[0]
        left, top, right, bottom = target.box_amodal_xyxy
        reach = _BESIDE * max(right - left, bottom - top, 1.0)
        sides = ((u, left, right, image.camera.width), (v, top, bottom, image.camera.height))
        # KITTI's boxes end at the image's border, beyond which their objects go on.
        if not all(
            (low <= 0 or low - reach <= at) and (high >= size - 1 or at <= high + reach)
            for at, low, high, size in sides
        ):
            self.note("labels whose pose projects beside their box", where)


def place_of(image: ImageRecord) -> str:
    """Return how an image is named in messages and on sheets."""
    return f"{image.split} {image.scene_id}/{image.image_id}"


_BOX_EDGES = (0.0, 8.0, 16.0, 32.0, 64.0, 128.0, 256.0, 512.0, 1024.0)
_TITLES = {
    "visible_fraction": "visible fraction of labels",
    "distance": "distance from the camera to labels (m)",
    "lux": "illuminance on labels (lx)",
}


@dataclass
class Survey:
    """Counts over all images of a dataset."""

    images: dict[str, int] = field(default_factory=dict)
    """Split -> number of images."""
    scenes: dict[str, int] = field(default_factory=dict)
    sizes: Counter[tuple[int, int]] = field(default_factory=Counter)
    """Width and height (px) -> number of images."""
    classes: Counter[str] = field(default_factory=Counter)
    without_pose: int = 0
    """Masks of which neither pose nor object is known."""
    labels_an_image: list[int] = field(default_factory=list)
    values: dict[str, list[float]] = field(default_factory=lambda: {name: [] for name in (*_TITLES, "box")})
    """Visible fraction, distance (m), lux and larger edge of the visible box (px) of each label that has it."""

    def lines(self) -> list[str]:
        """Return the survey as text."""
        total = sum(self.images.values())
        lines = [f"{total:,} images, {sum(self.classes.values()):,} labels of {len(self.classes)} classes"]
        lines += [f"  {name}: {count:,} images in {self.scenes[name]:,} scenes" for name, count in self.images.items()]
        sizes = ", ".join(f"{width} x {height} ({count:,})" for (width, height), count in self.sizes.most_common(5))
        lines.append(f"size in pixels: {sizes}")
        if self.without_pose:
            lines.append(f"{self.without_pose:,} labels without a pose")
        if self.labels_an_image:
            least, most = min(self.labels_an_image), max(self.labels_an_image)
            lines.append(f"labels an image: {least} to {most}, mean {np.mean(self.labels_an_image):.1f}")
        lines += _titled("labels by class", dict(self.classes.most_common()))
        for name, title in _TITLES.items():
            names = bin_names(BINS[name], last_open=name != "visible_fraction")
            counts = count_in_bins(self.values[name], name)
            lines += _titled(title, dict(zip(names, counts, strict=True)))
        counts = np.histogram(np.clip(self.values["box"], 0, _BOX_EDGES[-1]), _BOX_EDGES)[0].tolist()
        return lines + _titled(
            "larger edge of the visible box (px)", dict(zip(bin_names(_BOX_EDGES), counts, strict=True))
        )


def survey(reader: DatasetReader, oddities: Oddities) -> Survey:
    """Count all labels of a dataset, and note what is odd about them; no image is decoded."""
    found = Survey()
    for split in reader.parts:
        images = reader.images(split)
        found.images[split], found.scenes[split] = len(images), len({image.scene_id for image in images})
        for image in images:
            found.sizes[image.camera.width, image.camera.height] += 1
            found.labels_an_image.append(len(image.targets))
            found.without_pose += sum(not target.has_pose for target in image.targets)
            oddities.of_image(image)
            for target in image.targets:
                _count(found, target, image, reader, oddities)
    found.values["lux"] = list(_lux(reader))
    return found


def distance_of(target: TargetRecord) -> float | None:
    """Return how far (m) a label's origin is from the camera; None where it has no pose."""
    return float(np.linalg.norm(target.T_camera_object[:3, 3])) if target.has_pose else None


def class_of(target: TargetRecord, objects: Mapping[int, ObjectInfo]) -> str:
    """Return the class of a label; its number where the dataset does not list its object."""
    try:
        return target.info(objects).class_name
    except KeyError:
        return f"object {target.obj_id}"


def _count(found: Survey, target: TargetRecord, image: ImageRecord, reader: DatasetReader, oddities: Oddities) -> None:
    found.classes[class_of(target, reader.objects)] += 1
    distance = distance_of(target)
    if distance is not None:
        found.values["distance"].append(distance)
    if 0.0 <= target.visible_fraction <= 1.0:
        found.values["visible_fraction"].append(target.visible_fraction)
    left, top, right, bottom = target.box_visible_xyxy
    found.values["box"].append(max(right - left, bottom - top) + 1.0)
    oddities.of_target(image, target, reader.objects)


def _lux(reader: DatasetReader) -> Iterator[float]:
    """Yield the light on each label that a scene record of this package tells."""
    if reader.manifest is None:
        return
    for index in reader.manifest.scene_indices:
        try:
            record = read_scene_record(reader.root, index, objects=False)
        except DatasetError:
            continue
        for observation in record.observations:
            yield from (item.illuminance for item in observation.targets if item.illuminance is not None)


def illuminances(reader: DatasetReader, images: Sequence[ImageRecord]) -> dict[tuple[int, int, int], float]:
    """Return the light (lx) on labels that a scene record tells, by scene, image and position among its labels."""
    found: dict[tuple[int, int, int], float] = {}
    if reader.manifest is None:
        return found
    for scene_id in dict.fromkeys(image.scene_id for image in images):
        seen = read_scene_record(reader.root, scene_id, objects=False).observations
        for image in (item for item in images if item.scene_id == scene_id and item.image_id < len(seen)):
            lux = {item.instance_id: item.illuminance for item in seen[image.image_id].targets}
            for target in image.targets:
                value = lux.get(target.instance_id)
                if value is not None:
                    found[scene_id, image.image_id, target.gt_index] = value
    return found


def _titled(title: str, counts: dict[str, int]) -> list[str]:
    if not any(counts.values()):
        return ["", f"{title}: not stated"]
    return ["", f"{title}:", *(f"  {line}" for line in text_bars(counts))]


def spread(items: Sequence[ImageRecord], count: int) -> list[ImageRecord]:
    """Return ``count`` of the items, evenly spread over all of them."""
    count = min(count, len(items))
    return [items[index * len(items) // count] for index in range(count)]
