"""Messages of labels: boxes in space and boxes on the image."""

from collections.abc import Sequence

from foxglove_schemas_protobuf.CubePrimitive_pb2 import CubePrimitive
from foxglove_schemas_protobuf.ImageAnnotations_pb2 import ImageAnnotations
from foxglove_schemas_protobuf.Point2_pb2 import Point2
from foxglove_schemas_protobuf.PointsAnnotation_pb2 import PointsAnnotation
from foxglove_schemas_protobuf.SceneEntity_pb2 import SceneEntity
from foxglove_schemas_protobuf.SceneEntityDeletion_pb2 import SceneEntityDeletion
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from foxglove_schemas_protobuf.TextAnnotation_pb2 import TextAnnotation

from warehouse_sim.dataset.formats.mcap.plain_messages import color_of, pairs, pose, timestamp, vector
from warehouse_sim.schema import ObjectAnnotation

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
