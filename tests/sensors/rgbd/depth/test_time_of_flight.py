"""Against Cai et al. 2024 (arXiv 2412.15040), the Azure Kinect's data sheet and the sum of phases."""

from dataclasses import replace

import numpy as np
import pytest

from tests.sensors.targets import CAMERA, capture_of, corner, plane, step, with_constants
from warehouse_sim.schema import RenderBuffers
from warehouse_sim.sensors.rgbd.depth import PRESETS
from warehouse_sim.sensors.rgbd.depth.multipath import multipath_bias
from warehouse_sim.sensors.rgbd.depth.time_of_flight import TimeOfFlight
from warehouse_sim.sensors.view import Capture

FLEXX2 = TimeOfFlight(multipath=0.0)
STILL = TimeOfFlight(noise_scale=0.0, multipath=0.0, sigma_lateral_px=0.4)
CAPTURE = capture_of()
SPOT = 0.4 * 585.5 / 210.6
"""Standard deviation of a pixel's spot in ``STILL`` (px)."""


def read(buffers: RenderBuffers, model: TimeOfFlight = FLEXX2, capture: Capture = CAPTURE) -> np.ndarray:
    return model.read(buffers, capture, np.random.default_rng(11))


@pytest.mark.parametrize("z", [0.5, 1.0, 1.5, 2.2])
@pytest.mark.parametrize("lean", [0.0, 30.0, 60.0])
def test_the_spread_on_white_is_the_published_one(z: float, lean: float) -> None:
    theta = np.deg2rad(lean)
    angle = theta**2 / (np.pi / 2 - theta) ** 2
    published = 0.002362 - 0.001041 * z + 0.000753 * z**2 + 0.000185 * z**2.7 * angle
    buffers = plane(z, lean)
    error = (read(buffers) - buffers.depth)[:, 148:172]
    assert error.std() == pytest.approx(published, rel=0.12)


@pytest.mark.parametrize(("z", "published_mm"), [(0.8, 0.613), (1.5, 0.887), (3.0, 1.782)])
def test_the_azure_kinect_is_as_precise_as_published(z: float, published_mm: float) -> None:
    model = replace(PRESETS["azure_kinect"], multipath=0.0, wiggle=0.0)
    assert isinstance(model, TimeOfFlight)
    error = read(plane(z), model) - z
    assert 1000 * error.std() == pytest.approx(published_mm, rel=0.12)
    assert abs(error.mean()) < 0.0005


def test_dark_surfaces_are_noisier_by_the_root_of_their_reflectance() -> None:
    grey = read(plane(1.0), capture=capture_of(remission=0.25)).std()
    assert grey / read(plane(1.0)).std() == pytest.approx(2.0, rel=0.05)


def test_pixels_fly_between_the_sides_of_an_edge() -> None:
    depth = read(step(1.0, 1.6, slice(0, 160)), STILL)[120]
    assert depth[150] == pytest.approx(1.0, abs=1e-3)
    assert depth[170] == pytest.approx(1.6, abs=1e-3)
    flying = depth[157:163]
    assert (np.diff(flying) > 0).all()
    assert ((flying > 1.02) & (flying < 1.58)).sum() >= 2
    # Column 159 lies half a pixel left of the edge; light falls off with the square of distance.
    turn = 2 * np.pi / 7.5
    columns = np.arange(320)
    weight = np.exp(-0.5 * ((columns - 159) / SPOT) ** 2)
    z = np.where(columns < 160, 1.0, 1.6)
    mixed = np.angle((weight / z**2 * np.exp(1j * turn * z)).sum()) / turn
    assert depth[159] == pytest.approx(mixed, abs=0.01)


def test_phases_that_cancel_each_other_are_no_reading() -> None:
    opposite = with_constants(replace(STILL, max_range=4.0, min_coherence=0.6), unambiguous_range=2.4)
    depth = read(step(1.0, 2.2, slice(0, 160)), opposite)[120]
    assert (depth[[158, 159, 160, 161, 162]] == 0).any()
    assert (depth[:150] > 0).all()
    assert (depth[170:] > 0).all()


def test_concave_corners_seem_deeper_and_nothing_else_does() -> None:
    model = replace(STILL, multipath=1.0, sigma_lateral_px=0.0)
    inner, outer, flat = corner(1.5, concave=True), corner(1.5, concave=False), plane(1.5)
    bias = (read(inner, model) - inner.depth)[120]
    assert 0.001 < bias[120] < 0.05
    assert 0.001 < bias[200] < 0.05
    assert bias.min() >= -1e-6
    half = read(inner, model, capture_of(remission=0.5))[120] - inner.depth[120]
    assert half[120] == pytest.approx(bias[120] / 2, rel=0.15)
    assert np.abs(read(outer, model) - outer.depth).max() < 1e-4
    assert np.abs(read(flat, model) - flat.depth).max() < 1e-4


def test_light_over_other_surfaces_is_that_of_all_patches() -> None:
    """Against the sum over every second pixel, without rings that stand for their surroundings."""
    buffers = corner(1.5, concave=True)
    assert buffers.normals is not None
    bias = multipath_bias(buffers.depth, buffers.normals, np.full_like(buffers.depth, 0.6), CAMERA)
    rays = CAMERA.rays()[::2, ::2].reshape(-1, 3)
    points = rays * buffers.depth[::2, ::2].reshape(-1, 1)
    normals = buffers.normals[::2, ::2].reshape(-1, 3).astype(float)
    r = np.linalg.norm(points, axis=1)
    cosine = -(points * normals).sum(axis=1) / r
    area = 4 / (CAMERA.fx * CAMERA.fy) * points[:, 2] ** 2 * r / points[:, 2] / cosine
    for column in (60, 100, 130, 190, 250):
        at = 60 * 160 + column // 2
        way = points - points[at]
        length = np.maximum(np.linalg.norm(way, axis=1), 1e-9)
        leaving = np.maximum(-(way * normals).sum(axis=1), 0) / length
        arriving = np.maximum(way @ normals[at], 0) / length
        power = 0.6 * cosine / r**2 * leaving * arriving / (np.pi * length**2) * area
        power[at] = 0
        longer = (r + length - r[at]) / 2
        expected = (power * longer).sum() / (power.sum() + cosine[at] / r[at] ** 2)
        assert bias[120, column] == pytest.approx(expected, rel=0.35, abs=0.0015)
