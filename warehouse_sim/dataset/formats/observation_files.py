"""What the formats have in common of one observation: who is labelled, and the files that they share."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Bool, Int32

from warehouse_sim.dataset.files.image_io import (
    encode_clean_depth,
    encode_depth,
    encode_mask,
    encode_rgb,
    farthest_depth,
)
from warehouse_sim.dataset.files.run_lengths import run_lengths
from warehouse_sim.dataset.stored.contents import Contents
from warehouse_sim.errors import DatasetError
from warehouse_sim.output import hard_link, write_bytes
from warehouse_sim.schema import ObjectAnnotation, Observation


def require_depth_fits(contents: Contents, steps_per_metre: float, name: str) -> None:
    """Reject a depth camera that reads farther than 16 bits can say.

    Args:
        contents: Of the dataset.
        steps_per_metre: Of the format's depth images.
        name: The format's, as in ``--formats``.

    Raises:
        DatasetError: A largest range, the rig's own or a paired variant's, is beyond the format's.
    """
    limit = farthest_depth(steps_per_metre)
    for setting, largest in contents.depth_ranges.items():
        if largest > limit:
            raise DatasetError(
                f"{name.upper()}: {setting}.max_range is {largest:g} m, but depth in 16 bits ends at "
                f"{limit:.3f} m; lower it, or leave {name} out of --formats"
            )


VISIBLE_ENOUGH = 0.1
"""Visible fraction from which BOP requires a target; what shows less is a region to ignore, in COCO too."""
MILLIMETRES = 1000.0
"""Steps of a metre in depth images of millimetres."""


@dataclass
class SharedFile:
    """Content that several formats store: encoded once, written once, then given more names."""

    data: bytes
    stored_at: Path | None = None
    """A file that holds the content already; the first one that is saved, where there was none."""

    def save(self, path: Path) -> None:
        """Put the content at ``path``."""
        if self.stored_at is None:
            write_bytes(path, self.data)
            self.stored_at = path
        else:
            hard_link(self.stored_at, path, self.data)


@dataclass(frozen=True, eq=False)
class LabelledTarget:
    """A target that is written, with its masks in the image."""

    annotation: ObjectAnnotation
    mask: Bool[np.ndarray, "h w"]
    """The part of the whole amodal mask that lies in the image."""
    mask_visible: Bool[np.ndarray, "h w"]

    @property
    def box_visible_xyxy(self) -> tuple[int, int, int, int]:
        """The box of the visible pixels; every labelled target has some."""
        box = self.annotation.box_visible_xyxy
        assert box is not None
        return box

    @cached_property
    def mask_png(self) -> SharedFile:
        """The amodal mask as PNG, 255 where it is."""
        return SharedFile(encode_mask(self.mask))

    @cached_property
    def mask_visible_png(self) -> SharedFile:
        """The visible pixels as PNG, 255 where they are."""
        return SharedFile(encode_mask(self.mask_visible))

    @cached_property
    def runs(self) -> dict[str, Any]:
        """The amodal mask as COCO's run lengths."""
        return run_lengths(self.mask)

    @cached_property
    def runs_visible(self) -> dict[str, Any]:
        """The visible pixels as COCO's run lengths."""
        return run_lengths(self.mask_visible)


@dataclass(frozen=True, eq=False)
class ObservationFiles:
    """One observation on its way to disk, handed to every writer in turn."""

    observation: Observation
    stored_rgb: Path | None = None
    """A PNG file that holds the colour image already; None where it is yet to be encoded."""

    @cached_property
    def rgb(self) -> SharedFile:
        """The colour image as PNG."""
        if self.stored_rgb is not None:
            return SharedFile(self.stored_rgb.read_bytes(), self.stored_rgb)
        return SharedFile(encode_rgb(self.observation.rgbd.rgb))

    @cached_property
    def depth_mm(self) -> SharedFile:
        """The depth that was read as 16-bit PNG, a millimetre a step.

        Raises:
            DatasetError: A depth does not fit.
        """
        item = self.observation
        where = f"depth in millimetres, scene {item.scene_index}, observation {item.observation_index}"
        return SharedFile(encode_depth(item.rgbd.depth, MILLIMETRES, where))

    @cached_property
    def depth_clean_mm(self) -> SharedFile:
        """The depth as it was drawn, a millimetre a step; 0 also where it does not fit into 16 bits."""
        return SharedFile(encode_clean_depth(self.observation.buffers.depth, MILLIMETRES))

    @cached_property
    def levelled(self) -> "ObservationFiles":
        """The same moment as a level camera sees it, for formats that know no other; itself where there is none."""
        return self if self.observation.level is None else ObservationFiles(self.observation.level)

    @cached_property
    def rgb_clean(self) -> SharedFile:
        """The colour image as it was drawn, as PNG."""
        return SharedFile(encode_rgb(self.observation.buffers.rgb))

    @cached_property
    def targets(self) -> tuple[LabelledTarget, ...]:
        """The labelled targets: every target of which at least one pixel is visible, in order of instance id.

        All formats follow this one rule and this one order, so that the row of a KITTI label, the BOP gt index and the
        mask number of an object agree.
        """
        ids = self.observation.buffers.instance_mask
        return tuple(
            LabelledTarget(annotation, image_amodal_mask(annotation, ids.shape), visible_mask(annotation, ids))
            for annotation in self.observation.annotations
            if annotation.pixels_visible > 0
        )


def box_xywh(box_xyxy: tuple[float, float, float, float], extra: int) -> list[float]:
    """Return left, top, width and height (px) of inclusive corners; whole numbers stay whole.

    Args:
        box_xyxy: The corners.
        extra: What width and height count beyond the difference of corners: 1 in COCO, 0 in BOP.
    """
    left, top, right, bottom = (int(value) if float(value).is_integer() else float(value) for value in box_xyxy)
    return [left, top, right - left + extra, bottom - top + extra]


def visible_mask(annotation: ObjectAnnotation, ids: Int32[np.ndarray, "h w"]) -> Bool[np.ndarray, "h w"]:
    """Return the object's visible pixels; only its box is compared, which is most of the cost in a full image."""
    mask = np.zeros(ids.shape, dtype=bool)
    if annotation.box_visible_xyxy is not None:
        left, top, right, bottom = annotation.box_visible_xyxy
        window = slice(top, bottom + 1), slice(left, right + 1)
        np.equal(ids[window], annotation.instance_id, out=mask[window])
    return mask


def image_amodal_mask(annotation: ObjectAnnotation, shape: tuple[int, ...]) -> Bool[np.ndarray, "h w"]:
    """Return the part of an object's whole amodal mask that lies in an image of ``shape`` (height, width)."""
    mask = np.zeros(shape, dtype=bool)
    left, top = annotation.amodal_mask_offset
    height, width = annotation.amodal_mask.shape
    rows = slice(max(top, 0), min(top + height, shape[0]))
    columns = slice(max(left, 0), min(left + width, shape[1]))
    if rows.start < rows.stop and columns.start < columns.stop:
        mask[rows, columns] = annotation.amodal_mask[
            rows.start - top : rows.stop - top, columns.start - left : columns.stop - left
        ]
    return mask
