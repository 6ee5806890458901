"""Where everything lies in a folder of DenseFusion's LINEMOD layout."""

from dataclasses import dataclass
from pathlib import Path

from warehouse_sim.dataset.layout import DatasetLayout

NAME = "linemod"
"""Of the format and of its folder in a dataset."""
KINDS = ("rgb", "depth", "mask")


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
