"""Labels of any format against the scene record, and masks against each other; masks are decoded by pycocotools."""

from typing import Any

import numpy as np
from jaxtyping import Bool
from pycocotools import mask as coco_mask

from warehouse_sim.dataset.checks.findings import Findings
from warehouse_sim.dataset.checks.subject import Subject
from warehouse_sim.dataset.files.run_lengths import mask_of_runs
from warehouse_sim.dataset.records import ImageRecord
from warehouse_sim.geometry.pose import invert

SAME_POSE = 1e-6
"""By how much entries of a pose may differ from the scene record."""
_SAME_FRACTION = 1e-9
VISIBLE_ENOUGH = 0.1
"""Visible fraction from which BOP requires a target (calc_gt_info and the challenge's targets), and COCO's is none to
ignore."""


def agree_with_record(findings: Findings, subject: Subject, image: ImageRecord, where: str) -> None:
    """Hold the camera of an image and each of its targets against the scene record."""
    record = subject.record(image.scene_id)
    if not findings.require(image.image_id < len(record.T_world_camera), f"{where}: is not in the scene record"):
        return
    measured = {item.instance_id: item for item in record.observations[image.image_id].targets}
    T_world_camera = record.T_world_camera[image.image_id]
    moved = np.abs(image.T_world_camera - T_world_camera).max()
    findings.require(bool(moved < SAME_POSE), f"{where}: the camera is not where the scene record has it")
    for target in image.targets:
        item = record.object(target.instance_id)
        here = f"{where}[{target.gt_index}]"
        if not findings.require(item is not None, f"{here}: instance {target.instance_id} is not in the scene record"):
            continue
        assert item is not None
        known = target.obj_id in subject.objects and item.obj_id == target.obj_id
        findings.require(known, f"{here}: obj_id {target.obj_id} is unknown or not that of the scene record")
        moved = np.abs(target.T_camera_object - invert(T_world_camera) @ item.T_world_object).max()
        findings.require(bool(moved < SAME_POSE), f"{here}: the pose differs from the scene record by {moved:.2e}")
        noted = measured.get(target.instance_id)
        if noted is not None:
            said = noted.visible_fraction, noted.pixels_all
            same = abs(said[0] - target.visible_fraction) < _SAME_FRACTION and said[1] == target.pixels_all
            findings.require(
                same,
                f"{here}: visib_fract {target.visible_fraction:.6g} of {target.pixels_all} px, "
                f"the scene record has {said[0]:.6g} of {said[1]}",
            )


def decode_runs(runs: Any, image: ImageRecord, where: str) -> Bool[np.ndarray, "h w"]:
    """Return the mask of run lengths, compressed or not, decoded by pycocotools.

    Args:
        runs: ``{"size": [h, w], "counts": ...}``, column by column, zeros first.
        image: Which they are of.
        where: File and image, for the message.

    Raises:
        DatasetError: Not run lengths that fill the image; pycocotools would take them without a word.
    """
    shape = image.camera.height, image.camera.width
    mask_of_runs(runs, shape, where)
    given = runs if isinstance(runs["counts"], str) else coco_mask.frPyObjects(runs, *shape)
    decoded: Bool[np.ndarray, "h w"] = coco_mask.decode(given).astype(bool)
    return decoded


def lie_apart(
    findings: Findings,
    visible: Bool[np.ndarray, "h w"],
    whole: Bool[np.ndarray, "h w"] | None,
    taken: Bool[np.ndarray, "h w"],
    where: str,
) -> None:
    """Require a visible mask to lie in the amodal one, if there is one, and beside ``taken`` pixels; take its own."""
    if whole is not None:
        findings.require(not (visible & ~whole).any(), f"{where}: is not part of the whole amodal mask")
    findings.require(not (visible & taken).any(), f"{where}: overlaps the visible mask of another object")
    taken |= visible
