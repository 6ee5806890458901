"""Read an MCAP file of Foxglove's messages, observation by observation, with the packages' own readers."""

import json
import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from google.protobuf.message import DecodeError
from mcap.exceptions import McapError
from mcap.reader import SeekingReader
from mcap.well_known import MessageEncoding
from mcap_protobuf.decoder import DecoderFactory
from zstandard import ZstdError

from warehouse_sim.dataset.files.point_table import Table
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.pose import Transform, make_transform, matrix_from_quat_wxyz

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
