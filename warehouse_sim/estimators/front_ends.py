"""Open what finds objects in images: a detector or segmenter by name, or the run folder of one."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from warehouse_sim.errors import InputError, UnknownNameError
from warehouse_sim.estimators import DETECTORS, FRONT_ENDS, SEGMENTERS
from warehouse_sim.estimators.rgbd_image import Detection, RgbdImage
from warehouse_sim.learning.run_folder import read_kind

FindObjects = Callable[[RgbdImage], Sequence[Detection]]


def open_front_end(name_or_run: str | Path) -> FindObjects:
    """Return what finds objects in an image, or outlines those that its detections name.

    Args:
        name_or_run: Registered name of a detector or a segmenter, or the run folder of a trained one.

    Raises:
        UnknownNameError: Neither a name nor a folder.
        InputError: The folder holds something else.
        TrainingError: There are no weights, or they cannot be read.
    """
    name = str(name_or_run)
    if name in DETECTORS.names():
        return as_stage(DETECTORS.get(name)())
    if name in SEGMENTERS.names():
        return as_stage(SEGMENTERS.get(name)())
    if not Path(name_or_run).is_dir():
        known = [*DETECTORS.names(), *SEGMENTERS.names()]
        raise UnknownNameError("detector or segmenter (or the run folder of one)", name, known)
    kind = read_kind(Path(name_or_run))
    if kind not in FRONT_ENDS.names():
        raise InputError(f"{name} holds a run of the kind {kind}, which finds no objects")
    return as_stage(FRONT_ENDS.get(kind)(Path(name_or_run)))


def as_stage(found: Any) -> FindObjects:
    """Return what a detector or a segmenter does to an image."""
    stage: FindObjects = found.segment if hasattr(found, "segment") else found.detect
    return stage
