from dataclasses import replace

import numpy as np
import pytest

from warehouse_sim.config import from_mapping
from warehouse_sim.errors import ConfigError
from warehouse_sim.render.conformance.scenes import at, box_model, make_scene
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.schema import LidarScan, Material
from warehouse_sim.sensors.lidar import LIDAR_PRESETS, LidarConfig, scan
from warehouse_sim.sensors.lidar.echo import Echoes, PulseEchoes
from warehouse_sim.sensors.lidar.lasers import LASERS
from warehouse_sim.sensors.lidar.sweep import make_sweep
from warehouse_sim.sensors.rig import RigConfig


def test_the_hdl64e_spans_what_its_data_sheet_says_but_irregularly() -> None:
    lasers = LASERS["hdl64e"]()
    elevation = np.sort(np.degrees(lasers.elevation))[::-1]
    assert len(elevation) == 64
    assert elevation[0] == pytest.approx(2.0, abs=0.1)
    assert elevation[-1] == pytest.approx(-24.9, abs=0.4)
    upper, lower = -np.diff(elevation[:32]), -np.diff(elevation[32:])
    assert upper.mean() == pytest.approx(1 / 3, abs=0.02)
    assert lower.mean() == pytest.approx(1 / 2, abs=0.02)
    assert upper.std() > 0.03
    assert lower.std() > 0.05
    assert set(np.round(lasers.left, 6)) == {0.026, -0.026}


def test_the_hdl64e_s2_is_the_calibrated_unit_of_the_drivers() -> None:
    """Three rows of 64e_s2.1-sztaki.yaml, as they stand there (rad, m)."""
    lasers = LASERS["hdl64e_s2"]()
    rows = np.stack([lasers.elevation, lasers.azimuth, lasers.up, lasers.left], axis=1)[[0, 29, 41]]
    expected = [
        [-0.15304134919741974, -0.1248942899601548, 0.19548199, 0.026],
        [0.08674443287511571, 0.043892943273872005, 0.21282616, -0.026],
        [-0.3511493721000192, 0.1679293847080498, 0.11138678, -0.026],
    ]
    np.testing.assert_allclose(rows, expected, atol=6e-5)
    assert np.degrees(lasers.azimuth).max() == pytest.approx(9.6, abs=0.05)


def test_the_vlp16_fires_in_its_order_and_time() -> None:
    lasers = LASERS["vlp16"]()
    order = [-15, 1, -13, 3, -11, 5, -9, 7, -7, 9, -5, 11, -3, 13, -1, 15]
    np.testing.assert_allclose(np.degrees(lasers.elevation), order, atol=1e-12)
    np.testing.assert_allclose(lasers.delay, np.arange(16) * 2.304e-6)
    np.testing.assert_allclose(lasers.up[[0, 1, 2, 15]], [0.0112, -0.0007, 0.0097, -0.0112], atol=6e-5)
    assert lasers.rings()[-1] == 0
    assert lasers.rings()[0] == 15


def test_the_os1_is_a_measured_unit() -> None:
    """A few of the numbers in the metadata of part 840-103575-06, and what they have in common."""
    lasers = LASERS["os1_128"]()
    elevation, right = np.degrees(lasers.elevation), -np.degrees(lasers.azimuth)
    np.testing.assert_allclose(elevation[[0, 1, 63, 127]], [20.95, 20.67, -0.28, -21.82], atol=1e-9)
    np.testing.assert_allclose(right[[0, 1, 2, 3, 104, 127]], [4.21, 1.41, -1.4, -4.22, 4.22, -4.2], atol=1e-9)
    assert lasers.ahead == 0.015806
    np.testing.assert_allclose(right.reshape(-1, 4), np.broadcast_to([4.21, 1.41, -1.4, -4.21], (32, 4)), atol=0.031)
    steps = -np.diff(elevation)
    assert 0.27 < steps.min() < steps.max() < 0.38
    assert steps.std() > 0.01


@pytest.mark.parametrize(
    ("name", "per_second", "tolerance"),
    [("hdl64e", 1_333_000, 0.001), ("vlp16", 300_000, 0.04), ("os1_128", 2_621_440, 0.0), ("safety2d", 271 * 15, 0.0)],
)
def test_shots_a_second_are_those_of_the_data_sheet(name: str, per_second: int, tolerance: float) -> None:
    config = LIDAR_PRESETS[name]
    assert len(make_sweep(config).time) * config.turns_per_second == pytest.approx(per_second, rel=tolerance)


def test_a_preset_is_named_alone_or_with_what_differs() -> None:
    assert from_mapping(RigConfig, {"lidar": "vlp16"}, "here").lidar == LIDAR_PRESETS["vlp16"]
    changed = from_mapping(RigConfig, {"lidar": {"model": "vlp16", "range_noise": 0}}, "here").lidar
    assert changed == replace(LIDAR_PRESETS["vlp16"], range_noise=0.0)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (
            "vlp32",
            "here: lidar: 'vlp32' is no LiDAR preset (did you mean 'vlp16'?); known: hdl64e, hdl64e_s2, vlp16, os1_128",
        ),
        ({"model": ["vlp16"]}, "here: lidar: ['vlp16'] is no LiDAR preset"),
        ({"rage_noise": 1}, "here: lidar: rage_noise is not a setting; did you mean 'range_noise'?"),
        (3, "here: lidar: expected a mapping of settings, found 3"),
    ],
)
def test_wrong_presets_are_named_with_their_place(data: object, message: str) -> None:
    with pytest.raises(ConfigError) as caught:
        from_mapping(RigConfig, {"lidar": data}, "here")
    assert message in str(caught.value)


@pytest.mark.parametrize("settings", [{"azimuth_range_deg": (10.0, 5.0)}, {"max_range": 0.1}])
def test_impossible_settings_are_rejected_by_name(settings: dict) -> None:
    with pytest.raises(ConfigError, match=next(iter(settings))):
        LidarConfig(**settings)


# Second returns, and what shines beside a retroreflector.


QUIET = replace(LidarConfig().ideal(), divergence_mrad=(2.0, 2.0), azimuth_range_deg=(-20.0, 20.0))


def read(raycaster: RayCaster, config: LidarConfig) -> LidarScan:
    return scan(raycaster, config, at(0, 0, 0), np.random.default_rng(0))


def test_an_edge_before_a_wall_gives_two_returns_of_one_pulse() -> None:
    raycaster = plate_and_wall(2.0)
    strongest, last, dual = (read(raycaster, replace(QUIET, returns=which)) for which in ("strongest", "last", "dual"))
    assert len(strongest.points) == len(last.points) < len(dual.points)
    same = (dual.ring[1:] == dual.ring[:-1]) & (dual.time[1:] == dual.time[:-1])
    pairs = np.flatnonzero(same)
    assert len(pairs) == len(dual.points) - len(strongest.points) > 10
    apart = np.abs(dual.points[pairs + 1, 0] - dual.points[pairs, 0])
    np.testing.assert_allclose(apart, 2.0, atol=0.01)
    assert {*dual.instance_ids[pairs].tolist(), *dual.instance_ids[pairs + 1].tolist()} == {1, 2}
    assert (np.diff(dual.time) >= 0).all()
    # The first of each pulse is what a strongest return reports; where they differ, the last is the wall.
    firsts = np.delete(np.arange(len(dual.points)), pairs + 1)
    np.testing.assert_array_equal(dual.points[firsts], strongest.points)
    differ = np.abs(last.points[:, 0] - strongest.points[:, 0]) > 1e-3
    assert differ.any()
    assert (last.instance_ids[differ] == 2).all()


def test_the_last_and_the_second_strongest_echo_are_picked_by_hand() -> None:
    inf = np.inf
    fractions = Echoes(
        np.float32([[5.0, 10.0, 20.0], [5.0, 10.0, inf], [5.0, 5.2, inf], [inf, inf, inf], [5.0, 10.0, 20.0]]),
        np.float32([[0.5, 0.9, 0.1], [0.01, 0.9, 0.0], [0.4, 0.4, 0.0], [0.0, 0.0, 0.0], [0.01, 0.1, 9.0]]),
        np.int32([[1, 2, 3], [1, 2, 0], [1, 2, 0], [0, 0, 0], [1, 2, 3]]),
    )
    pulses = PulseEchoes.of(fractions, pulse_length=0.75, extinction=0.0)
    assert pulses.pick("strongest").instance_ids.tolist() == [1, 2, 1, 0, 3]
    last = pulses.pick("last")
    assert last.instance_ids.tolist() == [3, 2, 1, 0, 3]
    np.testing.assert_allclose(last.distance[[0, 1]], [20.0, 10.0])
    other = pulses.pick("other")
    assert other.instance_ids.tolist() == [3, 1, 0, 0, 2]
    np.testing.assert_allclose(other.distance, [20.0, 5.0, inf, inf, 10.0])
    assert other.reflectance[[2, 3]].tolist() == [0.0, 0.0]


def shining(remission: float) -> RayCaster:
    """A small plate 5 m ahead of a wall at 10 m."""
    materials = {
        "plate": Material("plate", (0.5, 0.5, 0.5), remission=remission),
        "wall": Material("wall", (0.5, 0.5, 0.5), remission=0.3),
    }
    models = [box_model("plate", (0.02, 0.3, 0.3), "plate"), box_model("wall", (1, 80, 80), "wall")]
    return RayCaster(make_scene(models, [("plate", at(5.01, 0, -0.2)), ("wall", at(10.5, 0, 0))], materials=materials))


def test_beams_beside_a_retroreflector_see_it_too() -> None:
    thin = replace(QUIET, divergence_mrad=(0.0, 0.0))
    without, with_bloom = (read(shining(2.0), replace(thin, bloom_deg=degrees)) for degrees in (0.0, 0.4))
    dull = read(shining(0.5), replace(thin, bloom_deg=0.4))
    near = [result.points[result.points[:, 0] < 5.5] for result in (without, with_bloom, dull)]
    assert len(near[0]) == len(near[2])
    assert len(near[1]) > 1.3 * len(near[0])
    # 30 % of remission at 10 m are 7.5 % at 5 m, which is what leaks at 0.2 deg log10(10 / 0.075) = 0.425 deg; lasers
    # start 26 mm beside the axis, 0.3 deg at 5 m, and a beam is 0.17 deg from the next.
    aside = np.degrees(np.arctan2(np.abs(near[1][:, 1]), near[1][:, 0])) - np.degrees(np.arctan2(0.15, 5.0))
    assert 0.25 < aside.max() < 0.425 + 0.3 + 0.17
    halo = with_bloom.points[:, 0] < 5.5
    nameless = with_bloom.instance_ids == 0
    assert (halo[nameless]).all()
    assert nameless.sum() == len(near[1]) - len(near[0])
    assert with_bloom.intensity[nameless].min() < 0.9


# Beams with a width, at the edge of a plate before a wall.


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
