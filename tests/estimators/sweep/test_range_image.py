"""Range images: where directions are, which point a pixel shows, what fills it."""

import numpy as np
import pytest

from warehouse_sim.errors import ConfigError
from warehouse_sim.estimators.sweep.grid import SweepGrid
from warehouse_sim.estimators.sweep.range_image import range_image
from warehouse_sim.estimators.sweep.settings import RangeImageConfig

GRID = SweepGrid(RangeImageConfig(columns=256, rows=96, elevation_deg=(-25.0, 7.0)))


def directions(elevation: np.ndarray, azimuth: np.ndarray) -> np.ndarray:
    level = np.cos(elevation)
    return np.stack([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)], axis=-1).reshape(-1, 3)


def test_pixels_lead_to_directions_and_back() -> None:
    u, v = np.meshgrid(np.arange(256) + 0.5, np.arange(96) + 0.5)
    places = np.stack([u.ravel(), v.ravel()], axis=1)
    rays = GRID.directions(places)
    np.testing.assert_allclose(np.linalg.norm(rays, axis=1), 1.0)
    np.testing.assert_allclose(GRID.places(7.3 * rays), places, atol=1e-9)
    np.testing.assert_array_equal(GRID.pixels(0.4 * rays), np.floor(places).astype(int))
    # Any turn of the image is the same direction.
    np.testing.assert_allclose(GRID.directions(places + np.array([256, 0])), rays, atol=1e-12)


@pytest.mark.parametrize(
    ("point", "u", "v"),
    [
        ((2.0, 0.0, 0.0), 128.0, 21.0),  # ahead, at the horizon: 7 of 32 degrees from the top
        ((0.0, 2.0, 0.0), 64.0, 21.0),  # to the left
        ((0.0, -2.0, 0.0), 192.0, 21.0),
        ((-2.0, 0.0, 0.0), 0.0, 21.0),  # behind, from the left
        ((-2.0, -1e-9, 0.0), 256.0, 21.0),  # behind, from the right
        ((2.0, 0.0, 2.0 * np.tan(np.deg2rad(-9.0))), 128.0, 48.0),
    ],
)
def test_known_directions_are_at_known_pixels(point: tuple[float, float, float], u: float, v: float) -> None:
    np.testing.assert_allclose(GRID.places(np.array([point]))[0], [u, v], atol=1e-6)


def test_what_lies_just_beside_the_seam_is_in_the_outer_columns() -> None:
    azimuth = np.array([np.pi, -np.pi, np.pi - 0.01, -np.pi + 0.01])
    pixels = GRID.pixels(directions(np.zeros(4), azimuth))
    assert pixels[:, 0].tolist() == [0, 0, 0, 255]
    np.testing.assert_allclose(GRID.apart(np.array([1.0, 255.0, 3.0]), np.array([255.0, 1.0, 1.0])), [2.0, -2.0, 2.0])
    outside = GRID.pixels(directions(np.deg2rad([8.0, -26.0]), np.zeros(2)))
    assert outside[:, 1].tolist() == [-1, -1]


def slow(points: np.ndarray) -> np.ndarray:
    """Which point each pixel shows by the definition, one pixel after the other."""
    shown = np.full((96, 256), -1)
    for number, (column, row) in enumerate(GRID.pixels(points)):
        if row >= 0:
            other = shown[row, column]
            if other < 0 or np.linalg.norm(points[number]) < np.linalg.norm(points[other]):
                shown[row, column] = number
    beside = shown.copy()
    for row in range(96):
        if (shown[row] >= 0).mean() > 0.5:
            for column in range(256):
                if shown[row, column] < 0:
                    left, right = shown[row, column - 1], shown[row, (column + 1) % 256]
                    beside[row, column] = left if left >= 0 else right
    gaps = [gap for column in beside.T for gap in np.diff(np.flatnonzero(column >= 0))]
    reach = int(np.ceil(np.percentile(gaps, 75) / 2))
    filled = np.full((96, 256), -1)
    for row in range(96):
        for column in range(256):
            rows = np.flatnonzero(beside[:, column] >= 0)
            if len(rows):
                nearest = rows[np.abs(rows - row).argmin()]
                if abs(nearest - row) <= reach:
                    filled[row, column] = beside[nearest, column]
    return filled


@pytest.mark.parametrize("seed", [0, 1])
def test_each_pixel_shows_what_a_slow_loop_finds(seed: int) -> None:
    rng = np.random.default_rng(seed)
    beams, steps = np.deg2rad(np.linspace(6.0, -24.0, 20)), np.linspace(-np.pi, np.pi, 300)
    elevation, azimuth = np.meshgrid(beams, steps, indexing="ij")
    rays = directions(
        elevation + rng.normal(0.0, 2e-3, elevation.shape), azimuth + rng.normal(0.0, 3e-3, azimuth.shape)
    )
    points = (rays * rng.uniform(1.0, 30.0, (len(rays), 1)))[rng.permutation(len(rays))[:4500]]
    seen = range_image(points, GRID)
    np.testing.assert_array_equal(seen.shown, slow(points))
    has = seen.shown >= 0
    np.testing.assert_allclose(seen.range[has], np.linalg.norm(points[seen.shown[has]], axis=1), rtol=1e-6)
    assert (seen.range[~has] == 0.0).all()
    assert 0.5 < has.mean() < 1.0


def test_a_sphere_has_one_range_and_a_floor_that_of_its_formula() -> None:
    elevation, azimuth = np.meshgrid(np.deg2rad(np.linspace(6.5, -24.5, 64)), np.linspace(-np.pi, np.pi, 700))
    rays = directions(elevation, azimuth)
    sphere = range_image(4.0 * rays, GRID)
    inside = sphere.shown >= 0
    assert inside[3:-3].all()
    np.testing.assert_allclose(sphere.range[inside], 4.0, rtol=1e-6)
    down = rays[rays[:, 2] < -0.05]
    floor = range_image(down * (1.5 / -down[:, 2])[:, None], GRID)
    v, u = np.nonzero(floor.shown >= 0)
    centre = -GRID.directions(np.stack([u + 0.5, v + 0.5], axis=1))[:, 2]
    # Within the row's height and what it is filled from: 1.5 rows of 1/3 degree.
    low, high = 1.5 / np.sin(np.arcsin(centre) + np.deg2rad(0.5)), 1.5 / np.sin(np.arcsin(centre) - np.deg2rad(0.5))
    assert ((floor.range[v, u] > low) & (floor.range[v, u] < high)).all()
    assert (floor.range[:20] == 0.0).all(), "above the horizon there is no floor"


def test_a_turn_of_whole_columns_turns_the_image() -> None:
    rng = np.random.default_rng(3)
    points = directions(rng.uniform(-0.4, 0.1, 5000), rng.uniform(-np.pi, np.pi, 5000)) * rng.uniform(2, 9, (5000, 1))
    yaw = -40 * 2 * np.pi / 256
    turn = np.array([[np.cos(yaw), -np.sin(yaw), 0], [np.sin(yaw), np.cos(yaw), 0], [0, 0, 1]])
    before, after = range_image(points, GRID).shown, range_image(points @ turn.T, GRID).shown
    # Rounding may move what lies on a border of columns.
    assert (np.roll(before, 40, axis=1) == after).mean() > 0.999


def test_an_empty_sweep_is_an_empty_image() -> None:
    seen = range_image(np.zeros((0, 3)), GRID)
    assert (seen.shown == -1).all()
    assert (seen.range == 0.0).all()
    assert np.isnan(seen.of_points(np.zeros(0), np.nan)).all()


def test_sizes_are_checked() -> None:
    with pytest.raises(ConfigError, match="multiples of 32"):
        RangeImageConfig(columns=1000)
    with pytest.raises(ConfigError, match="must rise"):
        RangeImageConfig(elevation_deg=(5.0, -5.0))
