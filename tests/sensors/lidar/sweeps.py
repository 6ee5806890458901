"""What the points of a sweep alone tell of a LiDAR preset: angles, turn, points a second, noise, bias, intensities.

The same beams are cast in two square halls, of 20 m and of 60 m; the line through both points of a beam says where it
looks and nothing else does. Errors are what a noisy sweep of a unit differs by, along the beam, from an even one;
their means over a laser's points are its bias. Intensities are those of a floor, in patches 5-8 m ahead as wide as a
lane: over all points, within rings, and from ring to ring.
"""

from dataclasses import replace

import numpy as np
from jaxtyping import Float, Int

from tests.sensors.lidar.published import Published
from warehouse_sim.catalog.materials import materials
from warehouse_sim.render.conformance.scenes import at, box_model, make_scene
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.schema import LidarScan, SceneSpec
from warehouse_sim.sensors.lidar import LIDAR_PRESETS, LidarConfig, scan
from warehouse_sim.sensors.lidar.finishes import finishes_of
from warehouse_sim.sensors.lidar.receiver import LidarUnit

HALLS = (4.5, 30.0)
"""Half the edges of the halls (m); also an indoor scanner of 10 m reaches the corners of the first."""
UNITS = 12
NEAREST, FARTHEST, HALF_LANE = 5.0, 8.0, 2.5
"""The patch of floor ahead (m)."""
Values = dict[str, float]


def hall(half: float, material: str = "wall_paint") -> SceneSpec:
    """Return a cube's inside, seen from its middle."""
    slab = box_model("slab", (2.0, 4 * half, 4 * half), material)
    deck = box_model("deck", (4 * half, 4 * half, 2.0), material)
    placed = [("slab", at(side * (half + 1.0), 0, 0)) for side in (-1, 1)]
    placed += [("slab", at(0, side * (half + 1.0), 0, np.pi / 2)) for side in (-1, 1)]
    placed += [("deck", at(0, 0, side * (half + 1.0))) for side in (-1, 1)]
    return make_scene([slab, deck], placed, materials=materials())


def beams(model: str) -> tuple[Float[np.ndarray, "n 3"], Int[np.ndarray, " n"], Float[np.ndarray, " n"]]:
    """Return unit vectors, rings and times of all beams that a sweep shows."""
    config = replace(LIDAR_PRESETS[model].ideal(), min_range=0.0, max_range=200.0)
    near, far = (scan(RayCaster(hall(half)), config, at(0, 0, 0), np.random.default_rng(0)) for half in HALLS)
    assert len(near.points) == len(far.points)
    way = far.points.astype(float) - near.points
    return way / np.linalg.norm(way, axis=1, keepdims=True), near.ring, near.time.astype(float)


def angles(model: str, published: Published) -> Values:
    """Return how far elevations and azimuths are from the published ones, and how fast the head turns."""
    config = LIDAR_PRESETS[model]
    way, ring, time = beams(model)
    elevation, azimuth = np.degrees(np.arcsin(way[:, 2])), np.degrees(np.arctan2(way[:, 1], way[:, 0]))
    step, rate = config.azimuth_step_deg, 360.0 * config.turns_per_second
    head = published.spin * step * np.floor(time * rate / step + 1e-2)
    aside = _circular(azimuth - head)
    first = np.median(aside[ring == published.left_deg[0][0]])
    wrong_up = [np.abs(elevation[ring == k] - value).max() for k, value in published.elevation_deg]
    wrong_aside = [np.abs(np.median(_circular(aside[ring == k] - first - value))) for k, value in published.left_deg]
    middle = ring == published.left_deg[0][0]
    turned = np.unwrap(azimuth[middle], period=360.0)
    return {
        "lasers": float(len(np.unique(ring))),
        "elevation: largest error (deg)": float(max(wrong_up)),
        "azimuth beside the first laser: largest error (deg)": float(max(wrong_aside)),
        "turns a second, counter-clockwise": float((turned[-1] - turned[0]) / 360.0 / np.ptp(time[middle])),
    }


def errors(model: str) -> Values:
    """Return points a second and errors along the beams, over units (mm)."""
    config = replace(LIDAR_PRESETS[model], azimuth_phase="fixed", divergence_mrad=(0.0, 0.0), every_nth_beam=1)
    caster, place = RayCaster(hall(HALLS[0])), at(0, 0, 0)
    even = scan(caster, config.ideal(), place, np.random.default_rng(0))
    means, within, counts = [], [], []
    for number in range(UNITS):
        unit = LidarUnit.sample(config, np.random.default_rng(number))
        read = scan(caster, config, place, np.random.default_rng(100 + number), unit=unit)
        _, a, b = np.intersect1d(_keys(even), _keys(read), return_indices=True)
        reach = np.linalg.norm(even.points[a].astype(float), axis=1)
        along = ((read.points[b] - even.points[a]) * even.points[a].astype(float)).sum(axis=1) / reach
        ring = even.ring[a]
        counts.append(len(read.points))
        means += [along[ring == k].mean() for k in np.unique(ring)]
        within += [along[ring == k].std() for k in np.unique(ring)]
    return {
        "points a second": float(np.mean(counts)) * config.turns_per_second,
        "noise from pulse to pulse (mm)": 1000.0 * float(np.median(within)),
        "bias from laser to laser (mm)": 1000.0 * float(np.std(means)),
        "largest bias (mm)": 1000.0 * float(np.abs(means).max()),
        "all errors (mm)": 1000.0 * float(np.sqrt(np.mean(np.square(means)) + np.mean(np.square(within)))),
    }


def floor_spread(config: LidarConfig, number: int) -> Values:
    """Return the spread of the intensities of a concrete floor 1.73 m below one unit in one scene."""
    scene = make_scene(
        [box_model("floor", (60, 60, 2.0), "concrete")], [("floor", at(0, 0, -2.73))], materials=materials()
    )
    caster, rng = RayCaster(scene), np.random.default_rng(number)
    finishes = finishes_of(scene, caster.materials, config.brightness, rng)
    unit = LidarUnit.sample(config, rng)
    read = scan(caster, config, at(0, 0, 0), rng, unit=unit, finishes=finishes)
    return spread(read.points.astype(float), read.intensity.astype(float), read.ring)


def spread(points: Float[np.ndarray, "n 3"], intensity: Float[np.ndarray, " n"], ring: Int[np.ndarray, " n"]) -> Values:
    """Return relative standard deviations of the intensities on the floor ahead."""
    x, y, z = points.T
    chosen = (x > NEAREST) & (x < FARTHEST) & (np.abs(y) < HALF_LANE) & (z < -1.2)
    plane = np.c_[points[chosen, :2], np.ones(chosen.sum())]
    height = z[chosen] - plane @ np.linalg.lstsq(plane, z[chosen], rcond=None)[0]
    flat = np.flatnonzero(chosen)[np.abs(height) < 0.05]
    values, rings = intensity[flat], ring[flat]
    per = [values[rings == k] for k in np.unique(rings) if (rings == k).sum() > 30]
    means = np.array([item.mean() for item in per])
    return {
        "over all points (%)": 100.0 * float(values.std() / values.mean()),
        "within rings (%)": 100.0 * float(np.median([item.std() / item.mean() for item in per])),
        "from ring to ring (%)": 100.0 * float(means.std() / means.mean()),
    }


def _keys(read: LidarScan) -> Int[np.ndarray, " n"]:
    """Return a number of each beam, the same in each sweep: time in steps of 10 ns, and ring."""
    keys: Int[np.ndarray, " n"] = np.rint(read.time.astype(float) * 1e8).astype(np.int64) * 256 + read.ring
    return keys


def _circular(degrees: Float[np.ndarray, " n"]) -> Float[np.ndarray, " n"]:
    return (degrees + 180.0) % 360.0 - 180.0
