"""Time the chains stage by stage, from an image or a sweep to poses, on one thread; one observation each.

python -m benchmarks.speed.chains DATA [--write]      # a dataset of `industrial` in the formats kitti and bop
"""

import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import torch
import tyro

from benchmarks.speed.result import RESULTS, rounded, write_result
from warehouse_sim.dataset.reader import DatasetReader, ImageRecord
from warehouse_sim.estimators.detections import open_front_end, open_stages
from warehouse_sim.estimators.detectors.boxes import suppress
from warehouse_sim.estimators.image import RgbdImage
from warehouse_sim.estimators.lidar.pointcloud import LidarChain, resample
from warehouse_sim.estimators.lidar.projection import sparse_depth
from warehouse_sim.estimators.lidar.upsample import upsample
from warehouse_sim.estimators.load import RECOMMENDED, load_estimator
from warehouse_sim.estimators.matching import taken_by
from warehouse_sim.estimators.pose.densefusion.estimator import Estimator
from warehouse_sim.estimators.segmenters.cluster import BoxClusters, detection_points
from warehouse_sim.estimators.settings import PredictConfig
from warehouse_sim.geometry.pose import transform_points

_OBJECTS = 8
_KIND = ("epal1",)
"""Of the pallets in these halls; without it each kind that is known is tried."""
_POINTS = 500
"""That networks of points read."""


def main(
    data: tyro.conf.Positional[Path],
    images: int = 20,
    write: bool = False,
) -> None:
    """Measure and print medians of wall time (ms).

    Args:
        data: Dataset with sweeps.
        images: How many observations.
        write: Store the result file.
    """
    torch.set_num_threads(1)
    reader = DatasetReader(data)
    chosen = _with_objects(reader, [image for split in reader.splits for image in reader.images(split)])[:images]
    rows = [_masks(reader, chosen), _sweeps(reader, chosen), _suppression()]
    for row in rows:
        print(row)
    if write:
        write_result(
            RESULTS / "front_end_latency.json", "python -m benchmarks.speed.chains DATA --write", rounded(rows)
        )


class _Clock:
    """Median times of named steps."""

    def __init__(self) -> None:
        self._spent: dict[str, list[float]] = {}

    def timed(self, name: str, work: Callable[..., Any], *given: Any) -> Any:
        started = time.perf_counter()
        result = work(*given)
        self._spent.setdefault(name, []).append(1000.0 * (time.perf_counter() - started))
        return result

    def medians(self) -> dict[str, float]:
        return {name: float(np.median(values)) for name, values in self._spent.items()}


def _with_objects(reader: DatasetReader, images: list[ImageRecord]) -> list[ImageRecord]:
    """Return the images, those first that show about eight objects well."""
    return sorted(images, key=lambda image: abs(sum(t.visible_fraction > 0.25 for t in image.targets) - _OBJECTS))


def _masks(reader: DatasetReader, images: list[ImageRecord]) -> dict[str, Any]:
    """Time ``recommended``: each network on what the one before found, then poses of at most eight pallets."""
    stages = dict(zip(RECOMMENDED.front_end.split("+"), open_stages(RECOMMENDED.front_end), strict=True))
    alone, verified = (
        load_estimator(RECOMMENDED.estimator, PredictConfig(refine=refine, uncertainty=False))
        for refine in ("none", None)
    )
    clock, counts = _Clock(), list[int]()
    for record in [*images, *images]:
        if len(counts) == len(images):  # The first pass prepares the surfaces of CAD, once for all images.
            clock = _Clock()
        image = RgbdImage.from_dataset(reader, record, ())
        for name, stage in stages.items():
            image = replace(image, detections=tuple(clock.timed(name, stage, image))[:_OBJECTS])
        known = replace(image, detections=taken_by(verified, image.detections, _KIND))
        clock.timed("network of poses", alone.estimate, known)
        clock.timed("poses, verified", verified.estimate, known)
        clock.timed("poses, verified, unknown kind", verified.estimate, image)
        counts.append(len(known.detections))
    found = clock.medians()
    total = sum(found[name] for name in (*stages, "poses, verified"))
    return {"name": "recommended", "objects": float(np.mean(counts)), "value": total} | found


def _sweeps(reader: DatasetReader, images: list[ImageRecord]) -> dict[str, Any]:
    detect = open_front_end("detector-lidar")
    config = PredictConfig(selection="consensus", refine="none", uncertainty=False)
    network = load_estimator("densefusion-pointcloud", config)
    assert isinstance(network, Estimator)
    chain, clusters, clock, counts = LidarChain(network), BoxClusters(), _Clock(), list[int]()
    for record in [images[0], *images]:
        image, mounted = RgbdImage.from_dataset(reader, record, ()), reader.sweep(record)
        assert mounted is not None, "the dataset has no sweeps"
        points = transform_points(mounted.T_camera_sensor, mounted.reading.points.astype(float))
        sparse = clock.timed("projection", _sparse, image, points)
        image = replace(image, depth=clock.timed("upsampling", upsample, sparse))
        boxes = tuple(clock.timed("detector", detect, image))[:_OBJECTS]
        image = replace(image, detections=taken_by(network, boxes, _KIND))
        image = replace(image, detections=tuple(clock.timed("DBSCAN and choice", clusters.segment, image)))
        clouds = [detection_points(image, item).points for item in image.detections]
        clock.timed("K-means", _resampled, clouds)
        # The chain clusters and resamples again: what the network takes is the rest.
        clock.timed("clusters, K-means and network", chain.estimate, image)
        counts.append(len(boxes))
    found = clock.medians()
    total = sum(found[name] for name in ("projection", "upsampling", "detector", "clusters, K-means and network"))
    return {"name": "LiDAR: detect-pointcloud", "objects": float(np.mean(counts)), "value": total} | found


def _sparse(image: RgbdImage, points: np.ndarray) -> np.ndarray:
    return sparse_depth(image.camera, points).depth


def _resampled(clouds: list[np.ndarray]) -> list[np.ndarray]:
    rng = np.random.default_rng(0)
    return [resample(cloud, _POINTS, rng) for cloud in clouds if len(cloud)]


def _suppression() -> dict[str, Any]:
    """Return how long suppression takes among as many boxes as a detector gives for an image of 640 x 192."""
    rng, clock = np.random.default_rng(0), _Clock()
    corner = rng.uniform(0, [600, 180], (7560, 2))
    boxes = np.concatenate([corner, corner + rng.uniform(5, 80, (7560, 2))], axis=1)
    scores = np.where(rng.random((7560, 1)) < 0.05, rng.random((7560, 1)), 0.0)
    for _ in range(30):
        clock.timed("NMS", suppress, boxes, scores, 0.25, 0.6)
    return {"name": "suppression, 7,560 boxes, one in twenty with a score", "value": clock.medians()["NMS"]}


if __name__ == "__main__":
    tyro.cli(main)
