"""Write each scene as one MCAP file with Foxglove's schemas: what a recorder on the vehicle would have written."""

import json
import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.Log_pb2 import Log
from google.protobuf.message import Message
from mcap.well_known import MessageEncoding, SchemaEncoding
from mcap.writer import CompressionType, Writer
from mcap_protobuf.schema import build_file_descriptor_set

from warehouse_sim.config import to_mapping
from warehouse_sim.dataset.files.image_io import encode_rgb
from warehouse_sim.dataset.files.point_table import classes_of, sweep_table, sweeps_of
from warehouse_sim.dataset.formats import mcap as names
from warehouse_sim.dataset.formats.built_in import WriterBase, remove_file
from warehouse_sim.dataset.formats.mcap import RIG, WORLD, mcap_layout, topic
from warehouse_sim.dataset.formats.mcap.messages import (
    boxes_message,
    calibration_message,
    cloud_message,
    depth_message,
    image_boxes_message,
    image_message,
    reading_message,
    reading_schema,
    timestamp,
    transform,
)
from warehouse_sim.dataset.formats.observation_files import ObservationFiles
from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.dataset.stored.readings import other_readings
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import invert
from warehouse_sim.output import make_folder, partial_file, write_bytes, writing
from warehouse_sim.schema import CAMERA, RIGHT, ObjectModel, Observation, SceneSpec

EPOCH = 946_684_800
"""2000-01-01 00:00:00 UTC (s since 1970), when scene 0 begins."""
BETWEEN_SCENES = 3600
"""Each scene begins so much later than the one before (s), so that files of several scenes can be played together."""
BETWEEN_VIEWS = 1.0
"""Between two observations that are not of one drive (s)."""
_SECOND = 1_000_000_000


@dataclass
class SceneClock:
    """Gives each observation of a scene its time stamp; they must come in order.

    Within a drive stamps differ as the drive's times do. Paired variants, which show one moment in several variants,
    have one stamp. All else, single views and the first of each drive, comes ``BETWEEN_VIEWS`` after what was before.
    """

    scene_index: int
    _stamp: int | None = field(default=None, init=False)
    _drive: int | None = field(default=None, init=False)
    _paired_variants: int | None = field(default=None, init=False)
    _time: float = field(default=0.0, init=False)

    def stamp(self, observation: Observation) -> int:
        """Return the time stamp of the next observation (ns since 1970)."""
        view, paired_variants = observation.viewpoint, observation.conditions.variant_group
        drive, time = (None, 0.0) if view is None else (view.sequence, view.time)
        if self._stamp is None:
            self._stamp = (EPOCH + self.scene_index * BETWEEN_SCENES) * _SECOND
        elif paired_variants is None or paired_variants != self._paired_variants:
            goes_on = drive is not None and drive == self._drive and time > self._time
            self._stamp += round((time - self._time if goes_on else BETWEEN_VIEWS) * _SECOND)
        self._drive, self._time, self._paired_variants = drive, time, paired_variants
        return self._stamp


_LIBRARY = "warehouse-sim"
"""What wrote the file; without versions, which are in the manifest."""


class McapFile:
    """A file under a temporary name, which gets its own when it is finished.

    Args:
        path: Where it will be.
        about: Words on the whole file, stored as its metadata.

    Raises:
        OutputError: It cannot be written.
    """

    def __init__(self, path: Path, about: dict[str, str]) -> None:
        self._path, self._partial = path, partial_file(path)
        with writing(path):
            self._stream = open(self._partial, "wb")  # noqa: SIM115
            self._writer = Writer(self._stream, compression=CompressionType.ZSTD)
            self._writer.start(profile="", library=_LIBRARY)
            self._writer.add_metadata(_LIBRARY, about)
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}
        self._counts: dict[str, int] = {}

    def add(self, topic: str, stamp: int, message: Message) -> None:
        """Add a protobuf message to a topic.

        Args:
            topic: Of messages of one type.
            stamp: Time stamp (ns since 1970).
            message: The message.
        """
        if topic not in self._channels:
            self._open(topic, message.DESCRIPTOR.full_name, SchemaEncoding.Protobuf, MessageEncoding.Protobuf, message)
        self._add(topic, stamp, message.SerializeToString(deterministic=True))

    def add_json(self, topic: str, stamp: int, name: str, schema: bytes, content: bytes) -> None:
        """Add a message in JSON to a topic; ``name`` is that of its JSON schema."""
        if topic not in self._channels:
            self._open(topic, name, SchemaEncoding.JSONSchema, MessageEncoding.JSON, schema)
        self._add(topic, stamp, content)

    def finish(self) -> None:
        """Write the index and give the file its name."""
        with writing(self._path):
            self._writer.finish()
            self._stream.close()
            os.replace(self._partial, self._path)

    def _open(self, topic: str, name: str, schema_encoding: str, encoding: str, schema: Any) -> None:
        if name not in self._schemas:
            data = schema if isinstance(schema, bytes) else _described(schema)
            self._schemas[name] = self._writer.register_schema(name, schema_encoding, data)
        self._channels[topic] = self._writer.register_channel(topic, encoding, self._schemas[name])

    def _add(self, topic: str, stamp: int, data: bytes) -> None:
        count = self._counts.get(topic, 0)
        with writing(self._path):
            self._writer.add_message(self._channels[topic], stamp, data, publish_time=stamp, sequence=count)
        self._counts[topic] = count + 1


def _described(message: Message) -> bytes:
    content: bytes = build_file_descriptor_set(type(message)).SerializeToString(deterministic=True)
    return content


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


class McapWriter(WriterBase):
    """Write scenes as ``mcap/{train,val,test}/%06d.mcap``."""

    def __init__(self, root: Path, manifest: Manifest) -> None:
        super().__init__(root, manifest)
        self._layout = mcap_layout(root)

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
            remove_file(old)
        about = {"recipe": self._manifest.contents.name, "seed": str(self._manifest.seed), "split": split}
        return McapSceneWriter(McapFile(path, about | {"scene": str(scene.scene_index)}), scene, self._manifest)


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
    text = json.dumps(to_mapping(words), allow_nan=False)
    return Log(timestamp=timestamp(stamp), level=Log.INFO, name=names.NAME, message=text)
