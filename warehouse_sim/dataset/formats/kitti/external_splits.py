"""Which frames a KITTI folder made by third parties has, and which split each belongs to."""

from pathlib import Path

from warehouse_sim.dataset.formats.kitti.external_frame import KittiFrame
from warehouse_sim.dataset.formats.kitti.layout import NAME
from warehouse_sim.dataset.formats.kitti.tolerant import read_text
from warehouse_sim.errors import DatasetError

_TRAINING, _TESTING = "training", "testing"
_HELD_OUT = 10
"""Of so many frames of train one is kept for val."""
_LONGEST_NAME = 10
"""Digits of a frame; KITTI's raw data has as many."""


def external_folder(root: Path) -> Path | None:
    """Return ``root`` or ``root/kitti``, whichever holds frames of KITTI; None if neither does."""
    for folder in (root, root / NAME):
        if any((folder / half / "calib").is_dir() for half in (_TRAINING, _TESTING)):
            return folder
    return None


def frames_by_split(root: Path) -> dict[str, list[KittiFrame]]:
    """Return the frames of each split by number: train, val, test, then other lists by their names.

    Lists are those of ImageSets. Without them the folder training is train and the folder testing test; without val
    every tenth frame of train is kept apart as one, the last where there are fewer.

    Raises:
        DatasetError: A list or a file name is no number, a number occurs twice, or a frame is in train and in val.
    """
    folders = {half: _stored(root / half) for half in (_TRAINING, _TESTING)}
    sets = {path.stem: _listed(path, folders) for path in sorted((root / "ImageSets").glob("*.txt"))}
    train = sets.pop("train", None) or sets.pop("trainval", None)
    if train is None:
        others = {frame for frames in sets.values() for frame in frames}
        train = [frame for frame in folders[_TRAINING] if frame not in others]
    val = sets.pop("val", None)
    if val is None:
        held = set(train[_HELD_OUT - 1 :: _HELD_OUT] or train[1:][-1:])
        train, val = [item for item in train if item not in held], [item for item in train if item in held]
    elif both := sorted(frame.name for frame in {*train} & {*val}):
        raise DatasetError(f"{root / 'ImageSets'}: frame {both[0]} is in train and in val; list it once")
    test = sets.pop("test", folders[_TESTING])
    return {"train": train, "val": val} | ({"test": test} if test else {}) | sets


def _stored(folder: Path) -> list[KittiFrame]:
    """Return the frames of a folder that have a calib file; other files than numbers are left alone."""
    calib = folder / "calib"
    names = sorted(path.stem for path in calib.iterdir() if path.suffix == ".txt") if calib.is_dir() else []
    return _checked([KittiFrame(folder, name) for name in names if _is_frame(name)], str(calib))


def _listed(path: Path, folders: dict[str, list[KittiFrame]]) -> list[KittiFrame]:
    """Return the frames of a list; those of a list called test... are in testing, unless training has them."""
    words = read_text(path).split()
    if wrong := next((word for word in words if not _is_frame(word)), None):
        raise DatasetError(f"{path}: {wrong[:40]!r} is no number of a frame; list one a line, such as 000008")
    half = _TESTING if path.stem.startswith("test") and folders[_TESTING] else _TRAINING
    known = {frame.number: frame for frame in folders[half]}
    if lost := next((word for word in words if int(word) not in known), None):
        raise DatasetError(f"{path}: lists frame {lost}, which has no calib file in {half}; copy it, or strike it out")
    return _checked([known[int(word)] for word in words], str(path))


def _is_frame(word: str) -> bool:
    return word.isascii() and word.isdecimal() and len(word) <= _LONGEST_NAME


def _checked(frames: list[KittiFrame], where: str) -> list[KittiFrame]:
    """Return the frames in order of their numbers, each of which occurs once."""
    by_number = {frame.number: frame for frame in frames}
    if len(by_number) < len(frames):
        raise DatasetError(f"{where}: one of {len(frames)} frames occurs twice; each has a number of its own")
    return [by_number[number] for number in sorted(by_number)]
