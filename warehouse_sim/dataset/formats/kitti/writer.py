"""The KITTI object detection format, strict enough for OpenPCDet, mmdet3d, Open3D-ML, torchvision and the devkit."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from warehouse_sim.dataset.files.image_io import encode_clean_depth, encode_depth, encode_disparity, encode_rgb
from warehouse_sim.dataset.formats.built_in import EachWriter, WriterBase, remove_file
from warehouse_sim.dataset.formats.kitti import (
    NAME,
    STEPS_PER_METRE,
    frames_of,
    kitti_kinds,
    kitti_layout,
    require_level,
)
from warehouse_sim.dataset.formats.kitti.reader import CALIB_KEYS, LARGEST_TILT, label_rows
from warehouse_sim.dataset.formats.observation_files import ObservationFiles
from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.dataset.split import SPLITS, Split
from warehouse_sim.dataset.stored.observation_record import lidar_leans
from warehouse_sim.dataset.stored.recipe_contents import lidar_tilts
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.lens import Fisheye, Lens
from warehouse_sim.geometry.level_view import upright
from warehouse_sim.geometry.pose import Transform, invert, make_transform, rotation_x, rotation_y
from warehouse_sim.output import make_folder, write_bytes
from warehouse_sim.schema import LIDAR, LidarScan, MountedReading, ObjectModel, Observation, SceneSpec


def calib_text(camera: PinholeCamera, T_camera_lidar: Transform, baseline: float = 0.0) -> str:
    """Return the seven lines of a calib file; behind a lens two more for each camera.

    The left camera serves as P0 and P2, so that its frame is the reference frame of the labels, the right one as P1 and
    P3; without a right camera the one serves as all four. The IMU is the LiDAR. A lens does not fit into P2, which is
    that of the pinhole: K_02 and D_02 (k1 k2 p1 p2 k3) follow, as in KITTI's calib_cam_to_cam.txt, K_03 and D_03 too.
    A fisheye has F_02 (k1 k2 k3 k4) in place of D_02.

    Args:
        camera: Intrinsics of both cameras.
        T_camera_lidar: Pose of the main LiDAR in the left camera's frame.
        baseline: From the left camera to the right one (m); 0 = there is none.
    """
    left = np.hstack([camera.K, np.zeros((3, 1))])
    right = np.hstack([camera.K, [[-camera.fx * baseline], [0.0], [0.0]]])
    values = (left, right, left, right, np.eye(3), T_camera_lidar[:3], np.eye(4)[:3])
    text = "".join(f"{key}: {_row(matrix)}\n" for key, matrix in zip(CALIB_KEYS, values, strict=True))
    if camera.distortion is None:
        return text
    lens = "F" if isinstance(camera.distortion, Fisheye) else "D"
    rows = {"K": _row(camera.K), lens: _row(np.array(camera.distortion.coefficients))}
    names = [f"{key}_{eye}" for eye in (("02", "03") if baseline else ("02",)) for key in ("K", lens)]
    return text + "".join(f"{name}: {rows[name[0]]}\n" for name in names)


def lidars_text(lidars: Mapping[str, MountedReading[LidarScan]]) -> str:
    """Return the poses of further LiDARs, one line ``Tr_NAME_to_cam:`` with 3 x 4 numbers each."""
    return "".join(f"Tr_{name}_to_cam: {_row(item.T_camera_sensor[:3])}\n" for name, item in lidars.items())


def plane_text(T_world_camera: Transform) -> str:
    """Return the floor as a x + b y + c z + d = 0 in the camera frame, (a, b, c) up, d the height in m."""
    a, b, c = invert(T_world_camera)[:3, 2] + 0.0
    row = " ".join(f"{value:.9e}" for value in (a, b, c, T_world_camera[2, 3]))
    return f"# Plane\nWidth 4\nHeight 1\n{row}\n"


def _row(matrix: np.ndarray) -> str:
    return " ".join(f"{value:.12e}" for value in (matrix + 0.0).ravel())


def level_sweep(observation: Observation) -> MountedReading[LidarScan]:
    """Return the main sweep with the pose of its frame in the camera's.

    The frame is the LiDAR's own unless that leans by more than 2 deg: then it is at the same place with its z axis up,
    and the points, in their order, are turned into it.
    """
    mounted = observation.readings[LIDAR]
    scan = mounted.reading
    assert isinstance(scan, LidarScan)
    if not lidar_leans(observation.T_world_lidar):
        return MountedReading(mounted.T_camera_sensor, scan)
    T_world_level = upright(observation.T_world_lidar)
    R_level_lidar = T_world_level[:3, :3].T @ observation.T_world_lidar[:3, :3]
    points = (scan.points.astype(float) @ R_level_lidar.T).astype(np.float32)
    return MountedReading(invert(observation.T_world_camera) @ T_world_level, replace(scan, points=points))


def may_lean(manifest: Manifest) -> bool:
    """Return whether the main LiDAR of a recipe leans, or tilts with a camera that may be tilted."""
    contents = manifest.contents
    if contents.lidar is None:
        return False
    pitch, roll = np.deg2rad([contents.lidar.pitch_deg, contents.lidar.roll_deg])
    mounted = make_transform(rotation_y(-pitch) @ rotation_x(roll))
    return lidar_leans(mounted) or bool(contents.tilted_viewpoints and lidar_tilts(manifest.recipe))


_README = """# Dataset in the KITTI object detection format

- Frame = scene * {per_scene} + observation. Train and validation frames are in training/, test frames in testing/, both
  with labels.
- Labels name every target with at least one visible pixel. Length is the object's x axis, width its y axis.
- truncated: fraction of the amodal mask's pixels outside the image. occluded: 0 if at least 90 % of what lies inside
  the image is visible, 1 if at least 50 %, else 2. bbox: whole amodal mask, occluded parts included, cut at the image.
- A target that leans by more than {tilt:g} deg is no upright box: it comes after the others, as DontCare with its 2D
  box. label_2_ids (our own) holds the instance id of each row of label_2, also of those; ../scenes/ has their poses.
- A frame without labels holds one DontCare row (id 0), because some readers stop at an empty file.
- depth_2: 16 bit, metres * 256, 0 = no reading. planes: the floor in the camera frame.
- velodyne: float32 x, y, z, reflectance. velodyne_ids (our own): int32, the instance id of each point, 0 = none; the
  ids are those of ../scenes/. velodyne_beams (our own): float32 ring, time of each point; ring 0 is the topmost beam,
  time counts from the start of the sweep (s).
- {cameras}; Tr_imu_to_velo is the identity.
- Class names are ours: set CLASS_NAMES (and POINT_CLOUD_RANGE, for a warehouse) in your reader's configuration.
{additions}"""
_ONE_CAMERA, _TWO_CAMERAS = "P0 to P3 are the same camera", "P0 and P2 are the left camera, P1 and P3 the right one"
_STEREO_README = """\
- image_3: the right camera. disp_occ: true disparity of image_2, also where image_3 does not see it. disp_noc: where it
  does. disp_sgbm, if there: what semi-global matching finds in the noisy pair. 16 bit, pixels * 256, 0 = none, or 256
  and more.
"""
_LEVEL_README = """\
- The rig's camera is tilted. A box here knows one angle, so that every frame is that of a level virtual camera at the
  same place with the same heading: image_2, depth_2, labels, calib and planes are its own. Its images are rendered, not
  resampled, hold all that the tilted camera shows, and have sizes and principal points of their own. ../scenes/ and
  ../bop/ hold the true camera. velodyne is the true sweep, and Tr_velo_to_cam leads into the level camera.
"""
_LENS_README = """\
- Images are not rectified: P2 is that of the pinhole, and calib goes on after its seven lines with K_02 and D_02, k1 k2
  p1 p2 k3 as in OpenCV and in KITTI's raw calib_cam_to_cam.txt (with a right camera K_03 and D_03, too). Labels, boxes
  and depth are those of the image; readers that know P2 only must rectify it first. Disparities are those of the
  rectified pair, f b / z with the f of P2, stored at the pixels of image_2.
"""
_FISHEYE_README = """\
- Images are those of a fisheye: P2 is that of its K, and calib goes on after its seven lines with K_02 and F_02, k1 k2
  k3 k4 as in OpenCV's fisheye (with a right camera K_03 and F_03, too). Labels, boxes and depth are of the image;
  readers that know P2 only must rectify it first. Disparities are f b / z with the f of P2, at the pixels of image_2.
"""
_CLEAN_README = """\
- image_clean_2, depth_clean_2 (our own): image_2 and depth_2 without errors of the camera{right}; a clean depth that
  does not fit into 16 bits is 0.
"""
_LEANING_README = """\
- The LiDAR may lean. Readers take its z axis for vertical: where it leans by more than 2 deg, velodyne holds its points
  turned into a frame at its place whose z axis is up, and Tr_velo_to_cam leads on from there. Order, rings, times and
  ids are those of the sweep. ../scenes/ has its true pose, T_camera_lidar, in the frame of the true camera.
"""
_LIDARS_README = """\
- velodyne_NAME, velodyne_NAME_ids: further LiDARs ({names}), each in its own frame; calib_lidars (our own) holds their
  poses, Tr_NAME_to_cam, as calib does of the main one.
"""


class KittiWriter(WriterBase):
    """Write frames as ``kitti/{training,testing}/KIND/%06d.*``."""

    def __init__(self, root: Path, manifest: Manifest) -> None:
        super().__init__(root, manifest)
        self._layout = kitti_layout(root)
        self._kinds = kitti_kinds(manifest.contents)

    def begin(self, models: Sequence[ObjectModel], camera: PinholeCamera) -> None:
        """Make the folders and write the lists of frames."""
        for split in SPLITS:
            for kind in self._kinds:
                make_folder(self._layout.folder(split) / kind)
        self._list_frames()
        write_bytes(self._layout.root / "README.md", self._readme().encode("ascii"), durable=True)

    def _list_frames(self) -> None:
        sets: dict[str, tuple[Split, ...]] = {name: (name,) for name in SPLITS}
        sets["trainval"] = ("train", "val")
        make_folder(self._layout.image_set("train").parent)
        for name, parts in sets.items():
            frames = [
                frame
                for part in parts
                for scene in self._manifest.splits[part]
                for frame in frames_of(self._manifest, scene)
            ]
            text = "".join(f"{frame:06d}\n" for frame in frames)
            write_bytes(self._layout.image_set(name), text.encode("ascii"), durable=True)

    def scene(self, scene: SceneSpec) -> EachWriter:
        """Open a scene again."""
        split = self._manifest.split_of(scene.scene_index)
        frames = frames_of(self._manifest, scene.scene_index)
        for path in (self._layout.file(split, kind, frame) for frame in frames for kind in self._kinds):
            remove_file(path)
        return EachWriter(partial(self._write, split, frames))

    def _write(self, split: Split, frames: range, files: ObservationFiles) -> None:
        """Write one frame.

        Raises:
            DatasetError: The camera is tilted, the LiDAR is missing, or a depth does not fit.
        """
        files = files.levelled
        observation = files.observation
        where = f"KITTI, scene {observation.scene_index}, observation {observation.observation_index}"
        if observation.lidar is None:
            raise DatasetError(f"{where}: there is no LiDAR; give the recipe one, or leave kitti out of --formats")
        require_level(observation, where)
        lidar = level_sweep(observation)
        rows, ids = label_rows([target.annotation for target in files.targets], observation.camera, where)
        baseline = 0.0 if observation.stereo is None else observation.stereo.baseline
        clean = self._manifest.contents.clean
        contents = {
            "depth_2": encode_depth(observation.rgbd.depth, STEPS_PER_METRE, where),
            "velodyne": point_bytes(lidar.reading),
            "velodyne_ids": lidar.reading.instance_ids.astype("<i4").tobytes(),
            "velodyne_beams": beam_bytes(lidar.reading),
            "calib": calib_text(observation.camera, lidar.T_camera_sensor, baseline).encode("ascii"),
            "label_2": _lines(rows),
            "label_2_ids": _lines(map(str, ids)),
            "planes": plane_text(observation.T_world_camera).encode("ascii"),
            **_stereo_files(observation),
            **_more_lidar_files(observation),
            **(_clean_files(observation) if clean else {}),
        }
        frame = frames[observation.observation_index]
        files.rgb.save(self._layout.file(split, "image_2", frame))
        if clean:
            files.rgb_clean.save(self._layout.file(split, "image_clean_2", frame))
        for kind, content in contents.items():
            write_bytes(self._layout.file(split, kind, frame), content)

    def finish(self) -> None:
        """Write the lists of frames again: scenes may be missing in the end."""
        self._list_frames()

    def _readme(self) -> str:
        contents = self._manifest.contents
        stereo, names = contents.baseline is not None, ", ".join(contents.lidars)
        return _README.format(
            per_scene=self._manifest.observations_per_scene,
            tilt=math.degrees(LARGEST_TILT),
            cameras=_TWO_CAMERAS if stereo else _ONE_CAMERA,
            additions=(_STEREO_README if stereo else "")
            + (_LEVEL_README if NAME in contents.levelled else _lens_text(contents.distortion))
            + (_CLEAN_README.format(right="; so is image_clean_3" if stereo else "") if contents.clean else "")
            + (_LEANING_README if may_lean(self._manifest) else "")
            + (_LIDARS_README.format(names=names) if names else ""),
        )


def _lens_text(lens: Lens | None) -> str:
    if lens is None:
        return ""
    return _FISHEYE_README if isinstance(lens, Fisheye) else _LENS_README


def _lines(rows: Iterable[str]) -> bytes:
    return "".join(f"{row}\n" for row in rows).encode("ascii")


def _stereo_files(observation: Observation) -> dict[str, bytes]:
    """Return the files of the right camera by kind."""
    stereo = observation.stereo
    if stereo is None:
        return {}
    contents = {
        "image_3": encode_rgb(stereo.rgb),
        "disp_occ": encode_disparity(stereo.disparity),
        "disp_noc": encode_disparity(np.where(stereo.in_both, stereo.disparity, np.float32(0.0))),
    }
    return contents if stereo.matched is None else contents | {"disp_sgbm": encode_disparity(stereo.matched)}


def _clean_files(observation: Observation) -> dict[str, bytes]:
    """Return what no format fractions of the clean ground truth by kind."""
    contents = {"depth_clean_2": encode_clean_depth(observation.buffers.depth, STEPS_PER_METRE)}
    stereo = observation.stereo
    return contents if stereo is None else contents | {"image_clean_3": encode_rgb(stereo.buffers.rgb)}


def _more_lidar_files(observation: Observation) -> dict[str, bytes]:
    """Return the files of the LiDARs beside the main one by kind."""
    if not observation.lidars:
        return {}
    contents = {"calib_lidars": lidars_text(observation.lidars).encode("ascii")}
    for name, item in observation.lidars.items():
        contents[f"velodyne_{name}"] = point_bytes(item.reading)
        contents[f"velodyne_{name}_ids"] = item.reading.instance_ids.astype("<i4").tobytes()
    return contents


def point_bytes(scan: LidarScan) -> bytes:
    """Return KITTI's velodyne content: little-endian float32 x, y, z (m, LiDAR frame) and reflectance, 0-1."""
    rows = np.empty((len(scan.points), 4), "<f4")
    rows[:, :3], rows[:, 3] = scan.points, scan.intensity
    return rows.tobytes()


def beam_bytes(scan: LidarScan) -> bytes:
    """Return little-endian float32 ring and time (s since the sweep began) of each point."""
    return np.stack([scan.ring.astype("<f4"), scan.time.astype("<f4")], axis=1).tobytes()
