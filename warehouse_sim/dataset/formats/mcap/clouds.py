"""Messages of LiDARs: a sweep with all that is known of its points."""

from foxglove_schemas_protobuf.PackedElementField_pb2 import PackedElementField
from foxglove_schemas_protobuf.PointCloud_pb2 import PointCloud

from warehouse_sim.dataset.files.point_table import Table
from warehouse_sim.dataset.formats.mcap.plain_messages import pose, timestamp
from warehouse_sim.geometry.pose import make_transform

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
