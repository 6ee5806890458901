"""Film before a wall: which echo is reported, how strong it is and whose."""

from dataclasses import replace

import numpy as np
import pytest

from tests.sensors.film.test_sight import film_model
from tests.sensors.film.test_sight import scene_of as film_scene
from warehouse_sim.render.conformance.scenes import at, box_model
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.schema import LidarScan, SceneSpec
from warehouse_sim.sensors.film import FilmSight
from warehouse_sim.sensors.film.sight import pile_reflectance
from warehouse_sim.sensors.lidar import LIDAR_PRESETS, LidarConfig, scan

QUIET = replace(LidarConfig().ideal(), film=True, divergence_mrad=(2.0, 2.0), azimuth_range_deg=(-40.0, 40.0))
FILM_ID, WALL_ID = 2, 1


def before_wall(gap: float, film: bool = True) -> SceneSpec:
    """A sheet with its face at x = 3, and a wall of remission 0.4 behind it."""
    placed = [(box_model("wall", (0.2, 30, 20), "wood"), at(3.1 + gap, 0, 0))]
    return film_scene(*placed, *([(film_model((0.002, 6.0, 6.0)), at(3.001, 0, 0))] if film else []))


def read(scene: SceneSpec, config: LidarConfig = QUIET, *, film: bool = True) -> LidarScan:
    sight = FilmSight(scene) if film else None
    return scan(RayCaster(scene), config, at(0, 0, 0), np.random.default_rng(0), film=sight)


def test_film_far_before_a_wall_gives_two_returns_of_one_pulse() -> None:
    found = read(before_wall(2.0), replace(QUIET, returns="dual"))
    film, wall = (found.points[found.instance_ids == number] for number in (FILM_ID, WALL_ID))
    np.testing.assert_allclose(film[:, 0], 3.0, atol=1e-3)
    np.testing.assert_allclose(wall[:, 0], 5.0, atol=1e-3)
    assert len(film) > 0.9 * len(wall[np.abs(wall[:, 1]) < 4.8])


def test_the_strongest_is_the_film_near_its_normal_and_the_wall_elsewhere() -> None:
    found = read(before_wall(2.0))
    angle = np.degrees(np.arccos(found.points[:, 0] / np.linalg.norm(found.points, axis=1)))
    on_film = found.instance_ids == FILM_ID
    assert on_film[angle < 2].mean() > 0.2
    assert on_film[(angle > 20) & (angle < 35)].mean() < 0.02
    last = read(before_wall(2.0), replace(QUIET, returns="last"))
    assert (last.instance_ids == WALL_ID).all()


def test_the_echo_behind_has_passed_the_film_twice() -> None:
    through, bare = (read(before_wall(2.0), replace(QUIET, returns="last"), film=film) for film in (True, False))
    np.testing.assert_allclose(through.points, bare.points, atol=2e-6)
    cosine = bare.points[:, 0] / np.linalg.norm(bare.points, axis=1)
    covered = np.abs(bare.points[:, 1:] * 3 / 5).max(axis=1) < 2.95
    expected = np.where(covered, (1 - pile_reflectance(cosine, 1.0)) ** 2, 1.0) * bare.intensity
    clear = np.abs(np.abs(bare.points[:, 1:] * 3 / 5).max(axis=1) - 3.0) > 0.05
    np.testing.assert_allclose(through.intensity[clear], expected[clear], atol=1.01 / 255)


def test_film_within_a_pulse_draws_the_point_towards_itself() -> None:
    """The mean distance by power, per ray and by hand: diffuse film, no highlight in sight."""
    found = read(before_wall(0.4))
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
    bare, seen = read(scene, config, film=False), read(scene, config)
    for channel in ("points", "intensity", "instance_ids", "ring", "time"):
        assert getattr(bare, channel).tobytes() == getattr(seen, channel).tobytes()
