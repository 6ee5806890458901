"""Intensity is no name of the material: what it varies with, each seen alone."""

from dataclasses import replace

import numpy as np
import pytest

from warehouse_sim.errors import ConfigError
from warehouse_sim.render.conformance.scenes import at, box_model, make_scene
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.schema import LidarScan, Material, SceneSpec
from warehouse_sim.sensors.lidar import LIDAR_PRESETS, LidarConfig, scan
from warehouse_sim.sensors.lidar.finishes import BrightnessConfig, finishes_of
from warehouse_sim.sensors.lidar.receiver import LidarUnit

QUIET = replace(LidarConfig().ideal(), azimuth_range_deg=(-30.0, 30.0))


def two_walls(material: Material, yaw: float = 0.0) -> SceneSpec:
    """Two walls of one material, 6 m ahead to the left and to the right, too thin to show their sides."""
    models = [box_model("left", (1e-4, 3, 8), material.name), box_model("right", (1e-4, 3, 8), material.name)]
    placed = [("left", at(6.0, 1.6, 0, yaw)), ("right", at(6.0, -1.6, 0, yaw))]
    return make_scene(models, placed, materials={material.name: material})


def read(scene: SceneSpec, brightness: BrightnessConfig, seed: int = 0, unit_seed: int = 5) -> LidarScan:
    """Return a sweep of a unit in a scene whose surfaces are always rendered alike."""
    config, caster = replace(QUIET, brightness=brightness), RayCaster(scene)
    return scan(
        caster,
        config,
        at(0, 0, 0),
        np.random.default_rng(seed),
        unit=LidarUnit.sample(config, np.random.default_rng(unit_seed)),
        finishes=finishes_of(scene, caster.materials, brightness, np.random.default_rng(7)),
    )


GREY = Material("grey", (0.4, 0.4, 0.4), roughness=0.9, remission=0.5)


def relative(result: LidarScan, scene_remission: float = 0.5) -> np.ndarray:
    """Return intensities over those of even matt walls seen at the same angle."""
    cosine = result.points[:, 0] / np.linalg.norm(result.points, axis=1)
    return result.intensity / (scene_remission * cosine)


def test_without_any_of_it_intensity_is_remission_times_cosine() -> None:
    # A code is 0.5 %, and lasers up to 0.2 m above the origin see the wall at another angle than it would.
    assert np.abs(relative(read(two_walls(GREY), BrightnessConfig.even())) - 1.0).max() < 0.02


def test_speckle_differs_from_pulse_to_pulse() -> None:
    only = replace(BrightnessConfig.even(), speckle=0.15)
    one, two = (relative(read(two_walls(GREY), only, seed)) for seed in (0, 1))
    assert np.log(one).std() == pytest.approx(0.15, rel=0.05)
    assert abs(np.corrcoef(one[:5000], two[:5000])[0, 1]) < 0.1


def test_each_laser_has_its_gain_in_every_sweep_and_in_each_unit_another() -> None:
    only = replace(BrightnessConfig.even(), laser_gain=0.12)

    def gains(unit_seed: int, seed: int) -> np.ndarray:
        result = read(two_walls(GREY), only, seed, unit_seed)
        return np.array([np.log(relative(result)[result.ring == ring]).mean() for ring in range(5, 60)])

    assert gains(5, 0).std() == pytest.approx(0.12, rel=0.2)
    np.testing.assert_allclose(gains(5, 0), gains(5, 1), atol=1e-3)
    assert abs(np.corrcoef(gains(5, 0), gains(6, 0))[0, 1]) < 0.4


def test_equal_objects_differ() -> None:
    result = read(two_walls(GREY), replace(BrightnessConfig.even(), object_jitter=0.1))
    left, right = (relative(result)[result.instance_ids == number].mean() for number in (1, 2))
    assert 0.01 < abs(left - right) < 0.6
    again = read(two_walls(GREY), replace(BrightnessConfig.even(), object_jitter=0.1), seed=4, unit_seed=8)
    assert relative(again)[again.instance_ids == 1].mean() == pytest.approx(left, abs=2e-3)


def test_grain_lies_still_from_sweep_to_sweep() -> None:
    wood = replace(GREY, texture="wood_worn", texture_size=0.5)
    only = replace(BrightnessConfig.even(), grain=1.0)
    one, two = (relative(read(two_walls(wood), only, seed)) for seed in (0, 1))
    assert np.log(one).std() > 0.06
    np.testing.assert_array_equal(one, two)
    assert np.log(relative(read(two_walls(GREY), only))).std() < 0.01


def test_what_calibration_leaves_goes_with_the_distance() -> None:
    only = replace(BrightnessConfig.even(), range_residual=0.1)
    unit = LidarUnit.sample(replace(QUIET, brightness=only), np.random.default_rng(1))
    distance = np.float32(np.geomspace(2.0, 100.0, 4000))
    left = unit.residual_at(distance)
    assert left.std() == pytest.approx(0.1, rel=0.35)
    assert np.abs(left).max() <= 0.2 + 1e-6
    assert np.abs(np.diff(left)).max() < 0.08


def test_steel_shines_where_it_faces_the_sensor_and_is_dim_beside() -> None:
    steel = Material("bare", (0.5, 0.5, 0.5), roughness=0.3, metallic=0.8, remission=0.9)
    only = replace(BrightnessConfig.even(), gloss=True)
    facing, turned = (read(two_walls(steel, yaw), only) for yaw in (0.0, 0.7))
    straight = facing.points[:, 0] / np.linalg.norm(facing.points, axis=1) > 0.995
    assert facing.intensity[straight].mean() > 0.95
    assert turned.intensity.mean() < 0.25
    matt = read(two_walls(replace(steel, roughness=0.9, metallic=0.0)), only)
    assert np.ptp(matt.intensity[straight]) < 0.05


def test_a_smooth_floor_is_dim_where_it_is_seen_from_afar() -> None:
    def far(roughness: float) -> float:
        floor = Material("floor", (0.3, 0.3, 0.3), roughness=roughness, remission=0.35)
        scene = make_scene(
            [box_model("floor", (80, 80, 1), "floor")], [("floor", at(0, 0, -2.2))], materials={"floor": floor}
        )
        result = read(scene, replace(BrightnessConfig.even(), gloss=True))
        reach = np.hypot(result.points[:, 0], result.points[:, 1])
        cosine = np.abs(result.points[:, 2]) / np.linalg.norm(result.points, axis=1)
        away = (reach > 9) & (reach < 12)
        return float((result.intensity[away] / cosine[away]).mean())

    assert far(0.1) < 0.6 * far(0.9)
    assert far(0.9) == pytest.approx(0.35, rel=0.1)


def test_brightness_is_read_from_a_word_or_over_the_preset() -> None:
    assert LidarConfig.from_plain({"brightness": "even"}, "here").brightness == BrightnessConfig.even()
    found = LidarConfig.from_plain({"model": "vlp16", "brightness": {"speckle": 0.3}}, "here").brightness
    assert found == replace(LIDAR_PRESETS["vlp16"].brightness, speckle=0.3)
    with pytest.raises(ConfigError, match="here: brightness: spekle is not a setting; did you mean 'speckle'"):
        LidarConfig.from_plain({"brightness": {"spekle": 0.3}}, "here")
    with pytest.raises(ConfigError, match="grain"):
        BrightnessConfig(grain=-1.0)
