"""Draw one frame of a recording from its messages alone, with mcap's own reader, and print what agrees."""

import json
import sys

import cv2
import numpy as np
from foxglove_schemas_protobuf import CameraCalibration_pb2, PointCloud_pb2, SceneUpdate_pb2
from google.protobuf.descriptor_pb2 import FileDescriptorSet
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

PUBLISHED = {
    "foxglove.CameraCalibration": CameraCalibration_pb2.CameraCalibration,
    "foxglove.PointCloud": PointCloud_pb2.PointCloud,
    "foxglove.SceneUpdate": SceneUpdate_pb2.SceneUpdate,
}
TYPES = {1: "u1", 2: "i1", 3: "<u2", 4: "<i2", 5: "<u4", 6: "<i4", 7: "<f4", 8: "<f8"}


def matrix(position, q) -> np.ndarray:
    x, y, z, w = q.x, q.y, q.z, q.w
    T = np.eye(4)
    T[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    T[:3, 3] = position.x, position.y, position.z
    return T


def same_schema(schema) -> bool:
    files = {item.name: item for item in FileDescriptorSet.FromString(schema.data).file}
    descriptor = PUBLISHED[schema.name].DESCRIPTOR.file
    return files[descriptor.name].SerializeToString() == descriptor.serialized_pb


def project(calibration, points: np.ndarray) -> np.ndarray:
    K, D = np.array(calibration.K).reshape(3, 3), np.array(calibration.D)
    zero = np.zeros(3)
    if calibration.distortion_model == "kannala_brandt":
        return cv2.fisheye.projectPoints(points[:, None], zero, zero, K, D)[0][:, 0]
    return cv2.projectPoints(points, zero, zero, K, D)[0][:, 0]


frames, first, schemas, times = {}, {}, [], []
with open(sys.argv[1], "rb") as stream:
    reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
    for schema, channel, message in reader.iter_messages():
        times.append(message.log_time)
        if schema.name in PUBLISHED and channel.topic not in first:
            schemas.append(same_schema(schema))
        if message.log_time == times[0]:
            first[channel.topic] = (
                json.loads(message.data)
                if channel.message_encoding == "json"
                else DecoderFactory().decoder_for(channel.message_encoding, schema)(message.data)
            )
for item in first["/tf"].transforms:
    frames[item.child_frame_id] = item.parent_frame_id, matrix(item.translation, item.rotation)

calibration = first["/camera/calibration"]
image = cv2.imdecode(np.frombuffer(first["/camera/image"].data, np.uint8), cv2.IMREAD_COLOR)
raw = first["/camera/depth"]
depth = np.frombuffer(raw.data, "<f4").reshape(raw.height, raw.width)
cloud = first["/lidar/points"]
fields = {"names": [f.name for f in cloud.fields], "formats": [TYPES[f.type] for f in cloud.fields]}
fields |= {"offsets": [f.offset for f in cloud.fields], "itemsize": cloud.point_stride}
rows = np.frombuffer(cloud.data, np.dtype(fields))
parent, T_camera_lidar = frames[cloud.frame_id]
assert parent == first["/camera/image"].frame_id == calibration.frame_id
points = np.stack([rows["x"], rows["y"], rows["z"]], axis=1).astype(float) @ T_camera_lidar[:3, :3].T
points += T_camera_lidar[:3, 3]
ahead = points[:, 2] > 0.3
points, ids = points[ahead], rows["instance_id"][ahead]
pixels = project(calibration, points)
columns, lines = np.rint(pixels).astype(int).T
inside = (columns >= 0) & (lines >= 0) & (columns < raw.width) & (lines < raw.height)
points, ids, columns, lines = points[inside], ids[inside], columns[inside], lines[inside]
seen = depth[lines, columns]
agree = np.abs(seen - points[:, 2])[seen > 0] / points[seen > 0, 2] < 0.03

corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
edges = [(a, b) for a in range(8) for b in range(a + 1, 8) if (a ^ b) in (1, 2, 4)]
sampled, boxes = image.copy(), {}
hues = np.uint8([[[int(i) * 137 % 180, 220, 255] for i in ids]]) if len(ids) else np.zeros((1, 0, 3), np.uint8)
for (u, v), color in zip(zip(columns, lines, strict=True), cv2.cvtColor(hues, cv2.COLOR_HSV2BGR)[0], strict=True):
    cv2.circle(sampled, (int(u), int(v)), 1, tuple(int(c) for c in color), -1)
for entity in first["/objects"].entities:
    (cube,) = entity.cubes
    T = matrix(cube.pose.position, cube.pose.orientation)
    places = corners * [cube.size.x, cube.size.y, cube.size.z] @ T[:3, :3].T + T[:3, 3]
    if places[:, 2].min() > 0.1:
        ends = project(calibration, places)
        boxes[entity.id] = [*ends.min(axis=0), *ends.max(axis=0)]
        for a, b in edges:
            cv2.line(sampled, *(tuple(round(float(c)) for c in ends[i]) for i in (a, b)), (0, 255, 255), 1, cv2.LINE_AA)
overlaps = {}
for outline in first["/camera/boxes"].points:
    words = {item.key: item.value for item in outline.metadata}
    # Foxglove counts from the outer corner of the first pixel, the calibration from its centre.
    places = np.array([[p.x - 0.5, p.y - 0.5] for p in outline.points])
    low, high = places.min(axis=0), places.max(axis=0)
    if words["box"] == "amodal" and words["instance_id"] in boxes:
        left, top, right, bottom = boxes[words["instance_id"]]
        overlaps[words["instance_id"]] = float(np.abs([*(low - [left, top]), *(high - [right, bottom])]).max())
    if words["box"] == "visible":
        cv2.rectangle(sampled, *(tuple(round(float(c)) for c in corner) for corner in (low, high)), (255, 255, 255), 1)
if len(sys.argv) > 2:
    cv2.imwrite(sys.argv[2], sampled)
report = {
    "topics": sorted(first),
    "times": sorted(set(times)),
    "schemas": schemas,
    "frames": {name: parent for name, (parent, _) in frames.items()},
    "points": len(points),
    "agree": float(agree.mean()) if agree.size else None,
    "box_difference": overlaps,
    "json": {topic: message for topic, message in first.items() if isinstance(message, dict)},
}
print(json.dumps(report))
