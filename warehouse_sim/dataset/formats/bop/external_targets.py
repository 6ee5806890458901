"""The lists of targets that BOP folders come with: which images of the test split are scored."""

import logging
from collections.abc import Sequence
from pathlib import Path

from warehouse_sim.dataset.files.json_file import read_json
from warehouse_sim.dataset.files.plain import WHOLE, take
from warehouse_sim.dataset.formats.bop.layout import BopLayout
from warehouse_sim.dataset.records import ImageRecord
from warehouse_sim.errors import DatasetError

log = logging.getLogger(__name__)
_YEARS = (2024, 2019)


def only_requested(root: Path, images: Sequence[ImageRecord]) -> list[ImageRecord]:
    """Return those images that test_targets_bop24.json, or else bop19, names; all where there is neither.

    Raises:
        DatasetError: A list is malformed, or names none of the images.
    """
    path = next((path for year in _YEARS if (path := BopLayout(root).targets(year)).is_file()), None)
    if path is None:
        return list(images)
    rows = take({"targets": read_json(path)}, "targets", list, str(path))
    requested = {
        (take(row, "scene_id", int, f"{path}: [{i}]", WHOLE), take(row, "im_id", int, f"{path}: [{i}]", WHOLE))
        for i, row in enumerate(rows)
    }
    kept = [image for image in images if (image.scene_id, image.image_id) in requested]
    if images and not kept:
        raise DatasetError(
            f"{path}: names none of the {len(images)} test images; remove it or get the list of this set"
        )
    if len(kept) < len(images):
        log.info("%s: %d of %d test images are requested", path, len(kept), len(images))
    return kept
