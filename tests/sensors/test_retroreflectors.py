"""Retroreflecting bands before cameras that light what they see."""

from dataclasses import replace

import numpy as np
import pytest

from tests.sensors.targets import capture_of, plane, with_constants
from warehouse_sim.schema.things import RETROREFLECTIVE
from warehouse_sim.sensors.rgbd.depth import PRESETS
from warehouse_sim.sensors.rgbd.depth.model import DepthModel
from warehouse_sim.sensors.surfaces import returned_by_retroreflectors
from warehouse_sim.sensors.view import Capture

BAND = slice(100, 130)
"""Columns of the band; it is as wide as one of 50 mm at 1 m."""
BESIDE = np.r_[0:60, 170:320]
"""Columns far enough from the band that nothing of it reaches them."""


def banded(roughness: float = 0.8) -> Capture:
    capture = capture_of(remission=0.6, roughness=roughness)
    assert capture.surfaces is not None
    remission = capture.surfaces.remission.copy()
    remission[:, BAND] = RETROREFLECTIVE
    return replace(capture, surfaces=replace(capture.surfaces, remission=remission))


def read(model: DepthModel, capture: Capture, z: float = 1.5) -> np.ndarray:
    return model.read(plane(z), capture, np.random.default_rng(3))


def test_light_comes_back_as_the_standard_asks_and_less_beside_the_lamp() -> None:
    """330 cd/(lx m^2) at 12 minutes of arc (EN ISO 20471), over the 1 / pi of white plaster."""
    remission, one = np.full((1, 1), 2.0, np.float32), np.ones((1, 1), np.float32)
    z = 5.0
    at = returned_by_retroreflectors(remission, one, z * one, z * np.tan(np.deg2rad(0.2)))
    assert at is not None
    assert float(at[0, 0]) == pytest.approx(330 * np.pi, rel=1e-4)
    falling = [returned_by_retroreflectors(remission, one, z * one, offset) for offset in (0.0, 0.03, 0.1, 0.5)]
    assert all(np.diff([float(item[0, 0]) for item in falling if item is not None]) < 0)
    assert returned_by_retroreflectors(0.95 * one, one, one, 0.01) is None


@pytest.mark.parametrize("name", ["flexx2", "azure_kinect", "kinect_v1", "d435", "d455"])
def test_a_band_is_a_hole_and_what_lies_beside_it_is_read_as_before(name: str) -> None:
    model = PRESETS[name]
    plain, own = read(model, capture_of(remission=0.6, roughness=0.8)), read(model, banded())
    assert (plain[:, 105:125] > 0).mean() > 0.9
    assert (own[:, 105:125] > 0).mean() < 0.05
    # One step of disparity, where rounding falls the other way.
    np.testing.assert_allclose(own[:, BESIDE], plain[:, BESIDE], atol=5e-3)
    assert (np.abs(own - plain)[:, BESIDE] < 1e-3).mean() > 0.99


def test_a_flooded_pixel_of_a_time_of_flight_camera_reaches_beyond_the_band() -> None:
    own = read(PRESETS["flexx2"], banded())
    rim = (own[:, BAND.stop : BAND.stop + 1] == 0).mean()
    assert rim > 0.9
    assert (own[:, BAND.stop + 12 :] > 0).mean() > 0.99


def test_a_band_that_is_too_far_to_flood_a_pixel_is_read() -> None:
    model = with_constants(replace(PRESETS["flexx2"], max_range=7.0), max_signal=1e5)
    assert (read(model, banded())[:, 105:125] > 0).all()


def test_stray_light_of_a_near_band_draws_the_rest_of_the_image_nearer() -> None:
    """A band at half the distance: what its light adds to every pixel has a smaller phase."""
    model = replace(PRESETS["tof_industrial"], noise_scale=0.0, multipath=0.0)
    far = plane(3.0)
    depth = far.depth.copy()
    depth[:, BAND] = 1.5
    buffers = replace(far, depth=depth)
    bright, dull = banded(), capture_of(remission=0.6, roughness=0.8)
    near, before = (model.read(buffers, item, np.random.default_rng(1))[:, 200:] for item in (bright, dull))
    both = (near > 0) & (before > 0)
    assert both.mean() > 0.9
    assert np.median((near - before)[both]) < -0.02
