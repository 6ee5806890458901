"""Read a KITTI object detection folder made by third parties, or our own without its manifest: no masks, no CAD.

Each frame is a scene of its own, with the frame's number and one image: frames of KITTI are single shots of many
drives, so that one says little of the next, and an interval over scenes counts each of them.

As in studies of 6D poses on KITTI, the model of an instance is its cloud in its ground-truth box, in the box's frame
(origin in its centre, x along its length, y along its width, z up), and its diameter the box's diagonal; that of a
class is those of some instances.
"""

import logging
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import cached_property, lru_cache, partial
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float, Float32, Int32

from warehouse_sim.dataset.files.image_io import decode_depth
from warehouse_sim.dataset.formats.kitti import NAME, STEPS_PER_METRE
from warehouse_sim.dataset.formats.kitti.external_frame import (
    FrameCalibration,
    KittiFrame,
    StoredSweep,
    points_in_box,
    read_sweep,
    sweep_depth,
)
from warehouse_sim.dataset.formats.kitti.reader import KittiLabel
from warehouse_sim.dataset.formats.kitti.tolerant import read_text
from warehouse_sim.dataset.formats.reader_base import FileReader, box_mask, require_size
from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.dataset.records import ImageRecord, TargetRecord
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.pose import Transform, invert, transform_points
from warehouse_sim.geometry.symmetry import SymmetryGroup
from warehouse_sim.schema import LidarScan, MountedReading

_VISIBLE = {0: 1.0, 1: 0.7, 2: 0.25}
"""Fraction of what lies in the image that is taken for visible, by the level ``occluded``: KITTI gives none, these are
the middles of the bins in which this package writes the levels, and all of what is "fully visible". Unknown (3) counts
as visible."""
_LARGEST_BOX = 65_535.0


def target_record(
    index: int, instance_id: int, label: KittiLabel, T_camera_object: Transform, info: ObjectInfo
) -> TargetRecord:
    """Return a row as a target.

    Args:
        index: Position among the rows of the frame that have a 3D box.
        instance_id: Its number in the frame.
        label: The row.
        T_camera_object: Pose of its box's centre frame in the camera that took the image.
        info: Its own geometry.
    """
    left, top, right, bottom = (float(value) for value in np.clip(label.box_xyxy, -_LARGEST_BOX, _LARGEST_BOX))
    in_image = max(round(right) - round(left) + 1, 0) * max(round(bottom) - round(top) + 1, 0)
    inside = 1.0 - min(max(label.truncated, 0.0), 1.0)
    fraction = _VISIBLE.get(label.occluded, 1.0)
    return TargetRecord(
        gt_index=index,
        obj_id=info.obj_id,
        instance_id=instance_id,
        T_camera_object=T_camera_object,
        visible_fraction=inside * fraction,
        pixels_visible=round(in_image * fraction),
        box_visible_xyxy=(left, top, right, bottom),
        box_amodal_xyxy=(left, top, right, bottom),
        pixels_valid=in_image,
        pixels_all=max(round(in_image / max(inside, 1e-3)), in_image, 1),
        geometry=info,
    )


_KITTI = ("Car", "Van", "Truck", "Pedestrian", "Person_sitting", "Cyclist", "Tram", "Misc")
"""KITTI's own classes have the same number in every folder, from 1."""
_MOST_CLOUDS = 200
"""Instances whose clouds make the cloud of a class."""

Cloud = Float[np.ndarray, "n 3"]


def class_numbers(names: Iterable[str]) -> dict[str, int]:
    """Return a number for each class: those of KITTI have their own, all others follow by name."""
    others = sorted(set(names) - set(_KITTI))
    return {name: number for number, name in enumerate((*_KITTI, *others), start=1)}


def box_info(
    obj_id: int, name: str, size: Float[np.ndarray, " 3"], root: Path, read_cloud: Callable[[], Cloud]
) -> ObjectInfo:
    """Return an object that is a cloud in a box.

    Args:
        obj_id: Number of its class.
        name: Of its class.
        size: Length, width and height of the box (m).
        root: Folder of the dataset.
        read_cloud: Reads its points (m, in the box's frame).
    """
    return ObjectInfo(
        obj_id=obj_id,
        name=name,
        class_name=name,
        size=size,
        diameter=float(np.linalg.norm(size)),
        symmetry=SymmetryGroup.trivial(),
        pockets=(),
        root=root,
        read_cloud=read_cloud,
    )


def class_infos(targets: Sequence[TargetRecord], root: Path) -> dict[int, ObjectInfo]:
    """Return an object for each class: the mean box, and the clouds of up to 200 instances, each scaled to that box.

    Args:
        targets: Labelled instances, each with its own geometry; those of training come first.
        root: Folder of the dataset.
    """
    found: dict[int, list[ObjectInfo]] = {}
    for target in targets:
        if target.geometry is not None:
            found.setdefault(target.obj_id, []).append(target.geometry)
    return {obj_id: _class_info(found[obj_id], root) for obj_id in sorted(found)}


def _class_info(instances: Sequence[ObjectInfo], root: Path) -> ObjectInfo:
    size = np.mean([item.size for item in instances], axis=0)
    few = instances[:: max(1, -(-len(instances) // _MOST_CLOUDS))]

    def read_cloud() -> Cloud:
        return np.concatenate([item.model_points() * (size / item.size) for item in few])

    return box_info(instances[0].obj_id, instances[0].name, size, root, read_cloud)


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


log = logging.getLogger(__name__)
_KEPT_FRAMES = 16
"""Sweeps and depth images that are kept: labels of one frame require them one after the other."""


class ExternalKittiReader(FileReader):
    """A KITTI folder without a manifest.

    Args:
        root: Folder with ``training`` or ``testing``.

    Raises:
        DatasetError: A list of frames is malformed.
    """

    lacks = ("masks",)
    """Boxes stand for them."""

    def __init__(self, root: Path) -> None:
        self._frames = frames_by_split(root)
        super().__init__(root, self._frames)
        self.dropped_points: dict[str, int] = {}
        """Points that were left out because they are not finite, by sweep file; of the sweeps read so far."""
        self._warned = False
        self._calibration = lru_cache(_KEPT_FRAMES)(KittiFrame.calibration)
        self._sweep = lru_cache(_KEPT_FRAMES)(self._read_sweep)
        self._depth = lru_cache(_KEPT_FRAMES)(self._read_depth)

    @cached_property
    def objects(self) -> dict[int, ObjectInfo]:
        """One object a class: its mean box, and the clouds of some of its instances."""
        targets = [target for split in self._frames for image in self.images(split) for target in image.targets]
        return class_infos(targets, self.root)

    @cached_property
    def splits(self) -> dict[str, tuple[int, ...]]:
        """Numbers of the frames of each split, which are its scenes."""
        return {name: tuple(frame.number for frame in frames) for name, frames in self._frames.items()}

    @cached_property
    def notes(self) -> tuple[str, ...]:
        """What is not in the folder and is made of what is."""
        frames = [frame for listed in self._frames.values() for frame in listed]
        made = [] if all(frame.find("depth_2", ".png") for frame in frames) else [
            "depth: projected LiDAR, the nearest point of a pixel, where depth_2 is missing"
        ]  # fmt: skip
        return (
            *made,
            "masks: pixels of the 2D box, the visible ones without those whose depth is outside the 3D box",
            "visible fraction: of the levels truncated and occluded",
            "model: cloud of the instance in its 3D box",
            "diameter: box diagonal",
        )

    def _read(self, split: str) -> list[ImageRecord]:
        """Return the images by number; frames without labels have no targets."""
        return [self._record(split, frame) for frame in self._frames[split]]

    def files(self, split: str) -> list[Path]:
        """Return every file of the frames of a split, sorted."""
        return sorted(path for frame in self._frames[split] for path in frame.files())

    def depth(self, image: ImageRecord) -> Float32[np.ndarray, "h w"]:
        """Return the depth image: that of ``depth_2``, else of the sweep; metres along the optical axis, 0 = none."""
        return self._depth(self._frame(image), image).copy()

    def mask_visible(self, image: ImageRecord, gt_index: int) -> Bool[np.ndarray, "h w"]:
        """Return the pixels of a target's 2D box, but for those whose depth lies outside its 3D box."""
        target, depth = image.targets[gt_index], self._depth(self._frame(image), image)
        mask = self.mask(image, gt_index)
        assert target.geometry is not None
        v, u = np.nonzero(mask & (depth > 0))
        points = image.camera.rays_at(u, v) * depth[v, u][:, None].astype(float)
        inside = np.abs(transform_points(invert(target.T_camera_object), points)) <= target.geometry.size / 2.0
        mask[v, u] = inside.all(axis=1)
        return mask

    def mask(self, image: ImageRecord, gt_index: int) -> Bool[np.ndarray, "h w"]:
        """Return the pixels of a target's 2D box."""
        return box_mask(image.targets[gt_index].box_amodal_xyxy, image.camera)

    def sweep(self, image: ImageRecord) -> MountedReading[LidarScan] | None:
        """Read the LiDAR's points of an image; None where there are none.

        Without ``velodyne_ids`` a point has the id of the first label whose box holds it; without ``velodyne_beams``
        rings and times are 0.
        """
        frame = self._frame(image)
        stored, T_camera_lidar = self._sweep(frame), self._calibration(frame).T_camera_lidar
        if stored is None or T_camera_lidar is None:
            return None
        ids = _ids_by_box(image, stored, T_camera_lidar) if stored.instance_ids is None else stored.instance_ids
        scan = stored.scan(ids)
        return MountedReading(T_camera_lidar, replace(scan, intensity=np.clip(scan.intensity, 0.0, 1.0)))

    def T_camera_rect(self, image: ImageRecord) -> Transform:
        """Return the pose of the rectified frame, that of labels, in the camera that took an image."""
        return self._calibration(self._frame(image)).T_camera_rect

    @cached_property
    def _numbers(self) -> dict[str, int]:
        labels = (label for frames in self._frames.values() for frame in frames for _, label in frame.labels())
        return class_numbers(label.type for label in labels)

    def _record(self, split: str, frame: KittiFrame) -> ImageRecord:
        found, T_world_rect = self._calibration(frame), frame.T_world_rect()
        T_rect_camera = invert(found.T_camera_rect)
        targets = [
            self._target(frame, found, index, instance_id, label)
            for index, (instance_id, label) in enumerate(frame.labels())
        ]
        return ImageRecord(
            split=split,
            scene_id=frame.number,
            image_id=0,
            camera=found.camera,
            T_world_camera=np.eye(4) if T_world_rect is None else T_world_rect @ T_rect_camera,
            depth_scale=1000.0 / STEPS_PER_METRE,
            targets=tuple(targets),
        )

    def _target(
        self, frame: KittiFrame, found: FrameCalibration, index: int, instance_id: int, label: KittiLabel
    ) -> TargetRecord:
        height, width, length = label.size_hwl
        size, T_camera_box = np.array([length, width, height]), found.T_camera_rect @ label.T_camera_object()
        read = partial(self._cloud, frame, T_camera_box, size)
        info = box_info(self._numbers[label.type], label.type, size, self.root, read)
        return target_record(index, instance_id, label, T_camera_box, info)

    def _cloud(
        self, frame: KittiFrame, T_camera_box: Transform, size: Float[np.ndarray, " 3"]
    ) -> Float[np.ndarray, "n 3"]:
        """Return the points of a frame's sweep in a box, in its frame."""
        stored, T_camera_lidar = self._sweep(frame), self._calibration(frame).T_camera_lidar
        if stored is None or T_camera_lidar is None:
            raise DatasetError(
                f"{frame.folder / 'velodyne'}: there is no sweep of frame {frame.name}, or calib lacks Tr_velo_to_cam; "
                "without CAD the points in a box are the model of what stands there"
            )
        return points_in_box(stored.points.astype(float), invert(T_camera_box) @ T_camera_lidar, size)

    def _read_sweep(self, frame: KittiFrame) -> StoredSweep | None:
        stored = read_sweep(frame)
        if stored is not None and stored.dropped:
            self.dropped_points[f"{frame.folder.name}/velodyne/{frame.name}.bin"] = stored.dropped
            log.warning("%s: left out %d points of frame %s, not finite", self.root, stored.dropped, frame.name)
        return stored

    def _read_depth(self, frame: KittiFrame, image: ImageRecord) -> Float32[np.ndarray, "h w"]:
        path = frame.find("depth_2", ".png")
        if path is not None:
            return require_size(decode_depth(path), image, "depth_2").astype(np.float32) / np.float32(STEPS_PER_METRE)
        stored, T_camera_lidar = self._sweep(frame), self._calibration(frame).T_camera_lidar
        if stored is None or T_camera_lidar is None:
            raise DatasetError(
                f"{frame.folder}: frame {frame.name} has neither depth_2 nor a sweep with Tr_velo_to_cam to make a "
                "depth image of; training and scoring need one"
            )
        if not self._warned:
            log.warning("%s: no depth_2; depth images are the sweeps, projected (nearest point of a pixel)", self.root)
            self._warned = True
        return sweep_depth(image.camera, transform_points(T_camera_lidar, stored.points.astype(float)))

    def _file(self, image: ImageRecord, kind: str) -> Path:
        return self._frame(image).image()

    def _frame(self, image: ImageRecord) -> KittiFrame:
        return self._by_number[image.split][image.scene_id]

    @cached_property
    def _by_number(self) -> dict[str, dict[int, KittiFrame]]:
        return {name: {frame.number: frame for frame in frames} for name, frames in self._frames.items()}


def _ids_by_box(image: ImageRecord, stored: StoredSweep, T_camera_lidar: Transform) -> Int32[np.ndarray, " n"]:
    points, ids = stored.points.astype(float), np.zeros(len(stored.points), dtype=np.int32)
    for target in reversed(image.targets):
        assert target.geometry is not None
        in_box = np.abs(transform_points(invert(target.T_camera_object) @ T_camera_lidar, points))
        ids[(in_box <= target.geometry.size / 2.0).all(axis=1)] = target.instance_id
    return ids
