"""How well clusterings take the points of a LiDAR in a box apart, by object, and how long they need.

    python -m benchmarks.estimators.clusterings DATA --write [--picture docs/images/clusterings.png]

DATA is a dataset with sweeps. Of each pallet at least 25 % visible that the sweep shows, the points in its true box are
clustered and compared with the ids that the simulated LiDAR gives its points: the adjusted Rand index over all points
(Hubert and Arabie 1985; 1 = the same partition, 0 = as by chance), and the overlap of the chosen cluster with the
pallet. Methods that need the number of clusters get the true one.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import tyro
from sklearn.cluster import AgglomerativeClustering, SpectralClustering
from sklearn.metrics import adjusted_rand_score

from benchmarks.result import RESULTS, rounded, write_result
from warehouse_sim.dataset.reader import DatasetReader, ImageRecord
from warehouse_sim.estimators.lidar.clusters import ClusterConfig, Clusters, chosen_points, cluster
from warehouse_sim.estimators.lidar.projection import sparse_depth
from warehouse_sim.estimators.segmenters.cluster import BoxPoints, box_points
from warehouse_sim.geometry.pose import transform_points

_LEAST_POINTS = 40
_ONE_OBJECT = 10
"""Objects of fewer points count as one with what is about them."""


@dataclass(frozen=True, eq=False)
class Box:
    """The points of a LiDAR in the box of a pallet."""

    seen: BoxPoints
    spacing: float
    """Angle between neighbouring readings (rad)."""
    instance_ids: np.ndarray
    pallet: int
    """Its instance id."""

    @property
    def objects(self) -> int:
        """How many objects the points are of."""
        return int((np.unique(self.instance_ids, return_counts=True)[1] >= _ONE_OBJECT).sum())


def boxes_of(reader: DatasetReader, image: ImageRecord) -> list[Box]:
    """Return the boxes of an image."""
    mounted = reader.sweep(image)
    assert mounted is not None, f"{reader.root} holds no sweeps"
    points = transform_points(mounted.T_camera_sensor, mounted.reading.points.astype(float))
    depth, shown = sparse_depth(image.camera, points)
    found = []
    for target in image.targets:
        seen = box_points(image.camera, depth, target.box_visible_xyxy)
        ids = mounted.reading.instance_ids[shown[seen.v, seen.u]]
        if target.visible_fraction < 0.25 or len(ids) < _LEAST_POINTS or (ids == target.instance_id).sum() < 20:
            continue
        left, top, right, bottom = target.box_visible_xyxy
        pixels = (right - left + 1) * (bottom - top + 1) / len(ids)
        found.append(Box(seen, float(np.sqrt(pixels)) / image.camera.fx, ids, target.instance_id))
    return found


def _all_core(label: np.ndarray) -> Clusters:
    return Clusters(np.asarray(label, dtype=np.int64), np.ones(len(label), bool))


def _spectral(box: Box) -> Clusters:
    neighbours = min(10, len(box.seen.points) - 1)
    model = SpectralClustering(box.objects, affinity="nearest_neighbors", n_neighbors=neighbours, random_state=0)
    return _all_core(model.fit_predict(box.seen.points))


METHODS: dict[str, Callable[[Box], Clusters]] = {
    "DBSCAN, reach by range": lambda box: cluster(box.seen.points, box.spacing),
    "DBSCAN, reach by range, scikit-learn": lambda box: cluster(
        box.seen.points, box.spacing, ClusterConfig(library="scikit-learn", voxels=0.0)
    ),
    "DBSCAN, 0.1 m": lambda box: cluster(box.seen.points, box.spacing, ClusterConfig(least_eps=0.1, most_eps=0.1)),
    "agglomerative, single, 0.15 m": lambda box: _all_core(
        AgglomerativeClustering(None, linkage="single", distance_threshold=0.15).fit_predict(box.seen.points)
    ),
    "agglomerative, Ward, told how many": lambda box: _all_core(
        AgglomerativeClustering(box.objects).fit_predict(box.seen.points)
    ),
    "spectral, told how many": _spectral,
}


def measured(boxes: list[Box], name: str) -> dict:
    """Return one row: scores and times of a method."""
    scores, overlaps, times = [], [], []
    for box in boxes:
        started = time.process_time()
        found = METHODS[name](box)
        times.append(time.process_time() - started)
        scores.append(adjusted_rand_score(box.instance_ids, found.label))
        chosen, right = chosen_points(box.seen.points, found), box.instance_ids == box.pallet
        overlaps.append((chosen & right).sum() / (chosen | right).sum())
    return {
        "name": name,
        "value": float(np.mean(scores)),
        "unit": "mean adjusted Rand index",
        "adjusted_rand_quartiles": [float(q) for q in np.quantile(scores, [0.25, 0.5, 0.75])],
        "chosen_iou_mean": float(np.mean(overlaps)),
        "chosen_iou_over_half": float(np.mean(np.array(overlaps) > 0.5)),
        "cpu_ms_median": float(np.median(times) * 1e3),
        "cpu_ms_90": float(np.quantile(times, 0.9) * 1e3),
    }


def draw(boxes: list[Box], path: Path) -> None:
    """Draw the true ids and each method's clusters of some boxes, as the camera sees the points."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(16, 1.9 * len(boxes)), layout="constrained")
    axes = figure.subplots(len(boxes), len(METHODS) + 1, squeeze=False)
    for row, box in zip(axes, boxes, strict=True):
        gt = np.unique(box.instance_ids, return_inverse=True)[1]
        for axis, (name, label) in zip(
            row, [("true objects", gt), *((name, METHODS[name](box).label) for name in METHODS)], strict=True
        ):
            axis.scatter(box.seen.u[label < 0], box.seen.v[label < 0], s=2, c="0.7")
            inside = label >= 0
            axis.scatter(
                box.seen.u[inside], box.seen.v[inside], s=4, c=label[inside] % 10, cmap="tab10", vmin=0, vmax=9
            )
            score = adjusted_rand_score(box.instance_ids, label)
            axis.set_title(f"{name}\n{score:.2f}" if name != "true objects" else name, fontsize=7)
            axis.set_axis_off()
            axis.invert_yaxis()
    figure.savefig(path, dpi=90)
    print(f"output: {path}")


def main(
    data: tyro.conf.Positional[Path], split: str = "test", write: bool = False, picture: Path | None = None
) -> None:
    """Compare clusterings.

    Args:
        data: Dataset with sweeps.
        split: Which images.
        write: Store the result.
        picture: Draw some boxes.
    """
    reader = DatasetReader(data)
    boxes = [box for image in reader.images(split) for box in boxes_of(reader, image)]
    rows = [rounded(measured(boxes, name)) for name in METHODS]
    for row in rows:
        print(row)
    if write:
        command = "python -m benchmarks.estimators.clusterings DATA --write"
        points = [len(box.instance_ids) for box in boxes]
        where = {"recipe": reader.name, "seed": reader.manifest.seed if reader.manifest else None}
        counted = {"boxes": len(boxes), "points_median": float(np.median(points)), "points_most": max(points)}
        write_result(RESULTS / "clusterings.json", command, rows, data=where, **counted)
    if picture:
        several = sorted((box for box in boxes if box.objects >= 2), key=lambda box: -len(box.instance_ids))
        draw(several[:: max(1, len(several) // 4)][:4], picture)


if __name__ == "__main__":
    tyro.cli(main)
