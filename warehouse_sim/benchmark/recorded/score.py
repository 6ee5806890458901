"""Recorded frames in plain folders: what of them can be scored, and the score of those with labelled faces."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from warehouse_sim.benchmark.entrants.entrant import Evaluated, Group, Oracle, Shuffled
from warehouse_sim.benchmark.recorded.entries import BASELINE, GRAVITY, MASKS, entries
from warehouse_sim.benchmark.recorded.faces import Entry, RecordedFace, drive_in, read_faces
from warehouse_sim.benchmark.result import LeftOut
from warehouse_sim.benchmark.rows.row import Row
from warehouse_sim.benchmark.rows.scores import mean_row
from warehouse_sim.benchmark.scored import Answer, posed_split
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.errors import DatasetError, InputError

_IMAGES = (".png", ".jpg", ".jpeg")


@dataclass(frozen=True)
class Recorded:
    """One folder of recorded frames."""

    path: Path
    kind: Literal["faces", "posed", "other"]
    note: str = ""
    """Why nothing of it is scored."""
    split: str = ""
    """Which has poses."""


def find_recorded(data: Path) -> list[Recorded]:
    """Return what lies in a folder and in those within it.

    ``faces`` has sites with ``labels.json``, ``posed`` is a folder in a known format with poses; of all else the note
    says why it is not scored.

    Raises:
        InputError: It is no folder.
    """
    if not data.is_dir():
        raise InputError(f"{data}: is no folder of recorded frames")
    if _has_faces(data):
        return [_recorded(data)]
    # A folder that holds one called kitti is read as KITTI's: what lies in it comes first.
    within = [_recorded(path) for path in sorted(data.iterdir()) if path.is_dir()]
    return within if any(item.kind != "other" for item in within) else [_recorded(data)]


def _has_faces(path: Path) -> bool:
    return (path / "labels.json").is_file() or any(path.glob("*/labels.json"))


def _recorded(path: Path) -> Recorded:
    if _has_faces(path):
        return Recorded(path, "faces")
    try:
        reader = DatasetReader(path)
        split = posed_split(reader)
        images = [image for name in reader.splits for image in reader.images(name)]
    except DatasetError as problem:
        return Recorded(path, "other", f"{path.name}: {_why_not(path, problem)}")
    if split:
        return Recorded(path, "posed", split=split)
    masks = sum(len(image.targets) for image in images)
    what = f"{len(images)} images, {masks} masks, no poses to score against"
    return Recorded(path, "other", f"{path.name}: {what}; predict and inspect take it")


def _why_not(path: Path, problem: DatasetError) -> str:
    """Return why a folder is not read, and for bare images what they lack."""
    images = sum(file.suffix.lower() in _IMAGES for file in path.iterdir())
    if not images:
        return f"not in a format that is read ({str(problem).replace(str(path), path.name)})"
    return (
        f"{images} images in no layout that is read; to predict, name them color.png, depth.png and mask.png and add "
        "intrinsics.json with fx, fy, cx and cy; to score, lay them out as BOP or LINEMOD with meshes and poses"
    )


def baseline_group() -> Group:
    """Return the baseline for faces, which answers without an estimator."""
    return Group(BASELINE, (Oracle(BASELINE),))


def face_rows(group: Group, folder: Path) -> Iterator[Row]:
    """Yield the fraction of recorded faces that a fork enters that trusts an estimator, by masks and gravity.

    Ground truth is the labels, shuffled the label of a frame of another site. A face without an answer is not entered.

    Raises:
        InputError: The labels are malformed, or the estimator answers none of the faces: their pallets are in no
            catalog, and it must say where pockets are by itself.
        DatasetError: An image cannot be read.
    """
    faces = read_faces(folder)
    sites = np.unique([face.name.rpartition("/")[0] for face in faces], return_inverse=True)[1]
    member = group.members[0]
    for masks in MASKS:
        for gravity in GRAVITY:
            found = _entries(group, faces, masks, gravity)
            if isinstance(member, Evaluated) and all(item is None for item in found):
                raise InputError(f"{group.name} answers none of the faces: their pallets are in no catalog")
            values = np.array([item is not None and item.docked for item in found], dtype=float)
            condition = f"masks: {masks}, gravity: {gravity}"
            yield mean_row(("faces", group.name, condition, folder.name, "docked"), values, sites, group.trainings)


def who_answers(answers: Sequence[Answer]) -> tuple[list[Answer], list[LeftOut]]:
    """Return the answers of those who answer anything, and who does not: no number is a score of nothing."""
    silent = [
        item
        for item in answers
        if isinstance(item.group.members[0], Evaluated) and not any(scores.estimates for scores in item.scores)
    ]
    left_out = [
        LeftOut(item.group.name, item.condition, "answers nothing: it knows no such objects") for item in silent
    ]
    return [item for item in answers if item not in silent], left_out


def _as_elsewhere(face: RecordedFace, faces: Sequence[RecordedFace]) -> Entry | None:
    """Return what a fork does that takes a face for one of another site, in turn; None where there is one site.

    Frames of one site follow each other: the truck has hardly moved.
    """
    site = face.name.rpartition("/")[0]
    others = [item for item in faces if item.name.rpartition("/")[0] != site]
    if not others:
        return None
    other = others[faces.index(face) % len(others)]
    return drive_in(face, other.T_camera_dock, list(other.pockets[:, 1:]))


def _entries(group: Group, faces: Sequence[RecordedFace], masks: str, gravity: str) -> list[Entry | None]:
    member = group.members[0]
    if group.name == BASELINE:
        return entries(None, {}, faces, masks, gravity)
    if isinstance(member, Oracle):
        return [drive_in(face, face.T_camera_dock, list(face.pockets[:, 1:])) for face in faces]
    if isinstance(member, Shuffled):
        return [_as_elsewhere(face, faces) for face in faces]
    if not isinstance(member, Evaluated):
        raise InputError(f"{group.name}: files of poses say nothing of faces; name an estimator")
    return entries(member.way.open({}), {}, faces, masks, gravity)
