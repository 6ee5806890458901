"""Film before a wall, read by each kind of depth camera: closed forms, and what must not change."""

from dataclasses import replace

import numpy as np
import pytest

from tests.sensors.targets import CAMERA, capture_of, plane, with_constants
from warehouse_sim.sensors.film import FilmImage
from warehouse_sim.sensors.rgbd.depth import PRESETS, DepthModel
from warehouse_sim.sensors.rgbd.depth.time_of_flight import TimeOfFlight
from warehouse_sim.sensors.view import Capture

WALL = plane(1.5)


def filmed(
    depth: float, passed: float = 0.85, diffuse: float = 0.0, glossy: float = 0.0, remission: float = 0.5
) -> Capture:
    shape = (CAMERA.height // 2, CAMERA.width // 2)
    images = (np.full(shape, value, np.float32) for value in (depth, passed, 0.98, diffuse, glossy))
    return replace(capture_of(remission=remission), film=FilmImage(*images))


def read(model: DepthModel, capture: Capture, seed: int = 5) -> np.ndarray:
    return model.read(WALL, capture, np.random.default_rng(seed))


def middle(image: np.ndarray) -> np.ndarray:
    return image[60:180, 100:220]


@pytest.mark.parametrize("name", list(PRESETS))
def test_every_preset_sees_film_and_can_leave_it_out(name: str) -> None:
    model = PRESETS[name]
    assert model.sees_film
    blind = replace(model, film=False)  # type: ignore[call-arg]
    assert not blind.sees_film
    bare = replace(filmed(1.2), film=None)
    np.testing.assert_array_equal(read(blind, filmed(1.2, glossy=30.0)), read(model, bare))
    assert not np.array_equal(read(model, filmed(1.2, glossy=30.0)), read(model, bare))


def test_a_time_of_flight_camera_adds_the_phases_of_film_and_wall() -> None:
    still = TimeOfFlight(noise_scale=0.0, multipath=0.0, sigma_lateral_px=0.0)
    capture = filmed(1.2, passed=0.8, diffuse=0.05, glossy=0.4, remission=0.5)
    u, v = 200, 90
    away = 1.0 / np.linalg.norm(CAMERA.rays()[v, u])
    turn = 2 * np.pi / 7.5
    gloss = 0.25 * 0.04  # of the wall, at a roughness of 1
    wall = (0.5 * away + gloss) * 0.8**2 / 1.5**2
    film = 0.45 / 1.2**2
    total = wall * np.exp(1j * turn * 1.5 / away) + film * np.exp(1j * turn * 1.2 / away)
    expected = (np.angle(total) % (2 * np.pi)) / turn * away
    assert 1.2 < expected < 1.45
    assert read(still, capture)[v, u] == pytest.approx(expected, abs=2e-4)


def test_glare_of_film_is_a_hole() -> None:
    for name in ("flexx2", "azure_kinect", "tof_industrial", "kinect_v1", "d455"):
        assert (middle(read(PRESETS[name], filmed(1.49, glossy=40.0))) == 0).all(), name
        assert (middle(read(PRESETS[name], filmed(1.49))) > 0).mean() > 0.95, name


def test_a_triangulating_camera_locks_on_film_that_is_brighter_than_the_wall() -> None:
    for name in ("d455", "kinect_v1"):
        behind, before = (read(PRESETS[name], filmed(1.2, glossy=value)) for value in (0.02, 1.2))
        assert np.median(middle(behind)) == pytest.approx(1.5, abs=0.02), name
        assert np.median(middle(before)) == pytest.approx(1.2, abs=0.02), name


def test_what_lies_behind_many_layers_is_noisier_or_not_read() -> None:
    for name in ("flexx2", "tof_industrial"):
        bare, dim = (middle(read(PRESETS[name], filmed(1.495, passed=value))) for value in (1.0, 0.6))
        assert dim[dim > 0].std() > 1.2 * bare[bare > 0].std(), name
    dots = with_constants(PRESETS["d455"], projector_lux=150.0)
    bare, dim = (middle(read(dots, filmed(1.495, passed=value))) for value in (1.0, 0.6))
    assert dim[dim > 0].std() > 1.2 * bare[bare > 0].std()
    weak = with_constants(PRESETS["d455"], projector_lux=80.0)
    fill = [(middle(read(weak, filmed(1.495, passed=value, remission=0.3))) > 0).mean() for value in (1.0, 0.6)]
    assert fill[1] < 0.5 < 0.9 < fill[0]


@pytest.mark.parametrize("name", list(PRESETS))
def test_pixels_without_film_read_as_if_there_were_none_in_the_image(name: str) -> None:
    """Film to the left of the middle alone, and none of it near the right border."""
    capture = filmed(1.2, glossy=0.5)
    assert capture.film is not None
    absent = {"depth": np.inf, "passed": 1.0, "clear": 1.0, "diffuse": 0.0, "glossy": 0.0}
    half = {name: getattr(capture.film, name).copy() for name in absent}
    for channel, value in absent.items():
        half[channel][:, 60:] = value
    film, bare = (
        read(replace(PRESETS[name], stray_light=0.0) if name == "tof_industrial" else PRESETS[name], item)  # type: ignore[call-arg]
        for item in (replace(capture, film=FilmImage(**half)), replace(capture, film=None))
    )
    assert not np.array_equal(film[:, :100], bare[:, :100])
    # A stereo camera has one exposure for the image, so that few readings are a step of disparity beside.
    same = np.abs(film[:, 180:] - bare[:, 180:]) < 1e-5
    assert same.mean() > (0.99 if name.startswith("d4") else 0.99999)
