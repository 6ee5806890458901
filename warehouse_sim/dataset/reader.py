"""Read a dataset folder: images, poses and masks of a split, objects and their meshes."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Bool, Float32, UInt8

from warehouse_sim.dataset.image_io import decode_depth, decode_mask, decode_rgb
from warehouse_sim.dataset.json_file import read_json, read_table
from warehouse_sim.dataset.layout import BopLayout, BopSceneLayout, DatasetLayout, stores_clean
from warehouse_sim.dataset.manifest import Manifest, read_manifest
from warehouse_sim.dataset.objects import ObjectInfo, read_objects
from warehouse_sim.dataset.plain import PIXELS, PLACES, SHARES, WHOLE, Span, is_rigid, take, take_if_given, take_numbers
from warehouse_sim.dataset.split import SPLITS, Split
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.lens import Distortion
from warehouse_sim.geometry.pose import Transform, invert, make_transform

_DEPTH_SCALES = Span(1e-3, 1e3)
_PIXELS = Span(-1e6, 1e6)
"""Intrinsics and corners of boxes, which may leave the image (px)."""
_PLACES_MM = Span(1000.0 * PLACES.low, 1000.0 * PLACES.high)


@dataclass(frozen=True, eq=False)
class TargetRecord:
    """The label of one target in one image."""

    gt_index: int
    """Position in the image's labels; names its masks."""
    obj_id: int
    instance_id: int
    """Number in the scene record; 0 when the dataset does not say."""
    T_camera_object: Transform
    visible_fraction: float
    """Visible pixels over the whole silhouette, truncation included."""
    pixels_visible: int
    box_visible_xyxy: tuple[float, float, float, float]
    """Inclusive pixel corners of the visible part."""
    box_amodal_xyxy: tuple[float, float, float, float]
    """Inclusive pixel corners of the whole silhouette; may leave the image."""
    pixels_valid: int
    """Pixels of the silhouette in the image, hidden or not, with a depth reading."""
    pixels_all: int
    """Pixels of the whole silhouette, inside the image or not."""


@dataclass(frozen=True, eq=False)
class ImageRecord:
    """One image of a split."""

    split: Split
    scene_id: int
    image_id: int
    camera: PinholeCamera
    T_world_camera: Transform
    depth_scale: float
    """Millimetres a step of the depth file."""
    targets: tuple[TargetRecord, ...]


class DatasetReader:
    """A complete dataset with the format "bop".

    Args:
        root: Folder of the dataset.

    Raises:
        DatasetError: The folder is no complete dataset or has no BOP files.
    """

    def __init__(self, root: Path) -> None:
        self.root = Path(root)
        self.manifest: Manifest = read_manifest(self.root)
        if "bop" not in self.manifest.formats:
            raise DatasetError(
                f"{root}: was made without the format bop, which training and scoring read; "
                "generate it with --formats bop kitti"
            )
        self._bop = BopLayout(DatasetLayout(self.root).format_folder("bop"))
        self._images: dict[str, list[ImageRecord]] = {}

    @cached_property
    def objects(self) -> dict[int, ObjectInfo]:
        """The CAD geometries of the targets by obj_id."""
        return read_objects(self.root)

    @property
    def splits(self) -> dict[str, tuple[int, ...]]:
        """Scene indices of each split."""
        return self.manifest.splits

    def images(self, split: str) -> list[ImageRecord]:
        """Return the images of a split, by scene and image id.

        Raises:
            DatasetError: No such split, or a table is missing or malformed.
        """
        name = _split_name(split, self.root)
        if split not in self._images:
            camera, where = read_json(self._bop.camera), str(self._bop.camera)
            size = take(camera, "width", int, where, PIXELS), take(camera, "height", int, where, PIXELS)
            self._images[split] = [
                record
                for scene_id in self.manifest.splits[name]
                for record in read_bop_scene(self._bop.scene(name, scene_id), name, scene_id, size)
            ]
        return self._images[split]

    def rgb(self, image: ImageRecord) -> UInt8[np.ndarray, "h w 3"]:
        """Read the colour image."""
        return _sized(decode_rgb(self._scene(image).rgb(image.image_id)), image, "rgb")

    def depth(self, image: ImageRecord) -> Float32[np.ndarray, "h w"]:
        """Read the depth image: metres along the optical axis, 0 = no reading."""
        steps = _sized(decode_depth(self._scene(image).depth(image.image_id)), image, "depth")
        return steps.astype(np.float32) * np.float32(image.depth_scale / 1000.0)

    def clean_rgb(self, image: ImageRecord) -> UInt8[np.ndarray, "h w 3"]:
        """Read the colour image as it was drawn, without errors of a camera.

        Raises:
            DatasetError: The dataset was made without clean images.
        """
        self._require_clean()
        return _sized(decode_rgb(self._scene(image).rgb_clean(image.image_id)), image, "rgb_clean")

    def clean_depth(self, image: ImageRecord) -> Float32[np.ndarray, "h w"]:
        """Read the depth without errors of a sensor: metres, 0 = nothing there, or farther than the file can say.

        Raises:
            DatasetError: The dataset was made without clean images.
        """
        self._require_clean()
        steps = _sized(decode_depth(self._scene(image).depth_clean(image.image_id)), image, "depth_clean")
        return steps.astype(np.float32) * np.float32(image.depth_scale / 1000.0)

    def mask_visible(self, image: ImageRecord, gt_index: int) -> Bool[np.ndarray, "h w"]:
        """Read the mask of a target's visible pixels."""
        return _sized(decode_mask(self._scene(image).mask(image.image_id, gt_index, visible=True)), image, "mask_visib")

    def mask(self, image: ImageRecord, gt_index: int) -> Bool[np.ndarray, "h w"]:
        """Read the mask of a target's whole silhouette, as far as it lies in the image."""
        return _sized(decode_mask(self._scene(image).mask(image.image_id, gt_index, visible=False)), image, "mask")

    @property
    def has_clean(self) -> bool:
        """Whether there are clean images beside those that were read."""
        return stores_clean(self.manifest.recipe)

    def _require_clean(self) -> None:
        if not self.has_clean:
            raise DatasetError(f"{self.root}: holds no clean images; generate it with sensors.clean: true")

    def _scene(self, image: ImageRecord) -> BopSceneLayout:
        return self._bop.scene(image.split, image.scene_id)


def read_bop_scene(layout: BopSceneLayout, split: Split, scene_id: int, size_wh: tuple[int, int]) -> list[ImageRecord]:
    """Read the tables of one BOP scene.

    Args:
        layout: The scene's paths.
        split: The split it belongs to.
        scene_id: Its number.
        size_wh: Width and height of its images in pixels.

    Raises:
        DatasetError: A table is missing, malformed, or disagrees with another one.
    """
    cameras, poses, infos = (read_table(layout.table(name)) for name in ("camera", "gt", "gt_info"))
    if not set(cameras) == set(poses) == set(infos):
        raise DatasetError(f"{layout.root}: scene_camera, scene_gt and scene_gt_info do not list the same images")
    images = []
    for key in cameras:
        where = f"{layout.table('gt')}: {key}"
        if not isinstance(poses[key], list) or not isinstance(infos[key], list) or len(poses[key]) != len(infos[key]):
            raise DatasetError(f"{where}: scene_gt and scene_gt_info do not list the same number of objects")
        camera_where = f"{layout.table('camera')}: {key}"
        targets = tuple(
            _read_target(i, pose, info, f"{where}[{i}]")
            for i, (pose, info) in enumerate(zip(poses[key], infos[key], strict=True))
        )
        T_camera_world = _read_pose(cameras[key], "cam_R_w2c", "cam_t_w2c", camera_where)
        images.append(
            ImageRecord(
                split=split,
                scene_id=scene_id,
                image_id=key,
                camera=_read_camera(cameras[key], size_wh, camera_where),
                T_world_camera=invert(T_camera_world),
                depth_scale=take(cameras[key], "depth_scale", float, camera_where, _DEPTH_SCALES),
                targets=targets,
            )
        )
    return images


def _read_target(index: int, pose: Any, info: Any, where: str) -> TargetRecord:
    return TargetRecord(
        gt_index=index,
        obj_id=take(pose, "obj_id", int, where, WHOLE),
        instance_id=take_if_given(info, "instance_id", int, where, WHOLE) or 0,
        T_camera_object=_read_pose(pose, "cam_R_m2c", "cam_t_m2c", where),
        visible_fraction=take(info, "visib_fract", float, where, SHARES),
        pixels_visible=take(info, "px_count_visib", int, where, WHOLE),
        box_visible_xyxy=_read_box(info, "bbox_visib", where),
        box_amodal_xyxy=_read_box(info, "bbox_obj", where),
        pixels_valid=take(info, "px_count_valid", int, where, WHOLE),
        pixels_all=take(info, "px_count_all", int, where, WHOLE),
    )


def _read_pose(data: Any, rotation: str, translation: str, where: str) -> Transform:
    R, t_mm = take_numbers(data, rotation, 9, where), take_numbers(data, translation, 3, where, _PLACES_MM)
    T = make_transform(R.reshape(3, 3), t_mm / 1000.0)
    if not is_rigid(T):
        raise DatasetError(f"{where}: {rotation} is not a rotation: {R.tolist()}")
    return T


def _read_camera(data: Any, size_wh: tuple[int, int], where: str) -> PinholeCamera:
    fx, skew, cx, _, fy, cy, *last = take_numbers(data, "cam_K", 9, where, _PIXELS)
    if skew != 0.0 or last != [0.0, 0.0, 1.0]:
        raise DatasetError(f"{where}: cam_K must be a pinhole camera without skew")
    lens = take_numbers(data, "cam_distortion", 5, where, _PIXELS).tolist() if "cam_distortion" in data else None
    try:
        distortion = None if lens is None else Distortion(*lens)
        camera = PinholeCamera(*size_wh, float(fx), float(fy), float(cx), float(cy), distortion)
        camera.require_clear_lens()
    except ValueError as problem:
        raise DatasetError(f"{where}: cam_K is no camera ({problem})") from problem
    return camera


def _read_box(data: Any, key: str, where: str) -> tuple[float, float, float, float]:
    left, top, width, height = (float(value) for value in take_numbers(data, key, 4, where, _PIXELS))
    # BOP's width is the difference of inclusive corners, without one more.
    return left, top, left + width, top + height


def _sized(pixels: np.ndarray, image: ImageRecord, kind: str) -> np.ndarray:
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


def _split_name(split: str, root: Path) -> Split:
    for name in SPLITS:
        if name == split:
            return name
    raise DatasetError(f"{root}: there is no split {split!r}; known: {', '.join(SPLITS)}")
