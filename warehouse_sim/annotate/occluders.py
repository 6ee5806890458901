"""What is visible of a target, and what hides it: fractions of its amodal mask by kind of thing before it."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from jaxtyping import Bool, Int, Int32

from warehouse_sim.geometry.boxes import mask_box_xyxy
from warehouse_sim.schema import SceneSpec
from warehouse_sim.schema.classes import ObjectKind, kind_of


@dataclass(frozen=True)
class Window:
    """The rectangle that a placed mask and an image share, in the coordinates of each."""

    image: tuple[slice, slice]
    """Rows and columns of the image."""
    mask: tuple[slice, slice]
    """Rows and columns of the mask."""


def window_in_image(offset: tuple[int, int], mask_hw: tuple[int, int], image_hw: tuple[int, int]) -> Window | None:
    """Return where a mask lies in an image, or None when it misses it.

    Args:
        offset: Column and row of the mask's first pixel in the image; may be negative.
        mask_hw: Height and width of the mask.
        image_hw: Height and width of the image.
    """
    columns = _overlap(offset[0], mask_hw[1], image_hw[1])
    rows = _overlap(offset[1], mask_hw[0], image_hw[0])
    if columns is None or rows is None:
        return None
    return Window(image=(rows[0], columns[0]), mask=(rows[1], columns[1]))


def box_in_image(mask: Bool[np.ndarray, "h w"], window: Window) -> tuple[int, int, int, int] | None:
    """Return (left, top, right, bottom) in the image of the set pixels of ``mask``, the image's part at ``window``."""
    box, left, top = mask_box_xyxy(mask), window.image[1].start, window.image[0].start
    return None if box is None else (box[0] + left, box[1] + top, box[2] + left, box[3] + top)


def _overlap(start: int, length: int, limit: int) -> tuple[slice, slice] | None:
    first, last = max(start, 0), min(start + length, limit)
    return (slice(first, last), slice(first - start, last - start)) if first < last else None


KINDS: tuple[ObjectKind | Literal["border"], ...] = (*get_args(ObjectKind), "border")
"""What can hide a target; "border" is what lies outside of the image."""
WRAP = "wrap"
"""Key for film. Film dims and does not hide: its fraction is of the amodal mask too, but counts pixels that are
visible."""


def kinds_by_id(scene: SceneSpec) -> Int[np.ndarray, " n"]:
    """Return for each instance id up to the largest its kind as an index into ``KINDS``; the background is other."""
    ids = [item.instance_id for item in scene.instances]
    kinds = np.full(max(ids, default=0) + 1, KINDS.index("other"))
    kind_of_model = {name: KINDS.index(kind_of(model.class_name)) for name, model in scene.models.items()}
    kinds[ids] = [kind_of_model[item.model] for item in scene.instances]
    return kinds


def hidden_by(
    kinds: Int[np.ndarray, " n"],
    instance_mask: Int32[np.ndarray, "h w"],
    amodal_mask: Bool[np.ndarray, "sh sw"],
    window: Window,
    target: int,
    film: Bool[np.ndarray, "h w"] | None = None,
) -> dict[str, float]:
    """Return the fraction of a target's amodal mask that each kind of occluder hides; others are absent.

    The fractions and the visible fraction sum to 1, but for the fraction under "wrap": that of the pixels which are
    visible and seen through film.

    Args:
        kinds: What ``kinds_by_id`` gives for the scene.
        instance_mask: What the image shows.
        amodal_mask: The target's unoccluded amodal mask, also beyond the image.
        window: Where amodal mask and image meet.
        target: The target's instance id.
        film: Pixels before whose first surface film lies.
    """
    inside = amodal_mask[window.mask]
    seen = instance_mask[window.image][inside]
    counts = np.bincount(kinds[seen[seen != target]], minlength=len(KINDS))
    total = int(np.count_nonzero(amodal_mask))
    counts[KINDS.index("border")] = total - seen.size
    through = 0 if film is None else int(np.count_nonzero(film[window.image][inside] & (seen == target)))
    return fractions(zip((*KINDS, WRAP), (*counts.tolist(), through), strict=True), total)


def fractions(counts: Iterable[tuple[str, int]], total: int) -> dict[str, float]:
    """Return the counts that are not 0 as fractions of ``total``."""
    return {kind: float(count) / total for kind, count in counts if count}
