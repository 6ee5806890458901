"""Against the law of triangulation, published figures of the D435, matched images as stored, and closed forms."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from tests.sensors.targets import capture_of, corner, plane, step, with_constants
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.schema import RenderBuffers
from warehouse_sim.sensors.rgbd.depth.active_stereo import ActiveStereo
from warehouse_sim.sensors.rgbd.depth.structured_light import StructuredLight
from warehouse_sim.sensors.view import Capture

CAMERA = PinholeCamera.from_focal(848, 240, 424.0)
CAPTURE = capture_of(CAMERA)
SAME_UNIT = {"unit_scale": 0.0, "unit_bow_px": 0.0, "unit_registration_px": 0.0}
D435 = with_constants(ActiveStereo(color_offset=0.0), **SAME_UNIT)
RIGHT = np.s_[:, 200:]
"""What is left of it has no partner in the other image at 0.6 m and more."""


def read(buffers: RenderBuffers, model: ActiveStereo = D435, capture: Capture = CAPTURE) -> np.ndarray:
    return model.read(buffers, capture, np.random.default_rng(7))


def spread(buffers: RenderBuffers, model: ActiveStereo = D435, capture: Capture = CAPTURE) -> float:
    depth = read(buffers, model, capture)[RIGHT]
    return float((depth - buffers.depth[RIGHT])[depth > 0].std())


@pytest.mark.parametrize("z", [0.6, 1.0, 2.0, 4.0])
def test_a_d435_spreads_as_was_measured(z: float) -> None:
    """Ahn et al. 2019: sigma = 1.063 mm + 0.7278 mm z + 3.949 mm z^2; at 0.6 m it holds an offset that grows less."""
    published = 0.001063 + 0.0007278 * z + 0.003949 * z * z
    found = spread(plane(z, camera=CAMERA))
    if z >= 2.0:
        assert found == pytest.approx(published, rel=0.25)
    assert z * z * 0.064 / (424 * 0.05) < found < published * 1.25


def test_a_d435_has_the_measured_spread_at_two_metres() -> None:
    """0.75 % at 2 m: Rustler et al. 2025, arXiv 2501.07421; Intel specifies at most 2 %."""
    assert spread(plane(2.0, camera=CAMERA)) / 2.0 == pytest.approx(0.0075, rel=0.1)


def test_errors_grow_with_incidence() -> None:
    """As in drawn and matched images: 0.086, 0.112, 0.155 px at 0, 60, 75 degrees, 2 m."""
    model, middle = with_constants(D435, disparity_step=0.001), np.s_[:, 410:438]
    found = []
    for lean in (0.0, 60.0, 75.0):
        buffers = plane(2.0, lean, CAMERA)
        depth = read(buffers, model)[middle]
        true = buffers.depth[middle]
        assert (depth > 0).mean() > 0.95
        found.append(float((21.2 / depth[depth > 0] - 21.2 / true[depth > 0]).std()))
    np.testing.assert_allclose(found, (0.086, 0.112, 0.155), rtol=0.3)
    assert found[0] < found[1] < found[2]


def test_a_wall_too_far_for_the_projector_is_lost_unless_it_has_texture() -> None:
    """In 300 lx a white wall at 8 m is read to about a half when matched, a textured one to all."""
    rng = np.random.default_rng(0)
    wall = plane(8.0, camera=CAMERA, code=205)
    codes = rng.normal(205, 10, (240, 848, 1)).clip(0, 255).astype(np.uint8).repeat(3, axis=2)
    plain, textured = (read(replace(wall, rgb=rgb))[RIGHT] > 0 for rgb in (wall.rgb, codes))
    assert 0.2 < plain.mean() < 0.8
    assert textured.mean() > 0.99


def test_errors_are_shared_within_the_matching_window_and_beyond() -> None:
    """Matched images: 0.88, 0.64, 0.18 at 1, 3, 7 px; a median filter leaves most of it."""
    depth = read(plane(4.0, camera=CAMERA))[RIGHT]
    error = (depth - 4.0) / depth.std()
    for shift, expected in ((1, 0.88), (3, 0.64), (7, 0.18)):
        assert np.mean(error[:, shift:] * error[:, :-shift]) == pytest.approx(expected, abs=0.1)
    assert cv2.medianBlur(error, 5).std() > 0.8


def test_depth_comes_in_32nds_of_a_pixel_of_disparity() -> None:
    found = np.unique(read(plane(4.0, camera=CAMERA)))
    steps = 424.0 * 0.05 * 32 / found[found > 0]
    np.testing.assert_allclose(steps, np.rint(steps), atol=2e-3)


@pytest.mark.parametrize(("near", "far"), [(1.0, 2.0), (0.8, 4.0), (1.5, 1.8)])
def test_the_shadow_of_the_baseline_is_as_wide_as_triangulation_says(near: float, far: float) -> None:
    model = with_constants(replace(D435, baseline=0.2), edge_px=0.0, shadow_px=0.0)
    depth = read(step(near, far, slice(500, 600), CAMERA), model)
    border, edge = 424.0 * 0.2 / far, 424.0 * 0.2 * (1 / near - 1 / far)
    lost = depth == 0
    for row in (0, 120, 239):
        assert lost[row, :200].sum() == pytest.approx(border, abs=1.0)
        assert lost[row, 300:500].sum() == pytest.approx(edge, abs=1.5)
        assert lost[row, 500 - int(edge) + 2 : 500].all()
        assert not lost[row, 500:].any()


def test_near_things_grow_on_both_sides() -> None:
    """By 2-3 px where images were matched; what grows into the shadow is no hole."""
    for model in (D435, replace(D435, color_offset=0.059)):
        found = read(step(1.0, 2.5, slice(500, 600), CAMERA), model)
        near = np.abs(found - 1.0) < 0.1
        assert 1.5 < near[:, 480:500].sum(axis=1).mean() < 3.5
        assert 1.5 < near[:, 600:620].sum(axis=1).mean() < 3.5


def test_a_colour_camera_between_the_imagers_has_shadows_on_both_sides() -> None:
    model = with_constants(replace(D435, baseline=0.095, color_offset=0.059), edge_px=0.0, shadow_px=0.0)
    lost = read(step(1.0, 2.0, slice(400, 500), CAMERA), model) == 0
    assert lost[:, 300:400].sum(axis=1).mean() == pytest.approx(424 * 0.036 / 2, abs=1.5)
    assert lost[:, 500:600].sum(axis=1).mean() == pytest.approx(424 * 0.059 / 2, abs=1.5)


def test_a_unit_errs_alike_in_all_images_and_unlike_others() -> None:
    wall = plane(2.0, camera=CAMERA)
    none = {"blurred_px": 0.0, "slope_px": 0.0, "disparity_step": 0.0001, "min_clarity": 0.0}
    quiet = with_constants(ActiveStereo(subpixel_px=0.0), **none)
    means = []
    for number in range(40):
        model = replace(quiet, unit=number)
        one, other = (model.read(wall, CAPTURE, np.random.default_rng(seed))[RIGHT] for seed in (0, 1))
        np.testing.assert_allclose(one, other, atol=0.012)
        means.append(float(one[one > 0].mean()) / 2.0 - 1.0)
    assert 0.002 < np.std(means) < 0.008
    assert max(np.abs(means)) < 0.02  # the data sheet's bound at 2 m
    assert (replace(quiet, unit=1, noise_scale=0.0).read(wall, CAPTURE, np.random.default_rng(0))[RIGHT] > 0).all()


@pytest.mark.parametrize(("lean", "read_fraction"), [(60.0, (0.99, 1.0)), (84.0, (0.3, 0.8)), (88.5, (0.0, 0.1))])
def test_grazing_surfaces_drop_out(lean: float, read_fraction: tuple[float, float]) -> None:
    """Matched images: 96 % at 80 degrees, 55 % at 84, 19 % at 87."""
    camera = PinholeCamera.from_focal(240, 90, 424.0)
    depth = read(plane(2.0, lean, camera, code=205), capture=capture_of(camera))[:, 116:144]
    assert read_fraction[0] <= (depth > 0).mean() <= read_fraction[1]


def test_polished_metal_is_lost_both_in_its_glare_and_beside_it() -> None:
    chrome = capture_of(CAMERA, remission=1.2, roughness=0.2, metallic=1.0)
    facing = read(plane(2.0, camera=CAMERA), capture=chrome)[118:123, 420:428]
    turned = read(plane(2.0, 45.0, CAMERA), capture=chrome)[:, 420:428]
    matt = read(plane(2.0, 45.0, CAMERA))[:, 420:428]
    assert (facing == 0).all()
    assert (turned == 0).mean() > 0.9
    assert (matt > 0).all()


# Against Nguyen, Izadi & Lovell 2012, and geometry in closed form.


KINECT = StructuredLight(min_range=0.4, max_range=5.0)
PATTERN_CAPTURE = capture_of()


def read_pattern(buffers: RenderBuffers, model: StructuredLight = KINECT) -> np.ndarray:
    return model.read(buffers, PATTERN_CAPTURE, np.random.default_rng(3))


def published(z: float, lean_deg: float) -> float:
    theta = np.deg2rad(lean_deg)
    lean = theta**2 / (np.pi / 2 - theta) ** 2
    return 0.0012 + 0.0019 * (z - 0.4) ** 2 + 0.0001 / np.sqrt(z) * lean


@pytest.mark.parametrize("z", [0.8, 1.2, 2.0, 3.0])
@pytest.mark.parametrize("lean", [0.0, 30.0, 60.0])
def test_the_spread_on_flat_targets_is_the_published_one(z: float, lean: float) -> None:
    buffers = plane(z, lean)
    middle = np.s_[:, 145:175]  # narrow, so that distance and angle are nearly those of the axis
    error = (read_pattern(buffers) - buffers.depth)[middle]
    assert error.std() == pytest.approx(published(z, lean), rel=0.12)
    assert (read_pattern(buffers)[middle] > 0).all()


def test_depth_comes_in_eighths_of_a_pixel_of_disparity() -> None:
    found = np.unique(read_pattern(plane(3.0)))
    steps = 585.5 * 0.075 * 8 / found[found > 0]
    np.testing.assert_allclose(steps, np.rint(steps), atol=2e-3)
    assert len(steps) > 3


def test_nothing_is_read_beyond_80_degrees() -> None:
    assert (read_pattern(plane(1.5, 77.0))[100:140, 155:165] > 0).mean() > 0.95
    assert (read_pattern(plane(1.5, 84.0))[100:140, 155:165] == 0).all()


def test_the_shadow_of_the_projector_is_as_wide_as_triangulation_says() -> None:
    buffers = step(1.0, 2.0, slice(150, 250))
    width = 585.5 * 0.075 * (1 / 1.0 - 1 / 2.0)
    lost = read_pattern(buffers)[120] == 0
    first = np.flatnonzero(lost & (np.arange(320) > 60))[0]
    # The window's vote eats up to four pixels more on either side.
    assert 0 <= (150 - first) - width <= 6
    right = lost[250:300].sum()
    assert right <= 6


def test_a_bend_is_read_but_a_jump_is_not() -> None:
    bend = read_pattern(corner(1.5, concave=True))[100:140, 100:220]
    assert (bend > 0).mean() > 0.97
    jump = read_pattern(step(1.0, 1.3, slice(150, 320)))[100:140, 148:152]
    assert (jump == 0).mean() > 0.9


def test_edges_are_ragged_by_the_lateral_noise() -> None:
    model = with_constants(KINECT, agreement_px=1e6)
    buffers = step(1.0, 2.0, slice(0, 160))
    near = read_pattern(buffers, model) < 1.5
    # A reading in column c comes from a place right of the edge with P(c + N(0, 0.8) > 159.5).
    for column, expected in ((158, 0.96), (159, 0.73), (160, 0.27), (161, 0.04)):
        assert near[:, column].mean() == pytest.approx(expected, abs=0.1)


@pytest.mark.parametrize(
    ("z", "lean", "material", "least", "most"),
    [
        (3.9, 0.0, {"remission": 1.0}, 0.99, 1.0),
        (3.0, 70.0, {"remission": 1.0}, 0.97, 1.0),
        (3.5, 0.0, {"remission": 0.3, "roughness": 0.85}, 0.97, 1.0),
        (3.5, 60.0, {"remission": 0.3, "roughness": 0.85}, 0.0, 0.8),
        (1.2, 0.0, {"remission": 0.06, "roughness": 0.9}, 0.97, 1.0),
        (3.0, 0.0, {"remission": 0.06, "roughness": 0.9}, 0.0, 0.15),
        (1.5, 0.0, {"remission": 1.2, "roughness": 0.2, "metallic": 1.0}, 0.0, 0.01),
        (1.5, 45.0, {"remission": 1.2, "roughness": 0.2, "metallic": 1.0}, 0.0, 0.1),
    ],
)
def test_dark_shiny_and_steep_surfaces_are_lost(
    z: float, lean: float, material: dict[str, float], least: float, most: float
) -> None:
    """Khoshelham & Elberink 2012 name them; the thresholds are priors."""
    read = KINECT.read(plane(z, lean), capture_of(**material), np.random.default_rng(3))
    assert least <= (read[115:125, 155:165] > 0).mean() <= most
