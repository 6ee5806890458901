"""Sensor readings, poses and labels of an observation as messages of the schemas that Foxglove defines."""

import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from foxglove_schemas_protobuf.CameraCalibration_pb2 import CameraCalibration
from foxglove_schemas_protobuf.Color_pb2 import Color
from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage
from foxglove_schemas_protobuf.CubePrimitive_pb2 import CubePrimitive
from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
from foxglove_schemas_protobuf.ImageAnnotations_pb2 import ImageAnnotations
from foxglove_schemas_protobuf.KeyValuePair_pb2 import KeyValuePair
from foxglove_schemas_protobuf.PackedElementField_pb2 import PackedElementField
from foxglove_schemas_protobuf.Point2_pb2 import Point2
from foxglove_schemas_protobuf.PointCloud_pb2 import PointCloud
from foxglove_schemas_protobuf.PointsAnnotation_pb2 import PointsAnnotation
from foxglove_schemas_protobuf.Pose_pb2 import Pose
from foxglove_schemas_protobuf.Quaternion_pb2 import Quaternion
from foxglove_schemas_protobuf.RawImage_pb2 import RawImage
from foxglove_schemas_protobuf.SceneEntity_pb2 import SceneEntity
from foxglove_schemas_protobuf.SceneEntityDeletion_pb2 import SceneEntityDeletion
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from foxglove_schemas_protobuf.TextAnnotation_pb2 import TextAnnotation
from foxglove_schemas_protobuf.Vector3_pb2 import Vector3
from google.protobuf.timestamp_pb2 import Timestamp
from jaxtyping import Float32

from warehouse_sim.config import to_mapping
from warehouse_sim.dataset.files.point_table import Table
from warehouse_sim.dataset.viewing.overlay import colorize_instances
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.lens import Fisheye
from warehouse_sim.geometry.pose import Transform, make_transform, quat_wxyz_from_matrix
from warehouse_sim.schema import ObjectAnnotation, Reading
from warehouse_sim.schema.readings import units_of

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


_KINDS = {
    "<f4": PackedElementField.FLOAT32,
    "<i4": PackedElementField.INT32,
    "|u1": PackedElementField.UINT8,
}


def cloud_message(stamp: int, frame: str, table: Table) -> PointCloud:
    """Return a table of points as it is, field by field, in the frame of its sensor."""
    fields = table.dtype.fields or {}
    return PointCloud(
        timestamp=timestamp(stamp),
        frame_id=frame,
        pose=pose(make_transform()),
        point_stride=table.dtype.itemsize,
        fields=[
            PackedElementField(name=name, offset=offset, type=_KINDS[kind.str])
            for name, (kind, offset, *_) in fields.items()
        ],
        data=table.tobytes(),
    )


_NO_LENS = ("plumb_bob", [0.0] * 5)


def image_message(stamp: int, frame: str, png: bytes) -> CompressedImage:
    """Return a colour image that is a PNG already."""
    return CompressedImage(timestamp=timestamp(stamp), frame_id=frame, data=png, format="png")


def depth_message(stamp: int, frame: str, depth: Float32[np.ndarray, "h w"]) -> RawImage:
    """Return a depth image (m, 0 = no reading) to the bit, without the limits of 16 bits."""
    height, width = depth.shape
    return RawImage(
        timestamp=timestamp(stamp),
        frame_id=frame,
        width=width,
        height=height,
        encoding="32FC1",
        step=4 * width,
        data=np.ascontiguousarray(depth, "<f4").tobytes(),
    )


def calibration_message(stamp: int, frame: str, camera: PinholeCamera, baseline: float = 0.0) -> CameraCalibration:
    """Return a camera's calibration; pixel centres are integers, as in OpenCV.

    Args:
        stamp: Time stamp (ns).
        frame: The camera's frame.
        camera: Intrinsics and lens.
        baseline: How far it stands to the right of the camera that it makes a pair with (m).
    """
    model, coefficients = _lens(camera)
    K, P = camera.K, np.zeros((3, 4))
    P[:, :3], P[0, 3] = K, -camera.fx * baseline
    return CameraCalibration(
        timestamp=timestamp(stamp),
        frame_id=frame,
        width=camera.width,
        height=camera.height,
        distortion_model=model,
        D=coefficients,
        K=K.ravel().tolist(),
        R=np.eye(3).ravel().tolist(),
        P=(P + 0.0).ravel().tolist(),
    )


def _lens(camera: PinholeCamera) -> tuple[str, list[float]]:
    lens = camera.distortion
    if lens is None:
        return _NO_LENS
    return ("kannala_brandt" if isinstance(lens, Fisheye) else "plumb_bob"), [float(c) for c in lens.coefficients]


_TIME = {
    "type": "object",
    "title": "time",
    "properties": {"sec": {"type": "integer"}, "nsec": {"type": "integer"}},
}


def reading_schema(reading: Reading) -> bytes:
    """Return the JSON schema of a sensor's messages."""
    units = units_of(reading)
    properties: dict[str, Any] = {"timestamp": _TIME, "frame_id": {"type": "string"}}
    for name, array in sorted(reading.channels.items()):
        properties[name] = _array(np.asarray(array)) | {"description": str(units.get(name, ""))}
    return json.dumps({"type": "object", "properties": properties}).encode("ascii")


def reading_message(stamp: int, frame: str, reading: Reading) -> bytes:
    """Return a sensor's arrays as JSON, every digit of them."""
    time = {"sec": stamp // _SECOND, "nsec": stamp % _SECOND}
    arrays = {name: to_mapping(np.asarray(array)) for name, array in sorted(reading.channels.items())}
    return json.dumps({"timestamp": time, "frame_id": frame, **arrays}, allow_nan=False).encode("ascii")


def _array(array: np.ndarray) -> dict[str, Any]:
    kinds = {"f": "number", "b": "boolean"}
    schema: dict[str, Any] = {"type": kinds.get(array.dtype.kind, "integer")}
    for _ in range(array.ndim):
        schema = {"type": "array", "items": schema}
    return schema


_ALPHA, _FONT = 0.35, 14.0
_WIDTH = {"visible": 2.0, "amodal": 1.0}


def boxes_message(stamp: int, frame: str, labels: Sequence[ObjectAnnotation]) -> SceneUpdate:
    """Return the boxes of all labelled objects of one observation, in the camera's frame; older ones go away."""
    return SceneUpdate(
        deletions=[SceneEntityDeletion(timestamp=timestamp(stamp), type=SceneEntityDeletion.ALL)],
        entities=[_entity(stamp, frame, label) for label in labels],
    )


def _entity(stamp: int, frame: str, label: ObjectAnnotation) -> SceneEntity:
    cube = CubePrimitive(
        pose=pose(label.T_camera_object), size=vector(label.size), color=color_of(label.instance_id, _ALPHA)
    )
    return SceneEntity(
        timestamp=timestamp(stamp),
        frame_id=frame,
        id=str(label.instance_id),
        metadata=pairs(
            {
                "class_name": label.class_name,
                "instance_id": label.instance_id,
                "obj_id": label.obj_id,
                "visible_fraction": label.visible_fraction,
            }
        ),
        cubes=[cube],
    )


def image_boxes_message(stamp: int, labels: Sequence[ObjectAnnotation]) -> ImageAnnotations:
    """Return the boxes on the image: around the visible pixels, and around the whole amodal mask.

    Foxglove's origin is the outer corner of the first pixel, ours its centre: lines run along the outer borders of
    the pixels, so that inclusive corners (left, right) become left and right + 1.
    """
    message = ImageAnnotations(timestamp=timestamp(stamp))
    for label in labels:
        boxes = {"visible": label.box_visible_xyxy, "amodal": label.box_amodal_xyxy}
        for kind, box in boxes.items():
            if box is not None:
                message.points.append(_outline(stamp, label, kind, box))
        left, top = (label.box_visible_xyxy or label.box_amodal_xyxy)[:2]
        message.texts.append(
            TextAnnotation(
                timestamp=timestamp(stamp),
                position=Point2(x=float(left), y=float(top)),
                text=f"{label.class_name} {label.instance_id}",
                font_size=_FONT,
                text_color=color_of(label.instance_id),
            )
        )
    return message


def _outline(stamp: int, label: ObjectAnnotation, kind: str, box: Sequence[float]) -> PointsAnnotation:
    left, top, right, bottom = (float(side) for side in box)
    right, bottom = right + 1.0, bottom + 1.0
    corners = (left, top), (right, top), (right, bottom), (left, bottom)
    return PointsAnnotation(
        timestamp=timestamp(stamp),
        type=PointsAnnotation.LINE_LOOP,
        points=[Point2(x=x, y=y) for x, y in corners],
        outline_color=color_of(label.instance_id),
        thickness=_WIDTH[kind],
        metadata=pairs({"box": kind, "class_name": label.class_name, "instance_id": label.instance_id}),
    )
