"""DenseFusion's LINEMOD layout, "LINEMOD_preprocessed": https://github.com/j96w/DenseFusion (datasets/linemod)."""

import json
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from warehouse_sim.dataset.formats import FormatReader
from warehouse_sim.dataset.formats.bop import COUNTED
from warehouse_sim.dataset.formats.built_in import BuiltIn
from warehouse_sim.dataset.formats.observation_files import MILLIMETRES
from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.errors import DatasetError

_MOST_BYTES = 2**26
_EXPONENT = re.compile(r"(?<![\d.])(-?\d+)e")


def yaml_row(data: Any) -> str:
    """Return plain data in one line of YAML.

    YAML 1.1 takes 1e-05 for a word: numbers with an exponent get a point.
    """
    return _EXPONENT.sub(r"\1.0e", json.dumps(data, allow_nan=False))


def read_yaml_table(path: Path) -> dict[int, Any]:
    """Read a table whose keys are whole numbers, in their order.

    Raises:
        DatasetError: The file is missing, too large, is not YAML or is no such table, or refers to parts of itself.
    """
    try:
        if path.stat().st_size > _MOST_BYTES:
            raise DatasetError(f"{path}: is larger than {_MOST_BYTES} bytes; that is no table of LINEMOD")
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as problem:
        raise DatasetError(f"{path}: cannot be read ({problem}); the dataset is incomplete") from problem
    if "&" in text or "*" in text:
        raise DatasetError(f"{path}: holds an anchor or an alias of YAML; tables of LINEMOD have numbers only")
    try:
        # libyaml, where it was built in, reads a table of a thousand frames in a fifth of the time.
        data = yaml.load(text, getattr(yaml, "CSafeLoader", yaml.SafeLoader))
    except (yaml.YAMLError, ValueError, RecursionError) as problem:
        raise DatasetError(f"{path}: is not valid YAML ({' '.join(str(problem).split())[:200]})") from problem
    if not isinstance(data, dict) or not all(type(key) is int and 0 <= key < 10**9 for key in data):
        raise DatasetError(f"{path}: expected a table whose keys are numbers")
    return {key: data[key] for key in sorted(data)}


NAME = "linemod"
"""Of the format and of its folder in a dataset."""
KINDS = ("rgb", "depth", "mask")
NO_LENS = "LINEMOD: has no place for a lens, sensors.camera has one; remove it, or leave linemod out of --formats"
"""What is said of a camera with a lens."""


@dataclass(frozen=True)
class LinemodLayout:
    """Paths of a folder of each object, with frames of its own numbers, and of meshes."""

    root: Path

    def object_folder(self, obj_id: int) -> Path:
        """Return the folder of the frames of an object."""
        return self.root / "data" / f"{obj_id:02d}"

    def image(self, obj_id: int, kind: str, frame: int) -> Path:
        """Return an image of the kind "rgb", "depth" or "mask"."""
        return self.object_folder(obj_id) / kind / f"{frame:04d}.png"

    def label(self, obj_id: int, frame: int) -> Path:
        """Return the mask that DenseFusion's evaluation takes for the output of a segmentation."""
        return self.root / "segnet_results" / f"{obj_id:02d}_label" / f"{frame:04d}_label.png"

    def model(self, obj_id: int) -> Path:
        """Return a mesh in millimetres."""
        return self.root / "models" / f"obj_{obj_id:02d}.ply"

    @property
    def models_info(self) -> Path:
        """The table of sizes and diameters."""
        return self.root / "models" / "models_info.yml"

    def scene(self, scene_index: int) -> Path:
        """Return which frames come from a scene, our own addition: it leads to the scene records."""
        return self.root / "frames" / f"{scene_index:06d}.json"

    @property
    def parts(self) -> Path:
        """Folder of images that have no number yet; gone when the dataset is complete."""
        return self.root / "parts"

    def part(self, scene_index: int) -> Path:
        """Return the folder of the images of a scene on their way to their numbers."""
        return self.parts / f"{scene_index:06d}"


def linemod_layout(root: Path) -> LinemodLayout:
    """Return the paths of the LINEMOD files of a dataset."""
    return LinemodLayout(DatasetLayout(root).format_folder(NAME))


class LinemodFormat(BuiltIn):
    """A folder of each object with frames in which it is labelled; tables in YAML."""

    needs_meshes = True

    def reject(self, manifest: Manifest) -> None:
        """Reject depth beyond 16 bits and cameras with a lens."""
        super().reject(manifest)
        if manifest.contents.distortion is not None:
            raise DatasetError(NO_LENS)

    def reader(self, root: Path) -> FormatReader:
        """Return a reader of ``root/linemod``, or of a third-party folder."""
        from warehouse_sim.dataset.formats.linemod.reader import LinemodReader, third_party_folder

        if DatasetLayout(root).manifest.is_file():
            return LinemodReader(linemod_layout(root).root, root)
        return LinemodReader(third_party_folder(root) or root, None)

    def recognises(self, root: Path) -> bool:
        """Return whether the folder, or one in it, has ``data/01/gt.yml`` or the like."""
        from warehouse_sim.dataset.formats.linemod.reader import third_party_folder

        return third_party_folder(root) is not None


FORMAT = LinemodFormat(
    NAME,
    checks_at="warehouse_sim.dataset.formats.linemod.checks:CHECKS",
    writer_at="warehouse_sim.dataset.formats.linemod.writer:LinemodWriter",
    needs=("rgb", "depth", "masks", "poses"),
    holds=("rgb", "depth", "masks", "poses"),
    counts=COUNTED,
    steps_per_metre=MILLIMETRES,
)
