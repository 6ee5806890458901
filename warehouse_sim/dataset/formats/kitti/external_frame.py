"""One frame of a KITTI folder made by third parties: its camera, labels, sweep and images."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float, Float32

from warehouse_sim.dataset.files.image_io import image_size_wh
from warehouse_sim.dataset.formats.kitti import frames_of, kitti_layout
from warehouse_sim.dataset.formats.kitti.reader import KittiLabel, calib_camera
from warehouse_sim.dataset.formats.kitti.tolerant import (
    has_box,
    read_calib,
    read_labels,
    read_plane,
    read_text,
    rigid,
)
from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.dataset.records import ImageRecord
from warehouse_sim.errors import DatasetError, shown
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.level_view import levelled
from warehouse_sim.geometry.pose import Transform, invert, make_transform
from warehouse_sim.schema import LidarScan, MountedReading


def stored_sweep(root: Path, manifest: Manifest, image: ImageRecord) -> MountedReading[LidarScan]:
    """Read the sweep of an image, with ids, rings and times, and where its sensor was in the rig's own camera.

    KITTI's calibration leads into the level camera, which has the place and the heading of the rig's.

    Raises:
        DatasetError: A file is missing or malformed.
    """
    number = frames_of(manifest, image.scene_id)[image.image_id]
    frame = KittiFrame(kitti_layout(root).folder(image.split), f"{number:06d}")
    stored, T_level_lidar = read_sweep(frame), frame.calibration().T_camera_lidar
    if stored is None or stored.instance_ids is None or stored.beams is None or T_level_lidar is None:
        raise DatasetError(f"{frame.folder}: frame {frame.name} lacks velodyne, its ids, its beams or its calibration")
    T_camera_level = invert(image.T_world_camera) @ levelled(image.T_world_camera)
    return MountedReading(T_camera_level @ T_level_lidar, stored.scan(stored.instance_ids))


_NEAREST = 0.1
"""Depth (m) below which a point is not before the camera."""


def sweep_depth(camera: PinholeCamera, points: Float[np.ndarray, "n 3"]) -> Float32[np.ndarray, "h w"]:
    """Return depth along the optical axis (m) at the pixels that points fall on, the nearest of each; 0 elsewhere.

    Args:
        camera: Of the image.
        points: In the camera frame (m).
    """
    ahead = points[points[:, 2] > _NEAREST]
    depth = np.full((camera.height, camera.width), np.inf, dtype=np.float32)
    low_x, high_x, low_y, high_y = camera.tangent_bounds()
    x, y = ahead[:, 0] / ahead[:, 2], ahead[:, 1] / ahead[:, 2]
    # A lens is defined where the image is: beyond, its polynomial may lead back into it.
    seen = ahead[(x >= low_x) & (x <= high_x) & (y >= low_y) & (y <= high_y)]
    at = np.rint(camera.project(seen)).astype(int)
    inside = ((at >= 0) & (at < [camera.width, camera.height])).all(axis=1)
    np.minimum.at(depth, (at[inside, 1], at[inside, 0]), seen[inside, 2].astype(np.float32))
    return np.where(np.isinf(depth), np.float32(0.0), depth)


_IMAGES = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp")
_POINT_BYTES, _LARGEST_SWEEP = 16, 16_000_000
"""Bytes of a point; points of a sweep: an HDL-64E has 120,000."""
_FARTHEST_CAMERA = 10.0
"""How far camera 2 may be from the rectified frame's origin (m)."""


@dataclass(frozen=True, eq=False)
class FrameCalibration:
    """Where everything of a frame is, in the frame of camera 2, which is not that of the labels."""

    camera: PinholeCamera
    T_camera_rect: Transform
    """Pose of the rectified frame that labels and planes are in; KITTI's camera 2 is 6 cm beside it."""
    T_camera_lidar: Transform | None
    """None where the file has no Tr_velo_to_cam."""


@dataclass(frozen=True)
class KittiFrame:
    """Files of a frame; ``folder`` is training or testing, ``name`` its digits."""

    folder: Path
    name: str

    @property
    def number(self) -> int:
        """Its number."""
        return int(self.name)

    def find(self, kind: str, *endings: str) -> Path | None:
        """Return the file of a kind with the first of these endings that there is."""
        paths = (self.folder / kind / f"{self.name}{ending}" for ending in endings)
        return next((path for path in paths if path.is_file()), None)

    def files(self) -> list[Path]:
        """Return every file that is read of it, sorted."""
        kinds: dict[str, tuple[str, ...]] = {"image_2": _IMAGES, "depth_2": (".png",)}
        kinds |= dict.fromkeys(("calib", "label_2", "label_2_ids", "planes"), (".txt",))
        kinds |= dict.fromkeys(("velodyne", "velodyne_ids", "velodyne_beams"), (".bin",))
        return sorted(path for kind, endings in kinds.items() if (path := self.find(kind, *endings)))

    def image(self) -> Path:
        """Return the colour or grey image.

        Raises:
            DatasetError: There is none.
        """
        found = self.find("image_2", *_IMAGES)
        if found is None:
            raise DatasetError(
                f"{self.folder / 'image_2'}: there is no image of frame {self.name}; copy it, or take the frame out of "
                "ImageSets"
            )
        return found

    def calibration(self) -> FrameCalibration:
        """Read the calib file.

        Raises:
            DatasetError: It is missing or malformed, or P2 is that of no camera.
        """
        path = self.folder / "calib" / f"{self.name}.txt"
        matrices, where = read_calib(read_text(path), str(path)), f"{path}: P2"
        P2 = matrices["P2"]
        K = P2[:, :3]
        if not (min(K[0, 0], K[1, 1]) > 0 and np.allclose(K[[0, 1, 2, 2], [1, 0, 0, 1]], 0.0) and K[2, 2] == 1.0):
            raise DatasetError(f"{where}: is no pinhole without skew: {shown(K.ravel().tolist())}")
        beside = np.linalg.solve(K, P2[:, 3])
        if not np.abs(beside).max() <= _FARTHEST_CAMERA:
            raise DatasetError(f"{where}: puts the camera {beside.tolist()} m beside the rectified frame")
        T_camera_rect, T_rect_lidar = make_transform(None, beside), None
        if "Tr_velo_to_cam" in matrices:
            R0 = matrices.get("R0_rect", np.eye(3))
            T_rect_lidar = rigid(R0, f"{path}: R0_rect") @ rigid(matrices["Tr_velo_to_cam"], f"{path}: Tr_velo_to_cam")
        camera = calib_camera(matrices, image_size_wh(self.image()))
        return FrameCalibration(camera, T_camera_rect, None if T_rect_lidar is None else T_camera_rect @ T_rect_lidar)

    def labels(self) -> list[tuple[int, KittiLabel]]:
        """Return the rows with a 3D box and the instance id of each, as ``rows`` does."""
        return [(number, row) for number, row in self.rows() if has_box(row)]

    def rows(self) -> list[tuple[int, KittiLabel]]:
        """Return the rows and the instance id of each; none in a frame without labels.

        Ids are those of ``label_2_ids``, else rows are numbered from 1.

        Raises:
            DatasetError: A row or an id is malformed.
        """
        path = self.find("label_2", ".txt")
        rows = [] if path is None else read_labels(read_text(path), str(path))
        return list(zip(self._ids(len(rows)) or range(1, len(rows) + 1), rows, strict=True))

    def T_world_rect(self) -> Transform | None:
        """Return where the rectified frame is over its plane, z up; None where the frame has none.

        The world's origin is on the plane below it, x is the way that the camera looks.
        """
        path = self.find("planes", ".txt")
        if path is None:
            return None
        a, b, c, height = read_plane(read_text(path), str(path))
        up = np.array([a, b, c])
        ahead = np.array([0.0, 0.0, 1.0]) - up * c
        if height <= 0.0 or np.linalg.norm(ahead) < 1e-6:
            raise DatasetError(f"{path}: the floor is {height:.6g} m below the camera, or straight ahead of it")
        ahead /= np.linalg.norm(ahead)
        return make_transform(np.stack([ahead, np.cross(up, ahead), up]), np.array([0.0, 0.0, height]))

    def _ids(self, count: int) -> list[int]:
        path = self.find("label_2_ids", ".txt")
        words = [] if path is None else read_text(path).split()
        if not all(word.isdecimal() and len(word) < 11 for word in words) or len(words) not in (0, count):
            raise DatasetError(f"{path}: must hold the id of each of {count} labels, found {shown(words)}")
        return [int(word) for word in words]


@dataclass(frozen=True, eq=False)
class StoredSweep:
    """A velodyne file with what stands beside it of each point."""

    points: Float32[np.ndarray, "n 3"]
    """LiDAR frame (m)."""
    intensity: Float32[np.ndarray, " n"]
    instance_ids: np.ndarray | None
    """Of each point; None where the folder has none."""
    beams: np.ndarray | None
    """Ring and time (s), "n 2"; None where the folder has none."""
    dropped: int
    """Points of the file that were left out because a number of theirs is not finite."""

    def scan(self, instance_ids: np.ndarray) -> LidarScan:
        """Return the sweep of points with these ids; without beams rings and times are 0."""
        ring, time = np.zeros((2, len(self.points)), "f4") if self.beams is None else self.beams.T
        ids, rings = instance_ids.astype(np.int32), np.rint(ring).astype(np.int32)
        return LidarScan(self.points, self.intensity, ids, rings, time.astype(np.float32))


def read_sweep(frame: KittiFrame, name: str = "velodyne") -> StoredSweep | None:
    """Read a frame's sweep; points with NaN or infinity are left out and counted. None where there is no file.

    Args:
        frame: The frame.
        name: Folder of the LiDAR's points.

    Raises:
        DatasetError: A file is too large or is not whole, or what stands beside it is not of as many points.
    """
    path = frame.find(name, ".bin")
    if path is None:
        return None
    cloud = _floats(path, 4, None)
    keep = np.isfinite(cloud).all(axis=1)
    ids_path, beams_path = (frame.find(f"{name}_{kind}", ".bin") for kind in ("ids", "beams"))
    ids = None if ids_path is None else _floats(ids_path, 1, len(cloud)).view("<i4")[:, 0]
    beams = None if beams_path is None else _floats(beams_path, 2, len(cloud))
    sweep = StoredSweep(cloud[:, :3], cloud[:, 3], ids, beams, int((~keep).sum()))
    return sweep if sweep.dropped == 0 else _chosen(sweep, keep)


def _chosen(sweep: StoredSweep, keep: Bool[np.ndarray, " n"]) -> StoredSweep:
    ids, beams = (None if item is None else item[keep] for item in (sweep.instance_ids, sweep.beams))
    return replace(sweep, points=sweep.points[keep], intensity=sweep.intensity[keep], instance_ids=ids, beams=beams)


def _floats(path: Path, columns: int, count: int | None) -> Float32[np.ndarray, "n columns"]:
    size = path.stat().st_size
    if size % (4 * columns) or size > _LARGEST_SWEEP * _POINT_BYTES or count not in (None, size // (4 * columns)):
        wanted = "whole rows" if count is None else f"{count} rows, as there are points,"
        raise DatasetError(f"{path}: {size} bytes are not {wanted} of {columns} 32-bit numbers; copy it again")
    return np.fromfile(path, "<f4").reshape(-1, columns)


def points_in_box(
    points: Float[np.ndarray, "n 3"], T_box_points: Transform, size: Float[np.ndarray, " 3"]
) -> Float[np.ndarray, "k 3"]:
    """Return those points that lie in a box, in its own frame (origin in its centre), borders included."""
    inside = points @ T_box_points[:3, :3].T + T_box_points[:3, 3]
    kept: Float[np.ndarray, "k 3"] = inside[(np.abs(inside) <= size / 2.0).all(axis=1)]
    return kept
