"""Against the law of triangulation, the published figures of the D435 and geometry in closed form."""

from dataclasses import replace

import numpy as np
import pytest

from tests.sensors.targets import capture_of, plane, step
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.schema import RenderBuffers
from warehouse_sim.sensors.capture import Capture
from warehouse_sim.sensors.rgbd.depth import PRESETS
from warehouse_sim.sensors.rgbd.depth.active_stereo import ActiveStereo

CAMERA = PinholeCamera.from_focal(848, 240, 424.0)
CAPTURE = capture_of(CAMERA)
D435 = ActiveStereo()


def read(buffers: RenderBuffers, model: ActiveStereo = D435, capture: Capture = CAPTURE) -> np.ndarray:
    return model.read(buffers, capture, np.random.default_rng(7))


@pytest.mark.parametrize("z", [0.6, 1.0, 2.0, 4.0])
@pytest.mark.parametrize(("name", "focal", "baseline"), [("d435", 424.0, 0.05), ("d455", 447.0, 0.095)])
def test_the_spread_is_z_squared_over_f_b(z: float, name: str, focal: float, baseline: float) -> None:
    model = PRESETS[name]
    assert isinstance(model, ActiveStereo)
    depth = read(plane(z, camera=CAMERA), model)
    error = depth[depth > 0] - z
    assert error.std() == pytest.approx(z * z * 0.08 / (focal * baseline), rel=0.08)


def test_a_d435_has_the_measured_spread_at_two_metres() -> None:
    """0.75 % at 2 m: Rustler et al. 2025, arXiv 2501.07421; Intel specifies at most 2 %."""
    depth = read(plane(2.0, camera=CAMERA))
    assert (depth[depth > 0]).std() / 2.0 == pytest.approx(0.0075, rel=0.08)


def test_errors_are_shared_within_the_matching_window() -> None:
    noise = read(plane(2.0, camera=CAMERA))[:, 100:]
    error = (noise - 2.0) / noise.std()
    for shift, expected in ((1, 6 / 7), (3, 4 / 7), (7, 0.0), (10, 0.0)):
        assert np.mean(error[:, shift:] * error[:, :-shift]) == pytest.approx(expected, abs=0.06)


def test_depth_comes_in_32nds_of_a_pixel_of_disparity() -> None:
    found = np.unique(read(plane(4.0, camera=CAMERA)))
    steps = 424.0 * 0.05 * 32 / found[found > 0]
    np.testing.assert_allclose(steps, np.rint(steps), atol=2e-3)


@pytest.mark.parametrize(("near", "far"), [(1.0, 2.0), (0.8, 4.0), (1.5, 1.8)])
def test_the_shadow_of_the_baseline_is_as_wide_as_triangulation_says(near: float, far: float) -> None:
    model = replace(D435, baseline=0.2)
    depth = read(step(near, far, slice(500, 600), CAMERA), model)
    border, edge = 424.0 * 0.2 / far, 424.0 * 0.2 * (1 / near - 1 / far)
    lost = depth == 0
    for row in (0, 120, 239):
        assert lost[row, :200].sum() == pytest.approx(border, abs=1.0)
        assert lost[row, 300:500].sum() == pytest.approx(edge, abs=1.5)
        assert lost[row, 500 - int(edge) + 2 : 500].all()
        assert not lost[row, 500:].any()


@pytest.mark.parametrize(("lean", "read_share"), [(60.0, (0.99, 1.0)), (78.46, (0.3, 0.7)), (86.0, (0.0, 0.02))])
def test_grazing_surfaces_drop_out_about_a_cosine_of_a_fifth(lean: float, read_share: tuple[float, float]) -> None:
    depth = read(plane(2.0, lean, CAMERA))[:, 414:434]
    assert read_share[0] <= (depth > 0).mean() <= read_share[1]


def test_dark_surfaces_drop_out_where_too_little_light_returns() -> None:
    black = capture_of(CAMERA, remission=0.02)
    right = np.s_[:, 300:]
    assert (read(plane(1.5, camera=CAMERA), capture=black)[right] > 0).mean() > 0.95
    assert (read(plane(6.0, camera=CAMERA), capture=black)[right] == 0).mean() > 0.9
    assert (read(plane(6.0, camera=CAMERA))[right] > 0).all()


def test_polished_metal_is_lost_both_in_its_glare_and_beside_it() -> None:
    chrome = capture_of(CAMERA, remission=1.2, roughness=0.2, metallic=1.0)
    facing = read(plane(2.0, camera=CAMERA), capture=chrome)[118:123, 420:428]
    turned = read(plane(2.0, 45.0, CAMERA), capture=chrome)[:, 420:428]
    matt = read(plane(2.0, 45.0, CAMERA))[:, 420:428]
    assert (facing == 0).all()
    assert (turned == 0).mean() > 0.9
    assert (matt > 0).all()


def test_nothing_is_nearer_than_the_search_reaches() -> None:
    limit = 424.0 * 0.05 / 126.0
    assert (read(plane(limit * 0.97, camera=CAMERA)) == 0).all()
    assert (read(plane(limit * 1.03, camera=CAMERA))[:, 300:] > 0).mean() > 0.9
