"""In a street, a sweep of the default LiDAR has about as many points as KITTI's."""

import numpy as np
import pytest

from warehouse_sim.render.conformance.scenes import at, box_model, make_scene
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.schema import Material
from warehouse_sim.sensors.lidar import LidarConfig, scan

# "around ~120,000 points" a sweep: PRBonn/depth_clustering, issue 16; 120,000: LiDAR-Processing-V2, issue 8.
KITTI_POINTS = 120_000
REMISSION = {"asphalt": 0.15, "plaster": 0.5, "paint": 0.4}


def street(seed: int, half_width: float) -> RayCaster:
    """Houses with gaps on both sides, parked cars, and nothing above."""
    rng = np.random.default_rng(seed)
    models = [box_model("road", (400, 400, 1), "asphalt"), box_model("car", (4.2, 1.8, 1.5), "paint")]
    placed = [("road", at(0, 0, -0.5))]
    x = -200.0
    while x < 200.0:
        length = rng.uniform(8, 18)
        for side in (-1, 1):
            if rng.random() < 0.75:
                height, setback = rng.uniform(4.0, 10.4), half_width + rng.uniform(-2, 3)
                name = f"house {len(models)}"
                models.append(box_model(name, (length, 8, height), "plaster"))
                placed.append((name, at(x + length / 2, side * (setback + 4), height / 2)))
        x += length + rng.uniform(0, 14)
    places = rng.uniform([6, -5], [60, -4], (20, 2)) * rng.choice([-1, 1], (20, 2))
    placed += [("car", at(cx, cy, 0.75)) for cx, cy in places]
    materials = {name: Material(name, (0.5, 0.5, 0.5), remission=value) for name, value in REMISSION.items()}
    return RayCaster(make_scene(models, placed, materials=materials))


def test_a_street_gives_as_many_points_as_kitti() -> None:
    counts = [
        len(scan(street(seed, width), LidarConfig(), at(0, 0, 1.73), np.random.default_rng(0)).points)
        for seed in range(3)
        for width in (8.0, 12.0, 20.0)
    ]
    assert np.mean(counts) == pytest.approx(KITTI_POINTS, rel=0.15)
    assert min(counts) > 0.85 * KITTI_POINTS
    assert max(counts) < 1.15 * KITTI_POINTS
