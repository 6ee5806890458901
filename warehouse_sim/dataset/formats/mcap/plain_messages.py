"""The small messages that the others are made of: times, points, poses, colours, pairs of words."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from foxglove_schemas_protobuf.Color_pb2 import Color
from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
from foxglove_schemas_protobuf.KeyValuePair_pb2 import KeyValuePair
from foxglove_schemas_protobuf.Pose_pb2 import Pose
from foxglove_schemas_protobuf.Quaternion_pb2 import Quaternion
from foxglove_schemas_protobuf.Vector3_pb2 import Vector3
from google.protobuf.timestamp_pb2 import Timestamp

from warehouse_sim.dataset.viewing.overlay import colorize_instances
from warehouse_sim.geometry.pose import Transform, quat_wxyz_from_matrix

_SECOND = 1_000_000_000


def timestamp(stamp: int) -> Timestamp:
    """Return a time stamp (ns since 1970) as protobuf has it."""
    return Timestamp(seconds=stamp // _SECOND, nanos=stamp % _SECOND)


def vector(values: Any) -> Vector3:
    """Return three numbers."""
    x, y, z = (float(value) for value in values)
    return Vector3(x=x, y=y, z=z)


def quaternion(T: Transform) -> Quaternion:
    """Return the rotation of a transform."""
    w, x, y, z = (float(value) for value in quat_wxyz_from_matrix(T[:3, :3]))
    return Quaternion(x=x, y=y, z=z, w=w)


def pose(T: Transform) -> Pose:
    """Return a transform as a pose."""
    message = Pose(orientation=quaternion(T))
    message.position.x, message.position.y, message.position.z = (float(value) for value in T[:3, 3])
    return message


def transform(stamp: int, parent: str, child: str, T_parent_child: Transform) -> FrameTransform:
    """Return where a frame is in another one."""
    return FrameTransform(
        timestamp=timestamp(stamp),
        parent_frame_id=parent,
        child_frame_id=child,
        translation=vector(T_parent_child[:3, 3]),
        rotation=quaternion(T_parent_child),
    )


def color_of(instance_id: int, alpha: float = 1.0) -> Color:
    """Return the colour of an instance, the same as in all pictures of this package."""
    red, green, blue = (float(value) / 255.0 for value in colorize_instances(np.array([instance_id]))[0])
    return Color(r=red, g=green, b=blue, a=alpha)


def pairs(words: Mapping[str, Any]) -> list[KeyValuePair]:
    """Return metadata."""
    return [KeyValuePair(key=key, value=str(value)) for key, value in words.items()]
