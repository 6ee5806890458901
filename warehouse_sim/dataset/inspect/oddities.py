"""What a person who looks at a third-party dataset should know: not errors, but what may surprise."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float32

from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.dataset.records import ImageRecord, TargetRecord

_FAR = 1000.0
"""Metres beyond which a pose or a size is probably in another unit."""
_BESIDE = 1.0
"""Widths of its box that an object's centre may lie beside it in the image."""
_FEW = 20
"""Readings of depth that a label needs to be compared with them."""
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
        self, image: ImageRecord, target: TargetRecord, shown: Float32[np.ndarray, " n"], diameter: float
    ) -> None:
        """Note a label whose pose is elsewhere than the depth (m) on its visible pixels, 0 = none, says."""
        readings = shown[shown > 0]
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
        if not (left - reach <= u <= right + reach and top - reach <= v <= bottom + reach):
            self.note("labels whose pose projects beside their box", where)


def place_of(image: ImageRecord) -> str:
    """Return how an image is named in messages and on sheets."""
    return f"{image.split} {image.scene_id}/{image.image_id}"
