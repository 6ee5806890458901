"""Read the BOP files of a dataset with a manifest: images, masks, poses, objects and their meshes."""

from functools import cached_property, partial
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float32, UInt8

from warehouse_sim.dataset.files.checksums import require_checksum
from warehouse_sim.dataset.files.image_io import decode_depth, decode_mask, decode_rgb
from warehouse_sim.dataset.files.json_file import read_json
from warehouse_sim.dataset.files.plain import PIXELS, take
from warehouse_sim.dataset.files.ply import read_ply
from warehouse_sim.dataset.formats.bop.layout import BopLayout, BopSceneLayout, bop_layout
from warehouse_sim.dataset.formats.bop.tables import read_bop_scene
from warehouse_sim.dataset.manifest import Manifest, read_manifest
from warehouse_sim.dataset.objects import ObjectInfo, read_objects
from warehouse_sim.dataset.records import ImageRecord
from warehouse_sim.dataset.split import SPLITS, require_split
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.mesh import TriangleMesh


class BopReader:
    """The folder ``bop`` of a complete dataset.

    Args:
        root: Folder of the dataset.
    """

    def __init__(self, root: Path) -> None:
        self.root = root
        self._manifest: Manifest = read_manifest(root)
        self._bop = bop_layout(root)
        self._images: dict[str, list[ImageRecord]] = {}

    @cached_property
    def objects(self) -> dict[int, ObjectInfo]:
        """The CAD geometries of the targets by obj_id."""
        return read_objects(self.root, partial(read_model, self._bop))

    @property
    def splits(self) -> dict[str, tuple[int, ...]]:
        """Scene indices of each split."""
        return {name: self._manifest.splits[name] for name in SPLITS}

    @property
    def has_clean(self) -> bool:
        """Whether there are clean images beside those that were read."""
        return self._manifest.contents.clean

    def images(self, split: str) -> list[ImageRecord]:
        """Return the images of a split, by scene and image id.

        Raises:
            DatasetError: No such split, or a table is missing or malformed.
        """
        require_split(self.root, split, self.splits)
        if split not in self._images:
            camera, where = read_json(self._bop.camera), str(self._bop.camera)
            size = take(camera, "width", int, where, PIXELS), take(camera, "height", int, where, PIXELS)
            self._images[split] = [
                record
                for scene_id in self.splits[split]
                for record in read_bop_scene(self._bop.scene(split, scene_id), split, scene_id, size)
            ]
        return self._images[split]

    def files(self, split: str) -> list[Path]:
        """Return every file of the scenes of a split, sorted."""
        scenes = sorted(self._bop.scene(split, scene_id).root for scene_id in self.splits[split])
        return [path for scene in scenes for path in sorted(scene.rglob("*"))]

    def rgb(self, image: ImageRecord) -> UInt8[np.ndarray, "h w 3"]:
        """Read the colour image."""
        return require_size(decode_rgb(self._scene(image).rgb(image.image_id)), image, "rgb")

    def rgb_file(self, image: ImageRecord) -> Path:
        """Return the PNG of the colour image."""
        return self._scene(image).rgb(image.image_id)

    def depth(self, image: ImageRecord) -> Float32[np.ndarray, "h w"]:
        """Read the depth image: metres along the optical axis, 0 = no reading."""
        return self._depth(image, self._scene(image).depth(image.image_id))

    def clean_rgb(self, image: ImageRecord) -> UInt8[np.ndarray, "h w 3"]:
        """Read the colour image as it was drawn, without errors of a camera."""
        return require_size(decode_rgb(self._scene(image).rgb_clean(image.image_id)), image, "rgb_clean")

    def clean_depth(self, image: ImageRecord) -> Float32[np.ndarray, "h w"]:
        """Read the depth without errors of a sensor: metres, 0 = nothing there, or farther than the file can say."""
        return self._depth(image, self._scene(image).depth_clean(image.image_id))

    def mask_visible(self, image: ImageRecord, gt_index: int) -> Bool[np.ndarray, "h w"]:
        """Read the mask of a target's visible pixels."""
        path = self._scene(image).mask(image.image_id, gt_index, visible=True)
        return require_size(decode_mask(path), image, "mask_visib")

    def mask(self, image: ImageRecord, gt_index: int) -> Bool[np.ndarray, "h w"]:
        """Read the mask of a target's whole amodal mask, as far as it lies in the image."""
        path = self._scene(image).mask(image.image_id, gt_index, visible=False)
        return require_size(decode_mask(path), image, "mask")

    def _depth(self, image: ImageRecord, path: Path) -> Float32[np.ndarray, "h w"]:
        steps = require_size(decode_depth(path), image, path.parent.name)
        return steps.astype(np.float32) * np.float32(image.depth_scale / 1000.0)

    def _scene(self, image: ImageRecord) -> BopSceneLayout:
        return self._bop.scene(image.split, image.scene_id)


def require_size(pixels: np.ndarray, image: ImageRecord, kind: str) -> np.ndarray:
    """Return ``pixels`` of an image's file.

    Raises:
        DatasetError: They are not as many as the camera's.
    """
    if pixels.shape[:2] != (image.camera.height, image.camera.width):
        raise DatasetError(
            f"{image.split} scene {image.scene_id}: {kind} of image {image.image_id} is {pixels.shape[:2]}, "
            f"the camera {(image.camera.height, image.camera.width)} (h, w)"
        )
    return pixels


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
