"""The preset against what was measured of recordings, and its mechanisms against closed forms."""

from dataclasses import replace

import numpy as np
import pytest

from tests.sensors.targets import CAMERA, capture_of, plane, step
from warehouse_sim.schema import RenderBuffers
from warehouse_sim.sensors.rgbd.depth import PRESETS
from warehouse_sim.sensors.rgbd.depth.time_of_flight import TimeOfFlight
from warehouse_sim.sensors.surfaces import Reflected
from warehouse_sim.sensors.view import Capture

PRESET = PRESETS["tof_industrial"]
assert isinstance(PRESET, TimeOfFlight)
STILL = replace(
    PRESET, noise_scale=0.0, multipath=0.0, fixed_pattern=0.0, unit_offset=0.0, unit_scale=0.0, wiggle=0.0,
    stray_light=0.0, gloss_bias=0.0, sigma_lateral_px=0.0, focal_px=585.5,
)  # fmt: skip
PLAIN = np.zeros((CAMERA.height, CAMERA.width), np.float32)


def over(capture: Capture, light: float = 0.0, ranges: float = 0.0, kept: float = 1.0) -> Capture:
    """Return ``capture`` with the same light by way of a smooth surface in all pixels."""
    assert capture.surfaces is not None
    reflected = Reflected(PLAIN + np.float32(light), PLAIN + np.float32(ranges), PLAIN + np.float32(kept))
    return replace(capture, surfaces=replace(capture.surfaces, reflected=reflected))


def read(buffers: RenderBuffers, model: TimeOfFlight, capture: Capture, seed: int = 0) -> np.ndarray:
    return model.read(buffers, capture, np.random.default_rng(seed))


@pytest.mark.parametrize(("z", "low", "high"), [(0.5, 4, 10), (1.0, 9, 22), (1.5, 12, 19), (2.0, 21, 26)])
def test_it_spreads_over_time_as_recordings_do_and_its_neighbours_are_alike(z: float, low: float, high: float) -> None:
    capture = over(capture_of(remission=0.3))
    model = replace(PRESET, focal_px=585.5)
    change = read(plane(z), model, capture, 1) - read(plane(z), model, capture, 2)
    assert low <= 1000 * change.std() / np.sqrt(2) <= high
    for lag, alike in ((1, 0.8), (2, 0.5), (3, 0.25)):
        found = (change[:, lag:] * change[:, :-lag]).mean() / change.var()
        assert found == pytest.approx(alike, abs=0.06)


def test_a_mirror_in_the_floor_adds_its_phase() -> None:
    turn = 2 * np.pi / STILL.unambiguous_range
    middle = (CAMERA.height // 2, CAMERA.width // 2)
    for light in (0.05, 0.3, 3.0):
        found = read(plane(1.0), STILL, over(capture_of(remission=0.3), light, 2.0))[middle]
        direct = 0.3 + 0.25 * 0.04  # of roughness 1 the gloss is a quarter of F0
        expected = np.angle(direct * np.exp(1j * turn) + light * np.exp(2j * turn)) / turn
        assert found == pytest.approx(expected, abs=2e-3)
    # Nothing but the mirror's light comes back: the mirrored scene is read.
    assert read(plane(1.0), STILL, over(capture_of(remission=0.3), 2.0, 2.0, kept=0.0))[middle] > 1.95


def test_stray_light_pulls_weak_pixels_to_the_near_and_bright() -> None:
    buffers = step(0.4, 2.0, slice(0, 160))
    bent = read(buffers, replace(STILL, stray_light=0.01), over(capture_of(remission=0.3))) - buffers.depth
    assert -0.2 < np.median(bent[:, 170:]) < -0.05
    assert abs(np.median(bent[:, :150])) < 0.005


def test_gloss_seems_farther_head_on_than_aslant() -> None:
    glossy = over(capture_of(remission=0.45, roughness=0.4))
    model = replace(STILL, gloss_bias=0.1)
    straight, aslant = (read(plane(1.4, lean), model, glossy)[120, 160] - 1.4 for lean in (0.0, 25.0))
    lobe = 0.25 * 0.04 / 0.4**4
    assert straight == pytest.approx(0.1 * lobe / (lobe + 0.45), abs=2e-3)
    assert aslant < straight / 5


def test_nothing_sends_no_light_where_the_coarser_materials_reach_over_an_outline() -> None:
    buffers = plane(1.4)
    model = replace(STILL, stray_light=0.01, sigma_lateral_px=1.3)
    whole = read(buffers, model, over(capture_of()))
    buffers.depth[:, 160:] = 0.0  # the materials still say plaster there
    half = read(buffers, model, over(capture_of()))
    np.testing.assert_allclose(half[:, :150], whole[:, :150], atol=2e-3)
    assert np.abs(half[:, 150:160] - 1.4).max() < 0.01
    assert (half[:, 160:] == 0).all()
