"""Points with what is known of each, as one numpy table a cloud: what cloud files and messages hold row by row."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from jaxtyping import Float, Int32

from warehouse_sim.geometry.clouds import depth_to_cloud
from warehouse_sim.schema import LidarScan, MountedReading, ObjectAnnotation, Observation, SceneSpec
from warehouse_sim.schema.classes import class_number

Table = np.ndarray[Any, Any]
"""One-dimensional, with named little-endian fields; ``x``, ``y``, ``z`` are always among them (m)."""
_PLACE = ("x", "<f4"), ("y", "<f4"), ("z", "<f4")
_IDENTITY = ("instance_id", "<i4"), ("label", "<i4")
SWEEP_FIELDS = np.dtype(
    [*_PLACE, ("intensity", "<f4"), ("ring", "<i4"), ("time", "<f4"), *_IDENTITY],
)
"""Of a LiDAR sweep, in the LiDAR's frame; time (s) since the sweep began, label a class number."""
CAMERA_FIELDS = np.dtype(
    [*_PLACE, ("red", "u1"), ("green", "u1"), ("blue", "u1"), *_IDENTITY],
)
"""Of the cloud of a depth camera, in the camera's frame."""


def sweeps_of(observation: Observation) -> dict[str, MountedReading[LidarScan]]:
    """Return the sweeps of all LiDARs of an observation by name."""
    return {
        name: MountedReading(item.T_camera_sensor, item.reading)
        for name, item in observation.readings.items()
        if isinstance(item.reading, LidarScan)
    }


def sweep_table(scan: LidarScan, classes: Mapping[int, str]) -> Table:
    """Return a sweep as a table of ``SWEEP_FIELDS``, in firing order.

    Args:
        scan: The sweep.
        classes: Class names by instance id.
    """
    table = np.zeros(len(scan.points), SWEEP_FIELDS)
    table["x"], table["y"], table["z"] = np.asarray(scan.points).reshape(-1, 3).T
    for name in ("intensity", "ring", "time"):
        table[name] = getattr(scan, name)
    table["instance_id"], table["label"] = scan.instance_ids, class_labels(scan.instance_ids, classes)
    return table


def camera_table(observation: Observation, classes: Mapping[int, str]) -> Table:
    """Return the points of all pixels with a depth reading as a table of ``CAMERA_FIELDS``, row by row of the image.

    The rays are those through the pixels' centres, through the lens where there is one. Ids are those of the pixels:
    at an object's rim, noise and mixed depths can lead a point off it.

    Args:
        observation: Its camera's reading, and the exact ids of its pixels.
        classes: Class names by instance id.
    """
    points, pixels = depth_to_cloud(observation.rgbd.depth, observation.camera)
    table = np.zeros(len(points), CAMERA_FIELDS)
    table["x"], table["y"], table["z"] = points.T
    table["red"], table["green"], table["blue"] = observation.rgbd.rgb.reshape(-1, 3)[pixels].T
    ids = observation.buffers.instance_mask.reshape(-1)[pixels]
    table["instance_id"], table["label"] = ids, class_labels(ids, classes)
    return table


def places(table: Table) -> Float[np.ndarray, "n 3"]:
    """Return the points of a table (m)."""
    return np.stack([table["x"], table["y"], table["z"]], axis=1).astype(np.float64)


def classes_of(scene: SceneSpec, annotations: tuple[ObjectAnnotation, ...] = ()) -> dict[int, str]:
    """Return class names by instance id of all that stands in a scene, or else that a label names."""
    named = {item.instance_id: item.class_name for item in annotations}
    return named | {item.instance_id: scene.model_of(item).class_name for item in scene.instances}


def class_labels(instance_ids: Int32[np.ndarray, " n"], classes: Mapping[int, str]) -> Int32[np.ndarray, " n"]:
    """Return the class number of each instance id; 0 where the id is 0 or nothing bears it."""
    if not instance_ids.size:
        return np.zeros(0, np.int32)
    # One look-up for all points: ids are small numbers.
    table = np.zeros(int(instance_ids.max()) + 1, np.int32)
    for instance_id, name in classes.items():
        if 0 < instance_id < len(table):
            table[instance_id] = class_number(name)
    labels: Int32[np.ndarray, " n"] = table[instance_ids]
    return labels
