"""Against Cai et al. 2024 (arXiv 2412.15040), the Azure Kinect's data sheet and the sum of phases."""

from dataclasses import replace

import numpy as np
import pytest

from tests.sensors.targets import CAMERA, capture_of, corner, plane, step, with_constants
from warehouse_sim.schema import RenderBuffers
from warehouse_sim.sensors.rgbd.depth import PRESETS
from warehouse_sim.sensors.rgbd.depth.multipath import multipath_bias
from warehouse_sim.sensors.rgbd.depth.time_of_flight import TimeOfFlight
from warehouse_sim.sensors.surfaces import Reflected
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


# The preset against what was measured of recordings, and its mechanisms against closed forms.


PRESET = PRESETS["tof_industrial"]
assert isinstance(PRESET, TimeOfFlight)
INDUSTRIAL = replace(
    PRESET, noise_scale=0.0, multipath=0.0, fixed_pattern=0.0, unit_offset=0.0, unit_scale=0.0, wiggle=0.0,
    stray_light=0.0, gloss_bias=0.0, sigma_lateral_px=0.0, focal_px=585.5,
)  # fmt: skip
PLAIN = np.zeros((CAMERA.height, CAMERA.width), np.float32)


def over(capture: Capture, light: float = 0.0, ranges: float = 0.0, kept: float = 1.0) -> Capture:
    """Return ``capture`` with the same light by way of a smooth surface in all pixels."""
    assert capture.surfaces is not None
    reflected = Reflected(PLAIN + np.float32(light), PLAIN + np.float32(ranges), PLAIN + np.float32(kept))
    return replace(capture, surfaces=replace(capture.surfaces, reflected=reflected))


def read_of(buffers: RenderBuffers, model: TimeOfFlight, capture: Capture, seed: int = 0) -> np.ndarray:
    return model.read(buffers, capture, np.random.default_rng(seed))


@pytest.mark.parametrize(("z", "low", "high"), [(0.5, 4, 10), (1.0, 9, 22), (1.5, 12, 19), (2.0, 21, 26)])
def test_it_spreads_over_time_as_recordings_do_and_its_neighbours_are_alike(z: float, low: float, high: float) -> None:
    capture = over(capture_of(remission=0.3))
    model = replace(PRESET, focal_px=585.5)
    change = read_of(plane(z), model, capture, 1) - read_of(plane(z), model, capture, 2)
    assert low <= 1000 * change.std() / np.sqrt(2) <= high
    for lag, alike in ((1, 0.8), (2, 0.5), (3, 0.25)):
        found = (change[:, lag:] * change[:, :-lag]).mean() / change.var()
        assert found == pytest.approx(alike, abs=0.06)


def test_a_mirror_in_the_floor_adds_its_phase() -> None:
    turn = 2 * np.pi / INDUSTRIAL.unambiguous_range
    middle = (CAMERA.height // 2, CAMERA.width // 2)
    for light in (0.05, 0.3, 3.0):
        found = read_of(plane(1.0), INDUSTRIAL, over(capture_of(remission=0.3), light, 2.0))[middle]
        direct = 0.3 + 0.25 * 0.04  # of roughness 1 the gloss is a quarter of F0
        expected = np.angle(direct * np.exp(1j * turn) + light * np.exp(2j * turn)) / turn
        assert found == pytest.approx(expected, abs=2e-3)
    # Nothing but the mirror's light comes back: the mirrored scene is read.
    assert read_of(plane(1.0), INDUSTRIAL, over(capture_of(remission=0.3), 2.0, 2.0, kept=0.0))[middle] > 1.95


def test_stray_light_pulls_weak_pixels_to_the_near_and_bright() -> None:
    buffers = step(0.4, 2.0, slice(0, 160))
    bent = read_of(buffers, replace(INDUSTRIAL, stray_light=0.01), over(capture_of(remission=0.3))) - buffers.depth
    assert -0.2 < np.median(bent[:, 170:]) < -0.05
    assert abs(np.median(bent[:, :150])) < 0.005


def test_gloss_seems_farther_head_on_than_aslant() -> None:
    glossy = over(capture_of(remission=0.45, roughness=0.4))
    model = replace(INDUSTRIAL, gloss_bias=0.1)
    straight, aslant = (read_of(plane(1.4, lean), model, glossy)[120, 160] - 1.4 for lean in (0.0, 25.0))
    lobe = 0.25 * 0.04 / 0.4**4
    assert straight == pytest.approx(0.1 * lobe / (lobe + 0.45), abs=2e-3)
    assert aslant < straight / 5


def test_nothing_sends_no_light_where_the_coarser_materials_reach_over_an_outline() -> None:
    buffers = plane(1.4)
    model = replace(INDUSTRIAL, stray_light=0.01, sigma_lateral_px=1.3)
    whole = read_of(buffers, model, over(capture_of()))
    buffers.depth[:, 160:] = 0.0  # the materials still say plaster there
    half = read_of(buffers, model, over(capture_of()))
    np.testing.assert_allclose(half[:, :150], whole[:, :150], atol=2e-3)
    assert np.abs(half[:, 150:160] - 1.4).max() < 0.01
    assert (half[:, 160:] == 0).all()
