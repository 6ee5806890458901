"""Load a KITTI folder with Open3D-ML and count the points in each of its boxes: folder, metres to widen boxes by."""

import json
import sys

import numpy as np
from open3d._ml3d.datasets.utils.operations import points_in_box
from open3d.ml.datasets import KITTI


def counts_in_camera(data: dict, boxes: list) -> list[int]:
    """Count with axes of the rectified camera, z = -y up: there boxes are upright even if the LiDAR leans a little."""
    up = np.array([[0, 0, 1], [-1, 0, 0], [0, -1, 0]])
    points = (np.c_[data["full_point"][:, :3], np.ones(len(data["full_point"]))] @ data["calib"]["world_cam"])[:, :3]
    rows = [[*(up @ box.to_camera()[:3]), *box.to_xyzwhlr()[3:6], box.yaw] for box in boxes]
    return points_in_box(points @ up.T, np.array(rows)).sum(axis=0).astype(int).tolist() if rows else []


root, wider = sys.argv[1], float(sys.argv[2])
dataset = KITTI(root, val_split=10**9)
found = {}
for split in ("training", "test"):
    frames = dataset.get_split(split)
    for number in range(len(frames)):
        data, name = frames.get_data(number), frames.get_attr(number)["name"]
        boxes = [box for box in data["bounding_boxes"] if abs(box.center[0]) < 900.0]  # DontCare is a kilometre away
        cloud = data["full_point"].astype(float)
        rows = [box.to_xyzwhlr() - [0, 0, wider, *[-2 * wider] * 3, 0] for box in boxes]
        inside = points_in_box(cloud[:, :3], np.array(rows)) if rows else np.zeros((len(cloud), 0))
        found[f"{split}/{name}"] = {
            "points": len(cloud),
            "counts_in_camera": counts_in_camera(data, boxes),
            "inside": [np.flatnonzero(column).tolist() for column in inside.T],
            "boxes": [[*box.center, *box.size, box.yaw] for box in boxes],
        }
print(json.dumps(found, default=float))
