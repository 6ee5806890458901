"""Remove what a scene that could not be made has left in a dataset folder."""

import re
from pathlib import Path

from warehouse_sim.dataset.manifest import Manifest
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
