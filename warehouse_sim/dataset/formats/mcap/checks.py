"""Checks of MCAP files: whole to the last checksum, and of the poses and labels of the scene record.

Files are read observation by observation, with the packages' own readers.
"""

import json
import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from google.protobuf.message import DecodeError
from mcap.exceptions import McapError
from mcap.reader import SeekingReader
from mcap.well_known import MessageEncoding
from mcap_protobuf.decoder import DecoderFactory
from zstandard import ZstdError

from warehouse_sim.dataset.checks.findings import Findings, NamedCheck, compare_names
from warehouse_sim.dataset.checks.subject import Subject
from warehouse_sim.dataset.files.point_table import Table
from warehouse_sim.dataset.formats import mcap as names
from warehouse_sim.dataset.formats.mcap import mcap_layout, topic
from warehouse_sim.dataset.split import Split
from warehouse_sim.dataset.stored.observation_record import RecordedObservation
from warehouse_sim.dataset.stored.scene_record import SceneRecord
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.pose import Transform, invert, make_transform, matrix_from_quat_wxyz
from warehouse_sim.schema import CAMERA

_LARGEST_RECORD = 2**30
_KINDS = {1: "<u1", 2: "<i1", 3: "<u2", 4: "<i2", 5: "<u4", 6: "<i4", 7: "<f4", 8: "<f8"}
"""Types of Foxglove's PackedElementField by number."""
_UNREADABLE = (OSError, McapError, DecodeError, ZstdError, ValueError, KeyError, struct.error, EOFError, MemoryError)


@dataclass
class Moment:
    """All messages of one time stamp."""

    stamp: int
    messages: dict[str, Any] = field(default_factory=dict)
    """By topic; JSON as plain data."""


def read_moments(path: Path) -> Iterator[Moment]:
    """Yield the messages of a file, one time stamp after the other.

    Raises:
        DatasetError: The file is missing, cut or changed: every checksum in it is compared.
    """
    try:
        with open(path, "rb") as stream:
            reader = SeekingReader(stream, validate_crcs=True, record_size_limit=_LARGEST_RECORD)
            decoders, moment = DecoderFactory(), None
            for schema, channel, message in reader.iter_messages():
                if moment is None or moment.stamp != message.log_time:
                    if moment is not None:
                        yield moment
                    moment = Moment(message.log_time)
                if channel.message_encoding == MessageEncoding.JSON:
                    moment.messages[channel.topic] = json.loads(message.data)
                    continue
                decode = decoders.decoder_for(channel.message_encoding, schema)
                if decode is None:
                    raise ValueError(f"{channel.topic} has no protobuf schema")
                moment.messages[channel.topic] = decode(message.data)
            if moment is not None:
                yield moment
    except _UNREADABLE as problem:
        raise DatasetError(f"{path}: cannot be read ({' '.join(str(problem).split())[:100]})") from problem


def transforms_of(message: Any) -> dict[str, tuple[str, Transform]]:
    """Return parent and pose in it of each frame of a message of transforms."""
    found = {}
    for item in message.transforms:
        q, t = item.rotation, item.translation
        rotation = matrix_from_quat_wxyz(np.array([q.w, q.x, q.y, q.z]))
        found[item.child_frame_id] = item.parent_frame_id, make_transform(rotation, np.array([t.x, t.y, t.z]))
    return found


def pose_in_root(frames: dict[str, tuple[str, Transform]], frame: str) -> Transform:
    """Return the pose of a frame in the one that has no parent.

    Raises:
        DatasetError: Frames go round in a circle.
    """
    T, steps = np.eye(4), 0
    while frame in frames:
        frame, T_parent_frame = frames[frame]
        T, steps = T_parent_frame @ T, steps + 1
        if steps > len(frames):
            raise DatasetError(f"the frames {sorted(frames)} of a recording go round in a circle")
    return T


def cloud_of(message: Any) -> Table:
    """Return the points of a message as a table.

    Raises:
        DatasetError: Fields and length of its data do not go together.
    """
    names = [item.name for item in message.fields]
    row: Any = {"names": names, "formats": [_KINDS.get(item.type, "V1") for item in message.fields]}
    row |= {"offsets": [item.offset for item in message.fields], "itemsize": message.point_stride}
    try:
        return np.frombuffer(message.data, np.dtype(row))
    except (ValueError, TypeError) as problem:
        raise DatasetError(f"a cloud of {len(message.data)} bytes does not fit its fields ({problem})") from problem


_SAME_POSE = 1e-6


def files(subject: Subject) -> Findings:
    """Each split has one file a scene and nothing else."""
    findings, layout = Findings(), mcap_layout(subject.root)
    for split, scenes in subject.manifest.splits.items():
        compare_names(findings, layout.root / split, {layout.scene(split, index).name for index in scenes})
    findings.examined = f"{len(subject.manifest.scene_indices)} files"
    return findings


def messages(subject: Subject) -> Findings:
    """Messages decode, and have the cameras, boxes and points of the scene record."""
    findings = subject.put_together(list(subject.scenes()), lambda scene: _scene(subject, *scene))
    findings.examined = f"{findings.count} observations: calibration, images, poses, boxes, points"
    return findings


CHECKS = (NamedCheck("mcap files", files), NamedCheck("mcap messages", messages))


def _scene(subject: Subject, split: Split, scene: int) -> Findings:
    findings, path = Findings(), mcap_layout(subject.root).scene(split, scene)
    record = subject.record(scene)
    frames: Any = None
    waiting = list(record.observations)
    for moment in read_moments(path):
        where = f"{path}: {moment.stamp} ns"
        frames = moment.messages.get(names.TRANSFORMS, frames)
        # Paired variants have one stamp: the topics of each begin with its variant.
        for prefix in _prefixes(moment.messages):
            if not findings.require(bool(waiting), f"{where}: there are more observations than in the scene record"):
                return findings
            own = {name.removeprefix(prefix): message for name, message in moment.messages.items()}
            _observation(findings, own, frames, waiting.pop(0), record, where + prefix)
            findings.count += 1
    findings.require(not waiting, f"{path}: lacks the last {len(waiting)} observations of the scene record")
    return findings


def _prefixes(found: dict[str, Any]) -> list[str]:
    """Return what stands before the topics of each variant, in the order of writing."""
    image = topic(CAMERA, names.IMAGE)
    return [name.removesuffix(image) for name in found if name.endswith(image)]


def _observation(
    findings: Findings,
    found: dict[str, Any],
    frames: Any,
    recorded: RecordedObservation,
    record: SceneRecord,
    where: str,
) -> None:
    poses = {} if frames is None else transforms_of(frames)
    T_world_camera = pose_in_root(poses, CAMERA)
    same = np.allclose(T_world_camera, recorded.T_world_camera, rtol=0, atol=_SAME_POSE)
    findings.require(same, f"{where}: the camera's pose is not that of the scene record")
    _images(findings, found, where)
    _boxes(findings, found, recorded, record, where)
    known = {item.instance_id for item in record.objects} | {0}
    for name in [name for name in found if name.endswith(f"/{names.POINTS}")]:
        table = cloud_of(found[name])
        strange = set(np.unique(table["instance_id"]).tolist()) - known
        findings.require(not strange, f"{where}: {name} names instances {sorted(strange)[:5]} that do not exist")
        findings.require(found[name].frame_id in poses, f"{where}: {name} is in a frame that {names.TRANSFORMS} lacks")


def _images(findings: Findings, found: dict[str, Any], where: str) -> None:
    calibration, depth = found[topic(CAMERA, names.CALIBRATION)], found[topic(CAMERA, names.DEPTH)]
    size = calibration.height, calibration.width
    image = cv2.imdecode(np.frombuffer(found[topic(CAMERA, names.IMAGE)].data, np.uint8), cv2.IMREAD_UNCHANGED)
    findings.require(image is not None and image.shape == (*size, 3), f"{where}: the image is no PNG of {size} pixels")
    values = np.frombuffer(depth.data, "<f4") if len(depth.data) % 4 == 0 else np.zeros(0)
    fits = (depth.height, depth.width) == size and values.size == size[0] * size[1]
    findings.require(fits, f"{where}: the depth image is not of {size} pixels")
    sane = bool(np.isfinite(values).all() and (values >= 0).all())
    findings.require(sane, f"{where}: a depth is negative or no number")


def _boxes(
    findings: Findings, found: dict[str, Any], recorded: RecordedObservation, record: SceneRecord, where: str
) -> None:
    """Note boxes that are not those of the recorded targets, at their places."""
    entities = {int(item.id): item for item in found[names.OBJECTS].entities}
    expected = {item.instance_id for item in recorded.targets}
    findings.require(set(entities) == expected, f"{where}: boxes of {sorted(entities)}, expected {sorted(expected)}")
    T_camera_world = invert(recorded.T_world_camera)
    objects = {item.instance_id: item for item in record.objects}
    for number in sorted(set(entities) & expected & set(objects)):
        place = entities[number].cubes[0].pose.position
        due = (T_camera_world @ objects[number].T_world_object)[:3, 3]
        off = float(np.linalg.norm(due - [place.x, place.y, place.z]))
        findings.require(off < _SAME_POSE, f"{where}: the box of instance {number} is {off:.6f} m off its place")
