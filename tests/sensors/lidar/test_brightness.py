"""Intensity is no name of the material: what it varies with, each seen alone."""

from dataclasses import replace

import numpy as np
import pytest

from tests.sensors.test_film import film_model
from tests.sensors.test_film import scene_of as film_scene
from warehouse_sim.errors import ConfigError
from warehouse_sim.render.conformance.scenes import at, box_model, make_scene
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.schema import LidarScan, Material, SceneSpec
from warehouse_sim.sensors.film import FilmSight
from warehouse_sim.sensors.film.sight import pile_reflectance
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


# Film before a wall: which echo is reported, how strong it is and whose.


SINGLE = replace(LidarConfig().ideal(), film=True, divergence_mrad=(2.0, 2.0), azimuth_range_deg=(-40.0, 40.0))
FILM_ID, WALL_ID = 2, 1


def before_wall(gap: float, film: bool = True) -> SceneSpec:
    """A sheet with its face at x = 3, and a wall of remission 0.4 behind it."""
    placed = [(box_model("wall", (0.2, 30, 20), "wood"), at(3.1 + gap, 0, 0))]
    return film_scene(*placed, *([(film_model((0.002, 6.0, 6.0)), at(3.001, 0, 0))] if film else []))


def read_through(scene: SceneSpec, config: LidarConfig = SINGLE, *, film: bool = True) -> LidarScan:
    sight = FilmSight(scene) if film else None
    return scan(RayCaster(scene), config, at(0, 0, 0), np.random.default_rng(0), film=sight)


def test_film_far_before_a_wall_gives_two_returns_of_one_pulse() -> None:
    found = read_through(before_wall(2.0), replace(SINGLE, returns="dual"))
    film, wall = (found.points[found.instance_ids == number] for number in (FILM_ID, WALL_ID))
    np.testing.assert_allclose(film[:, 0], 3.0, atol=1e-3)
    np.testing.assert_allclose(wall[:, 0], 5.0, atol=1e-3)
    assert len(film) > 0.9 * len(wall[np.abs(wall[:, 1]) < 4.8])


def test_the_strongest_is_the_film_near_its_normal_and_the_wall_elsewhere() -> None:
    found = read_through(before_wall(2.0))
    angle = np.degrees(np.arccos(found.points[:, 0] / np.linalg.norm(found.points, axis=1)))
    on_film = found.instance_ids == FILM_ID
    assert on_film[angle < 2].mean() > 0.2
    assert on_film[(angle > 20) & (angle < 35)].mean() < 0.02
    last = read_through(before_wall(2.0), replace(SINGLE, returns="last"))
    assert (last.instance_ids == WALL_ID).all()


def test_the_echo_behind_has_passed_the_film_twice() -> None:
    through, bare = (
        read_through(before_wall(2.0), replace(SINGLE, returns="last"), film=film) for film in (True, False)
    )
    np.testing.assert_allclose(through.points, bare.points, atol=2e-6)
    cosine = bare.points[:, 0] / np.linalg.norm(bare.points, axis=1)
    covered = np.abs(bare.points[:, 1:] * 3 / 5).max(axis=1) < 2.95
    expected = np.where(covered, (1 - pile_reflectance(cosine, 1.0)) ** 2, 1.0) * bare.intensity
    clear = np.abs(np.abs(bare.points[:, 1:] * 3 / 5).max(axis=1) - 3.0) > 0.05
    np.testing.assert_allclose(through.intensity[clear], expected[clear], atol=1.01 / 255)


def test_film_within_a_pulse_draws_the_point_towards_itself() -> None:
    """The mean distance by power, per ray and by hand: diffuse film, no highlight in sight."""
    found = read_through(before_wall(0.4))
    assert set(found.instance_ids.tolist()) == {FILM_ID, WALL_ID}
    off = 3.4 - found.points[:, 0]
    assert (off > -1e-3).all()
    ranges = np.linalg.norm(found.points, axis=1)
    cosine = found.points[:, 0] / ranges
    plain = (np.degrees(np.arccos(cosine)) > 25) & (np.abs(found.points[:, 1:]).max(axis=1) < 2.5)
    film = 0.25 * 0.02 * cosine / (3.0 / cosine) ** 2
    wall = 0.4 * cosine * (1 - pile_reflectance(cosine, 1.0)) ** 2 / (3.4 / cosine) ** 2
    expected = 0.4 * film / (film + wall)
    assert np.median((off - expected)[plain]) == pytest.approx(0.0, abs=2e-3)


@pytest.mark.parametrize("name", list(LIDAR_PRESETS))
def test_without_film_in_view_no_byte_changes(name: str) -> None:
    config = replace(LIDAR_PRESETS[name], azimuth_step_deg=1.0)
    assert config.film
    scene = before_wall(2.0, film=False)
    bare, seen = read_through(scene, config, film=False), read_through(scene, config)
    for channel in ("points", "intensity", "instance_ids", "ring", "time"):
        assert getattr(bare, channel).tobytes() == getattr(seen, channel).tobytes()
