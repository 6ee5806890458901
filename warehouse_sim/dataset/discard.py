"""Remove from a dataset folder what a scene that could not be made has left, or the whole dataset."""

import re
import shutil
from pathlib import Path

from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.dataset.manifest import Manifest, load_manifest
from warehouse_sim.errors import DatasetError
from warehouse_sim.one_writer import is_lock
from warehouse_sim.output import writing

_SIX_DIGITS = re.compile(r"[0-9]{6}(?![0-9])")
_BY_FRAME = "kitti"
"""The format that numbers observations through all scenes."""


def discard_scene(root: Path, manifest: Manifest, scene_index: int) -> None:
    """Delete the files and folders of one scene, whatever its formats.

    In a format's folder, the first part of a path that begins with six digits is the scene, but in KITTI, where it is
    the frame; so it is in the folders of readings, the card and records.

    Raises:
        OutputError: A file cannot be deleted.
    """
    each = manifest.observations_per_scene
    frames = range(scene_index * each, (scene_index + 1) * each)
    for path in sorted(root.rglob("*"), reverse=True):  # what a folder holds comes before the folder
        folder, *parts = path.relative_to(root).parts
        numbers = (int(found[0]) for part in parts if (found := _SIX_DIGITS.match(part)))
        number = next(numbers, None)
        if number is None or not (number in frames if folder == _BY_FRAME else number == scene_index):
            continue
        with writing(path):
            path.rmdir() if path.is_dir() else path.unlink(missing_ok=True)


def discard_dataset(root: Path) -> None:
    """Delete a dataset of this package, complete or not; a folder that does not exist or is empty stays as it is.

    Raises:
        DatasetError: The folder holds something else.
        OutputError: A file cannot be deleted.
    """
    if not root.exists() or (root.is_dir() and all(is_lock(path) for path in root.iterdir())):
        return
    layout = DatasetLayout(root)
    stated = layout.manifest if layout.manifest.is_file() else layout.unfinished
    try:
        load_manifest(stated)  # Other projects have a manifest.json, too.
    except DatasetError as problem:
        raise DatasetError(
            f"{root}: is not empty and holds no dataset of warehouse_sim; remove it yourself or choose another folder"
        ) from problem
    _empty(root)


def discard_unstarted(root: Path) -> bool:
    """Delete a dataset of this package of which no scene is finished, such as a failed run's; return whether it was."""
    layout = DatasetLayout(root)
    if layout.manifest.exists() or not layout.unfinished.is_file():
        return False
    if layout.scenes.is_dir() and any(layout.scenes.glob("*.json")):
        return False
    _empty(root)
    return True


def _empty(root: Path) -> None:
    for path in sorted(root.iterdir()):
        with writing(path):
            if path.is_dir() and not path.is_symlink():
                shutil.rmtree(path)
            elif not is_lock(path):
                path.unlink()
