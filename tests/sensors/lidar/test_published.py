"""LiDAR presets against what is published of them, from the points of their sweeps alone."""

import numpy as np
import pytest

from tests.sensors.lidar.published import PUBLISHED, ROADS
from tests.sensors.lidar.sweeps import UNITS, angles, errors, floor_spread, spread
from tests.stored import held
from warehouse_sim.render.conformance.scenes import at, box_model, make_scene
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.schema import Material
from warehouse_sim.sensors.lidar import LIDAR_PRESETS, LidarConfig, scan


@pytest.mark.parametrize("model", PUBLISHED)
def test_beams_look_where_the_source_says_and_turn_its_way(model: str) -> None:
    found = angles(model, PUBLISHED[model])
    assert found["lasers"] == PUBLISHED[model].lasers
    assert found["elevation: largest error (deg)"] < 0.01
    assert found["azimuth beside the first laser: largest error (deg)"] < 0.01
    rate = PUBLISHED[model].spin * LIDAR_PRESETS[model].turns_per_second
    assert found["turns a second, counter-clockwise"] == pytest.approx(rate, rel=2e-3)


@pytest.mark.parametrize(
    "model", ["vlp16", "safety2d", *(pytest.param(name, marks=pytest.mark.slow) for name in ("hdl64e", "os1_128"))]
)
def test_points_and_errors_are_as_published(model: str) -> None:
    found, published = errors(model), PUBLISHED[model]
    assert found["points a second"] == pytest.approx(published.points_a_second, rel=0.15)
    assert found["noise from pulse to pulse (mm)"] == pytest.approx(published.noise_mm, rel=0.15)
    if published.bias_mm is not None:
        assert found["bias from laser to laser (mm)"] == pytest.approx(published.bias_mm, rel=0.15, abs=1.0)
    said = (published.points_a_second, published.noise_mm, published.bias_mm)
    rows = [
        {"name": f"{model}: {key}", "value": value, "published": of, "source": published.source}
        for (key, value), of in zip(found.items(), (*said, None, None), strict=True)
    ]
    stored = held("lidar_presets", __file__, rows)
    assert all(
        value == pytest.approx(stored[f"{model}: {key}"]["value"], rel=0.02, abs=0.1) for key, value in found.items()
    )


@pytest.mark.slow
def test_a_floor_is_as_uneven_as_a_real_road() -> None:
    """No worse than 1.5 times as even as the evener of two KITTI sweeps, no more uneven than the other."""
    patches = [floor_spread(LidarConfig(), number) for number in range(UNITS)]
    found = {key: float(np.median([patch[key] for patch in patches])) for key in patches[0]}
    rows = [{"name": f"floor, hdl64e: {key}", "value": found[key], "roads": ROADS[key]} for key in found]
    stored = held("lidar_presets", __file__, rows)
    for key, value in found.items():
        assert min(ROADS[key]) / 1.5 < value < max(ROADS[key])
        assert value == pytest.approx(stored[f"floor, hdl64e: {key}"]["value"], rel=0.02)


def test_a_floors_spread_within_rings_is_that_which_is_stored() -> None:
    found, name = floor_spread(LidarConfig(), 0)["within rings (%)"], "floor, hdl64e: within rings (%)"
    assert found == pytest.approx(held("lidar_presets", __file__, [])[name]["value"], rel=0.15)


def test_spread_is_split_into_rings_and_what_is_between_them() -> None:
    rng = np.random.default_rng(0)
    ring = np.repeat(np.arange(20), 200)
    points = np.stack([5.1 + 0.14 * ring, rng.uniform(-2, 2, len(ring)), np.full(len(ring), -1.73)], axis=1)
    level = rng.normal(1.0, 0.2, 20)
    found = spread(points, 0.3 * level[ring] * rng.normal(1.0, 0.1, len(ring)), ring)
    assert found["within rings (%)"] == pytest.approx(10.0, rel=0.1)
    assert found["from ring to ring (%)"] == pytest.approx(100.0 * level.std() / level.mean(), rel=0.1)


# In a street, a sweep of the default LiDAR has about as many points as KITTI's.


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
