"""Read the BOP files of a dataset with a manifest: images, masks, poses, objects and their meshes."""

from functools import cached_property, partial
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float32, UInt8, UInt16

from warehouse_sim.dataset.files.checksums import require_checksum
from warehouse_sim.dataset.files.image_io import decode_depth, decode_mask, decode_rgb
from warehouse_sim.dataset.files.json_file import read_json
from warehouse_sim.dataset.files.plain import PIXELS, take
from warehouse_sim.dataset.files.ply import read_ply
from warehouse_sim.dataset.formats.bop import BopLayout, BopSceneLayout, bop_layout
from warehouse_sim.dataset.formats.bop.exact_images import (
    decode_coordinates,
    decode_normals,
    read_class_table,
    require_known_values,
)
from warehouse_sim.dataset.formats.bop.tables import read_bop_scene
from warehouse_sim.dataset.formats.reader_base import ReaderBase, metres, require_size
from warehouse_sim.dataset.manifest import Manifest, read_manifest
from warehouse_sim.dataset.objects import ObjectInfo, read_objects
from warehouse_sim.dataset.records import ImageRecord
from warehouse_sim.dataset.split import SPLITS
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.schema.outputs import Output


class OwnReader(ReaderBase):
    """What both BOP layouts of a complete dataset have in common: images and masks are found by their kind.

    Args:
        root: Folder of the dataset.
        bop: Paths of the format's folder.
    """

    def __init__(self, root: Path, bop: BopLayout) -> None:
        super().__init__(root, SPLITS)
        self._manifest: Manifest = read_manifest(root)
        self._bop = bop
        self.has_clean = self._manifest.contents.clean
        self.has_depth = "depth" in self._manifest.contents.outputs

    @cached_property
    def objects(self) -> dict[int, ObjectInfo]:
        """The CAD geometries of the targets by obj_id."""
        return read_objects(self.root, partial(read_model, self._bop))

    @property
    def splits(self) -> dict[str, tuple[int, ...]]:
        """Scene indices of each split."""
        return {name: self._manifest.splits[name] for name in SPLITS}

    def rgb(self, image: ImageRecord) -> UInt8[np.ndarray, "h w 3"]:
        """Read the colour image."""
        self._require("rgb")
        return require_size(self._colour(image, "rgb"), image, "rgb")

    def depth(self, image: ImageRecord) -> Float32[np.ndarray, "h w"]:
        """Read the depth image: metres along the optical axis, 0 = no reading."""
        self._require("depth")
        return metres(self._steps(image, "depth"), image)

    def clean_rgb(self, image: ImageRecord) -> UInt8[np.ndarray, "h w 3"]:
        """Read the colour image as it was drawn, without errors of a camera."""
        return require_size(self._colour(image, "rgb_clean"), image, "rgb_clean")

    def clean_depth(self, image: ImageRecord) -> Float32[np.ndarray, "h w"]:
        """Read the depth without errors of a sensor: metres, 0 = nothing there, or farther than the file can say."""
        return metres(self._steps(image, "depth_clean"), image, "depth_clean")

    def mask_visible(self, image: ImageRecord, gt_index: int) -> Bool[np.ndarray, "h w"]:
        """Read the mask of a target's visible pixels."""
        self._require("masks")
        return require_size(self._mask(image, gt_index, "mask_visib"), image, "mask_visib")

    def mask(self, image: ImageRecord, gt_index: int) -> Bool[np.ndarray, "h w"]:
        """Read the mask of a target's whole amodal mask, as far as it lies in the image."""
        self._require("amodal_masks")
        return require_size(self._mask(image, gt_index, "mask"), image, "mask")

    def _require(self, output: Output) -> None:
        self._manifest.contents.require(output, self.root)

    def _colour(self, image: ImageRecord, kind: str) -> UInt8[np.ndarray, "h w 3"]:
        raise NotImplementedError

    def _steps(self, image: ImageRecord, kind: str) -> np.ndarray:
        raise NotImplementedError

    def _mask(self, image: ImageRecord, gt_index: int, kind: str) -> Bool[np.ndarray, "h w"]:
        raise NotImplementedError


class BopReader(OwnReader):
    """The folder ``bop`` of a complete dataset.

    Args:
        root: Folder of the dataset.
    """

    def __init__(self, root: Path) -> None:
        super().__init__(root, bop_layout(root))

    def files(self, split: str) -> list[Path]:
        """Return every file of the scenes of a split, sorted."""
        scenes = sorted(self._bop.scene(split, scene_id).root for scene_id in self.splits[split])
        return [path for scene in scenes for path in sorted(scene.rglob("*"))]

    def rgb_file(self, image: ImageRecord) -> Path | None:
        """Return the PNG of the colour image; None where it was left out."""
        return self._scene(image).image("rgb", image.image_id) if "rgb" in self._manifest.contents.outputs else None

    def normals(self, image: ImageRecord) -> Float32[np.ndarray, "h w 3"]:
        """Read the unit normals of surfaces in the camera frame, zeros where there is nothing."""
        found = decode_normals(self._exact(image, "normals"))
        return require_size(found, image, "normals")

    def object_coordinates(self, image: ImageRecord) -> Float32[np.ndarray, "h w 3"]:
        """Read where visible target pixels lie in the boxes of their objects: 0-1 along each edge, NaN elsewhere."""
        found = decode_coordinates(self._exact(image, "object_coordinates"))
        return require_size(found, image, "object_coordinates")

    def class_mask(self, image: ImageRecord) -> UInt16[np.ndarray, "h w"]:
        """Read what each pixel shows, as a value of ``mask_classes``; 0 = nothing."""
        path = self._exact(image, "class_mask")
        found = require_size(decode_depth(path), image, "class_mask")
        require_known_values(found, self.mask_classes(image), str(path))
        return found

    def mask_classes(self, image: ImageRecord) -> dict[int, str]:
        """Return the class that each value of a class mask stands for."""
        self._require("class_mask")
        return read_class_table(self._scene(image).table("class_mask"))

    def _exact(self, image: ImageRecord, kind: Output) -> Path:
        self._require(kind)
        return self._scene(image).image(kind, image.image_id)

    def _read(self, split: str) -> list[ImageRecord]:
        size = camera_size_wh(self._bop)
        return [
            record
            for scene_id in self.splits[split]
            for record in read_bop_scene(self._bop.scene(split, scene_id), split, scene_id, size)
        ]

    def _colour(self, image: ImageRecord, kind: str) -> UInt8[np.ndarray, "h w 3"]:
        return decode_rgb(self._scene(image).image(kind, image.image_id))

    def _steps(self, image: ImageRecord, kind: str) -> np.ndarray:
        return decode_depth(self._scene(image).image(kind, image.image_id))

    def _mask(self, image: ImageRecord, gt_index: int, kind: str) -> Bool[np.ndarray, "h w"]:
        return decode_mask(self._scene(image).mask(kind, image.image_id, gt_index))

    def _scene(self, image: ImageRecord) -> BopSceneLayout:
        return self._bop.scene(image.split, image.scene_id)


def camera_size_wh(bop: BopLayout) -> tuple[int, int]:
    """Return width and height (px) of the images of a folder's camera."""
    camera, where = read_json(bop.camera), str(bop.camera)
    return take(camera, "width", int, where, PIXELS), take(camera, "height", int, where, PIXELS)


def read_model(bop: BopLayout, obj_id: int, even: bool) -> TriangleMesh:
    """Read a model, or the one with evenly spread vertices, in metres.

    Raises:
        DatasetError: There is none, or it is not the file that was written.
    """
    path = bop.model("models_eval" if even else "models", obj_id)
    if not path.is_file():
        raise DatasetError(f"{path}: there is no mesh of object {obj_id}; copy or generate the dataset again")
    require_checksum(path)
    mesh = read_ply(path)
    return TriangleMesh(mesh.vertices / 1000.0, mesh.faces)
