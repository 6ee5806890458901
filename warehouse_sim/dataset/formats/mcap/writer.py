"""Write each scene as one MCAP file with Foxglove's schemas: what a recorder on the vehicle would have written."""

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.Log_pb2 import Log

from warehouse_sim.dataset.files.image_io import encode_rgb
from warehouse_sim.dataset.files.plain import plain
from warehouse_sim.dataset.files.point_table import classes_of, sweep_table, sweeps_of
from warehouse_sim.dataset.formats.mcap import layout as names
from warehouse_sim.dataset.formats.mcap.boxes import boxes_message, image_boxes_message
from warehouse_sim.dataset.formats.mcap.clock import SceneClock
from warehouse_sim.dataset.formats.mcap.clouds import cloud_message
from warehouse_sim.dataset.formats.mcap.file import McapFile
from warehouse_sim.dataset.formats.mcap.images import calibration_message, depth_message, image_message
from warehouse_sim.dataset.formats.mcap.layout import RIG, WORLD, mcap_layout, topic
from warehouse_sim.dataset.formats.mcap.plain_messages import timestamp, transform
from warehouse_sim.dataset.formats.mcap.readings import reading_message, reading_schema
from warehouse_sim.dataset.formats.observation_files import ObservationFiles
from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.dataset.stored.readings import other_readings
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import invert
from warehouse_sim.output import make_folder, partial_file, write_bytes, writing
from warehouse_sim.schema import CAMERA, RIGHT, ObjectModel, Observation, SceneSpec

_FIRST = "base"
"""The variant whose topics have no name before them."""
_README = """# One MCAP file a scene: {train,val,test}/SSSSSS.mcap

- Opens in Foxglove, and in Rerun. Messages are Foxglove's, in protobuf: /camera/image (PNG), /camera/depth (metres),
  /camera/calibration, /camera/boxes, /LIDAR/points, /objects (boxes of labelled objects in the camera's frame),
  /conditions, /tf (world, rig, camera, then each sensor). /SENSOR/reading is JSON with its schema.
- Stamps are no real times: scene K begins at 2000-01-01 00:00 UTC + K hours. Within a drive they go with the vehicle;
  single views are 1 s apart. Paired variants have the stamp of their first one and topics under /VARIANT.
- Pixel centres are integers in calibrations; boxes on images count from the outer corner of the first pixel, as
  Foxglove does.
"""


class McapWriter:
    """Write scenes as ``mcap/{train,val,test}/%06d.mcap``."""

    def __init__(self, root: Path, manifest: Manifest) -> None:
        self._manifest, self._layout = manifest, mcap_layout(root)

    def begin(self, models: Sequence[ObjectModel], camera: PinholeCamera) -> None:
        """Make the folders and write the description."""
        for split in self._manifest.splits:
            make_folder(self._layout.root / split)
        write_bytes(self._layout.root / "README.md", _README.encode("ascii"), durable=True)

    def scene(self, scene: SceneSpec) -> "McapSceneWriter":
        """Open a scene again."""
        split = self._manifest.split_of(scene.scene_index)
        path = self._layout.scene(split, scene.scene_index)
        make_folder(path.parent)
        for old in (path, partial_file(path)):
            with writing(old):
                old.unlink(missing_ok=True)
        about = {"recipe": self._manifest.contents.name, "seed": str(self._manifest.seed), "split": split}
        return McapSceneWriter(McapFile(path, about | {"scene": str(scene.scene_index)}), scene, self._manifest)

    def finish(self) -> None:
        """Do nothing: no file of this format needs all scenes."""


class McapSceneWriter:
    """Write the messages of one scene."""

    def __init__(self, file: McapFile, scene: SceneSpec, manifest: Manifest) -> None:
        self._file, self._scene, self._clock = file, scene, SceneClock(scene.scene_index)
        self._kinds = manifest.contents.sensors
        self._last: int | None = None

    def write(self, files: ObservationFiles) -> None:
        """Write what was read at one observation."""
        observation = files.observation
        stamp, prefix = self._clock.stamp(observation), _prefix(observation)
        labels = [target.annotation for target in files.targets]
        classes = classes_of(self._scene, observation.annotations)
        if stamp != self._last:
            self._last = stamp
            self._file.add(names.TRANSFORMS, stamp, _transforms(stamp, observation))
        messages = {
            topic(CAMERA, names.CALIBRATION): calibration_message(stamp, CAMERA, observation.camera),
            topic(CAMERA, names.IMAGE): image_message(stamp, CAMERA, files.rgb.data),
            topic(CAMERA, names.DEPTH): depth_message(stamp, CAMERA, observation.rgbd.depth),
            topic(CAMERA, names.BOXES): image_boxes_message(stamp, labels),
            names.OBJECTS: boxes_message(stamp, CAMERA, labels),
            names.CONDITIONS: _conditions(stamp, observation),
        }
        if observation.stereo is not None:
            right = calibration_message(stamp, RIGHT, observation.camera, observation.stereo.baseline)
            messages[topic(RIGHT, names.CALIBRATION)] = right
            messages[topic(RIGHT, names.IMAGE)] = image_message(stamp, RIGHT, encode_rgb(observation.stereo.rgb))
        for name, item in sweeps_of(observation).items():
            messages[topic(name, names.POINTS)] = cloud_message(stamp, name, sweep_table(item.reading, classes))
        for where, message in messages.items():
            self._file.add(prefix + where, stamp, message)
        self._write_readings(stamp, prefix, observation)

    def finish(self) -> None:
        """Close the file."""
        self._file.finish()

    def _write_readings(self, stamp: int, prefix: str, observation: Observation) -> None:
        for name, item in sorted(other_readings(observation).items()):
            self._file.add_json(
                prefix + topic(name, names.READING),
                stamp,
                # One schema a sensor: two of a kind may have channels of their own.
                f"warehouse_sim.{self._kinds.get(name, name)}.{name}",
                reading_schema(item.reading),
                reading_message(stamp, name, item.reading),
            )


def _prefix(observation: Observation) -> str:
    """Return what stands before the topics of a paired variant."""
    variant = observation.conditions.variant
    return "" if variant == _FIRST else f"/{variant}"


def _transforms(stamp: int, observation: Observation) -> FrameTransforms:
    """Return the tree of frames: the world, the rig (the vehicle's frame, or the camera's), the camera, each sensor."""
    view, T_world_camera = observation.viewpoint, observation.T_world_camera
    vehicle = None if view is None else view.T_world_vehicle
    T_world_rig = T_world_camera if vehicle is None else vehicle
    T_rig_camera = np.eye(4) if vehicle is None else invert(vehicle) @ T_world_camera
    found = [transform(stamp, WORLD, RIG, T_world_rig), transform(stamp, RIG, CAMERA, T_rig_camera)]
    for name, item in sorted(observation.readings.items()):
        if name != CAMERA:
            found.append(transform(stamp, CAMERA, name, item.T_camera_sensor))
    return FrameTransforms(transforms=found)


def _conditions(stamp: int, observation: Observation) -> Log:
    view = observation.viewpoint
    words = vars(observation.conditions) | {"observation": observation.observation_index}
    if view is not None:
        words |= {"kind": view.kind, "sequence": view.sequence, "time": view.time}
        words |= {"velocity": view.velocity, "yaw_rate": view.yaw_rate}
    text = json.dumps(plain(words), allow_nan=False)
    return Log(timestamp=timestamp(stamp), level=Log.INFO, name=names.NAME, message=text)
