"""Beams with a width, at the edge of a plate before a wall."""

from dataclasses import replace

import numpy as np
import pytest

from warehouse_sim.render.conformance.scenes import at, box_model, make_scene
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.schema import Material
from warehouse_sim.sensors.lidar import LIDAR_PRESETS, LidarConfig, scan
from warehouse_sim.sensors.lidar.echo import Echoes, PulseEchoes
from warehouse_sim.sensors.lidar.sweep import make_sweep

QUIET = replace(LidarConfig().ideal(), divergence_mrad=(2.0, 2.0), azimuth_range_deg=(-20.0, 20.0))


def plate_and_wall(gap: float, plate: float = 0.5, wall: float = 0.5) -> RayCaster:
    """A plate with its face at x = 6 whose edge is the plane y = 0, and a wall behind it."""
    materials = {name: Material(name, (0.5, 0.5, 0.5), remission=value) for name, value in (("a", plate), ("b", wall))}
    models = [box_model("plate", (0.02, 40, 40), "a"), box_model("wall", (1, 80, 80), "b")]
    placed = [("plate", at(6.01, -20, 0)), ("wall", at(6.5 + gap, 0, 0))]
    return RayCaster(make_scene(models, placed, materials=materials))


def between(raycaster: RayCaster, config: LidarConfig, gap: float) -> np.ndarray:
    """Return how far behind the plate points lie that are on neither surface, as a fraction of the gap."""
    result = scan(raycaster, config, at(0, 0, 0), np.random.default_rng(0))
    fraction = (result.points[:, 0].astype(float) - 6.0) / gap
    return fraction[(fraction > 0.01) & (fraction < 0.99)]


def test_an_edge_within_the_pulse_gives_points_between_the_surfaces() -> None:
    raycaster = plate_and_wall(0.4)
    assert len(between(raycaster, replace(QUIET, divergence_mrad=(0.0, 0.0)), 0.4)) == 0
    fractions = between(raycaster, QUIET, 0.4)
    sweep = make_sweep(QUIET)
    x, y, _ = sweep.directions.T.astype(float)
    at_plate = [
        sweep.origins[:, 1] + (6.0 - sweep.origins[:, 0]) * (y + side * x / level) / (x - side * y / level)
        for level in [np.hypot(x, y)]
        for side in (-0.571e-3, 0.0, 0.571e-3)
    ]
    crossed = np.ptp(np.sign(at_plate), axis=0) > 0
    assert len(fractions) == crossed.sum() > 10
    # Two to four rays look at a beam; some of the light goes to the far surface, which sends less of it back.
    far = np.array([1 / 4, 1 / 3, 1 / 2, 2 / 3, 3 / 4])
    near_power, far_power = (1 - far) / 6.0**2, far / 6.4**2
    expected = far_power / (near_power + far_power)
    assert np.abs(fractions[:, None] - expected).min(axis=1).max() < 0.01


def test_edges_above_and_below_count_as_well() -> None:
    """A plate below the horizon: only the vertical width meets its upper edge."""
    models = [box_model("plate", (0.02, 40, 2.0)), box_model("wall", (1, 80, 80))]
    raycaster = RayCaster(make_scene(models, [("plate", at(6.01, 0, -1.45)), ("wall", at(6.9, 0, 0))]))
    flat = between(raycaster, replace(QUIET, divergence_mrad=(2.0, 0.0)), 0.4)
    tall = between(raycaster, replace(QUIET, divergence_mrad=(0.0, 8.0)), 0.4)
    on_top = 0.02 / 0.4 + 0.01
    assert (flat > on_top).sum() < 5  # where the ring's curve crosses the edge
    assert (tall > on_top).sum() > 50


@pytest.mark.parametrize("name", LIDAR_PRESETS)
def test_every_lidar_sees_an_empty_world_and_a_full_one(name: str) -> None:
    nothing = RayCaster(make_scene([box_model("far", (1, 1, 1))], [("far", at(500, 0, 0))]))
    result = scan(nothing, LIDAR_PRESETS[name], at(0, 0, 0), np.random.default_rng(0))
    assert len(result.points) == 0
    assert result.points.shape == (0, 3)
    assert len(scan(plate_and_wall(0.4), LIDAR_PRESETS[name], at(0, 0, 0), np.random.default_rng(0)).points) > 50


def test_the_strongest_echo_is_blended_by_power() -> None:
    inf = np.inf
    fractions = Echoes(
        np.float32([[10.0, 10.3, 20.0], [10.0, inf, 20.0], [inf, inf, inf], [5.0, 30.0, 30.2]]),
        np.float32([[0.2, 0.2, 0.3], [0.1, 0.0, 0.9], [0.0, 0.0, 0.0], [0.001, 0.4, 0.4]]),
        np.int32([[1, 2, 3], [1, 0, 3], [0, 0, 0], [1, 2, 3]]),
    )
    echoes = PulseEchoes.of(fractions, pulse_length=0.75, extinction=0.0).pick("strongest")
    first, second = 0.2 / 10**2, 0.2 / 10.3**2
    blend = (first * 10 + second * 10.3) / (first + second)
    np.testing.assert_allclose(echoes.distance, [blend, 20.0, inf, 30.0996], rtol=1e-5)
    assert echoes.instance_ids.tolist() == [1, 3, 0, 2]
    assert echoes.reflectance[0] == pytest.approx((first + second) * blend**2, rel=1e-5)
    assert echoes.reflectance[1] == pytest.approx(0.9, rel=1e-5)
    assert echoes.reflectance[2] == 0.0
    dimmed = PulseEchoes.of(fractions, pulse_length=0.75, extinction=0.01).pick("strongest")
    assert dimmed.reflectance[1] == pytest.approx(0.9, rel=1e-5)  # of one surface, whatever dims light on both ways
