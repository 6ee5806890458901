"""What all depth models share, and depth in a few numbers."""

from dataclasses import replace

import numpy as np
import pytest

from tests.sensors.targets import buffers_of, capture_of, corner, plane
from warehouse_sim.config import from_mapping, to_mapping
from warehouse_sim.errors import ConfigError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.schema import NO_COLOR
from warehouse_sim.sensors.rgbd import RgbdConfig
from warehouse_sim.sensors.rgbd.depth import MODELS, PRESETS, DepthModel, noise
from warehouse_sim.sensors.rgbd.depth.active_stereo import ActiveStereo
from warehouse_sim.sensors.rgbd.depth.edges import baseline_shadow
from warehouse_sim.sensors.rgbd.depth.model import IdealDepth, QuadraticDepth
from warehouse_sim.sensors.rgbd.depth.time_of_flight import TimeOfFlight
from warehouse_sim.sensors.view import Capture


def config_of(depth: object) -> DepthModel:
    return from_mapping(RgbdConfig, {"depth": depth}, "here: rgbd").depth


def test_a_model_is_named_with_settings() -> None:
    for kind, model in MODELS.items():
        assert config_of({"model": kind}) == model()
    assert config_of({"sigma_base": 0.002}) == MODELS["quadratic"](sigma_base=0.002)  # type: ignore[call-arg]
    assert from_mapping(RgbdConfig, {}, "here").depth == MODELS["quadratic"]()


def test_a_preset_is_named_alone_or_with_other_settings() -> None:
    for name, preset in PRESETS.items():
        assert config_of(name) == config_of({"preset": name}) == preset
    found = config_of({"model": "active_stereo", "preset": "d455", "subpixel_px": 0.05})
    assert found == ActiveStereo(focal_px=447.0, baseline=0.095, color_offset=0.059, subpixel_px=0.05)


@pytest.mark.parametrize("preset", sorted(PRESETS))
def test_what_is_written_is_read_back(preset: str) -> None:
    config = RgbdConfig(PRESETS[preset])
    assert from_mapping(RgbdConfig, to_mapping(config), "again") == config


@pytest.mark.parametrize(
    ("depth", "message"),
    [
        ("d345", "here: rgbd: depth: preset must be one of 'kinect_v1', 'd435'"),
        ({"model": "sonar"}, "here: rgbd: depth: model must be one of 'ideal', 'quadratic'"),
        ({"model": "ideal", "preset": "d435"}, "here: rgbd: depth: the preset 'd435' is of the model 'active_stereo'"),
        ({"model": "ideal", "sigma_base": 1}, "here: rgbd: depth: sigma_base is not a setting"),
        ({"preset": "d435", "baselin": 1}, "baselin is not a setting; did you mean 'baseline'?"),
        ({"model": "ideal", "max_range": 0.1}, "max_range must exceed min_range"),
        ({"preset": "flexx2", "sigma_linear": -0.1}, "sigma_linear makes the noise negative"),
        (3, "expected a preset's name or a mapping of settings, found 3"),
    ],
)
def test_wrong_settings_are_named_with_their_place(depth: object, message: str) -> None:
    with pytest.raises(ConfigError) as caught:
        config_of(depth)
    assert message in str(caught.value)


@pytest.mark.parametrize(
    "model", [*(kind() for kind in MODELS.values()), *PRESETS.values()], ids=lambda item: item.kind
)
def test_every_model_is_decided_by_its_stream_and_reads_nothing_out_of_range(model: DepthModel) -> None:
    buffers, capture = corner(1.5, concave=True), capture_of()
    first, again, other = (model.read(buffers, capture, np.random.default_rng(seed)) for seed in (1, 1, 2))
    assert first.dtype == np.float32
    assert np.array_equal(first, again)
    assert np.array_equal(first, other) == (model.kind == "ideal")
    read = first[first > 0]
    assert len(read) > 0.5 * first.size
    assert read.min() >= model.min_range
    assert read.max() <= model.max_range


def test_what_a_model_needs_is_requested_for() -> None:
    buffers = corner(1.5, concave=True)
    bare = Capture(capture_of().camera)
    with pytest.raises(ValueError, match="active_stereo' needs the materials"):
        PRESETS["d435"].read(buffers, bare, np.random.default_rng(0))
    with pytest.raises(ValueError, match="active_stereo' needs the colours"):
        PRESETS["d435"].read(replace(buffers, rgb=NO_COLOR), capture_of(), np.random.default_rng(0))
    object.__setattr__(buffers, "normals", None)
    with pytest.raises(ValueError, match="structured_light' needs the normals"):
        PRESETS["kinect_v1"].read(buffers, bare, np.random.default_rng(0))
    assert not PRESETS["flexx2"].needs_reflections
    surfaces = capture_of().surfaces
    assert surfaces is not None
    unreflected = Capture(bare.camera, surfaces=replace(surfaces, reflected=None))
    with pytest.raises(ValueError, match="follows reflections"):
        PRESETS["tof_industrial"].read(corner(1.5, concave=True), unreflected, np.random.default_rng(0))


CAMERA = PinholeCamera.from_focal(500, 400, 500.0)
CAPTURE = capture_of(CAMERA)


def read(depth: np.ndarray, **options: float) -> np.ndarray:
    model = QuadraticDepth(**{"sigma_base": 0.0, "sigma_quadratic": 0.0, "min_range": 0.0, **options})
    return model.read(buffers_of(depth, np.zeros((*depth.shape, 3))), CAPTURE, np.random.default_rng(5))


@pytest.mark.parametrize("z", [0.5, 2.0, 8.0])
def test_the_spread_is_that_of_the_formula(z: float) -> None:
    sigma = 0.001 + 0.002 * z * z
    error = read(np.full((400, 500), z), sigma_base=0.001, sigma_quadratic=0.002) - z
    assert error.std() == pytest.approx(sigma, rel=0.05)
    assert abs(error.mean()) < 5 * sigma * 5 / np.sqrt(error.size)
    double = read(np.full((400, 500), z), sigma_base=0.001, sigma_quadratic=0.002, noise_scale=2)
    np.testing.assert_allclose(double - z, 2 * error, atol=1e-5)


def test_without_noise_depth_is_the_ground_truth_and_nothing_stays_nothing() -> None:
    depth = np.random.default_rng(0).uniform(0.5, 9, (400, 500)).astype(np.float32)
    depth[:50] = 0.0
    assert np.array_equal(read(depth), depth)
    disturbed = read(depth, sigma_base=0.5, sigma_quadratic=0.1)
    assert (disturbed[:50] == 0.0).all()
    assert disturbed.min() >= 0.0
    assert disturbed.dtype == np.float32


def test_the_ideal_camera_reads_the_ground_truth_within_its_range() -> None:
    buffers = plane(4.0, 50.0, CAMERA)
    reading = IdealDepth(min_range=3.0, max_range=4.5).read(buffers, CAPTURE, np.random.default_rng(0))
    inside = (buffers.depth >= 3.0) & (buffers.depth <= 4.5)
    assert 0.1 < inside.mean() < 0.9
    assert np.array_equal(reading, np.where(inside, buffers.depth, 0.0))


def test_what_seems_to_lie_out_of_range_is_not_read() -> None:
    depth = read(np.full((400, 500), 4.0), sigma_base=0.1, max_range=4.05, min_range=3.9)
    assert depth[depth > 0].min() >= 3.9
    assert depth.max() <= 4.05
    # Of a Gaussian, 69 % lie below half a sigma and 16 % below minus one.
    assert (depth > 0).mean() == pytest.approx(0.533, abs=0.02)  # windows of 5 x 5 pixels share their noise


# Noise that neighbours share, and what is constant in one built camera.


SIZE = (400, 500)


def test_noise_is_alike_within_the_window_and_not_beyond() -> None:
    sampled = noise.unit_noise(SIZE, np.random.default_rng(1), 5)
    assert sampled.shape == SIZE
    for shift, expected in ((1, 0.8), (2, 0.6), (4, 0.2), (5, 0.0), (9, 0.0)):
        # Two means over windows of five share 5 - shift of five columns.
        assert np.mean(sampled[:, shift:] * sampled[:, :-shift]) == pytest.approx(expected, abs=0.03)
    white = noise.unit_noise(SIZE, np.random.default_rng(1), 1)
    assert np.mean(white[:, 1:] * white[:, :-1]) == pytest.approx(0.0, abs=0.01)


@pytest.mark.parametrize(
    ("size", "expected"), [(0.3, 1), (1.0, 1), (1.9, 1), (2.5, 3), (7.0, 7), (11.9, 11), (12.1, 13)]
)
def test_the_window_is_the_nearest_odd_number(size: float, expected: int) -> None:
    assert noise.odd_window(size) == expected


NOISE_CAPTURE = capture_of()
STILL = TimeOfFlight(noise_scale=0.0, multipath=0.0, sigma_lateral_px=0.0, max_range=9.0, focal_px=585.5)


def error(model: TimeOfFlight, z: float = 1.0, seed: int = 0) -> np.ndarray:
    return model.read(plane(z), NOISE_CAPTURE, np.random.default_rng(seed)) - np.float32(z)


def test_a_unit_has_its_pattern_in_every_image_and_another_unit_another() -> None:
    model = replace(STILL, fixed_pattern=0.01, smooth_px=1.2)
    first, later, other = error(model), error(model, seed=5), error(replace(model, unit=7))
    assert np.array_equal(first, later)
    assert np.abs(np.corrcoef(first.ravel(), other.ravel())[0, 1]) < 0.05
    assert first.std() == pytest.approx(0.01, rel=0.05)
    np.testing.assert_allclose(error(model, 2.0), 2 * first, atol=1e-5)
    assert np.array_equal(noise.unit_pattern(3, (20, 30), 0.0), noise.unit_pattern.__wrapped__(3, (20, 30), 0.0))


def test_units_differ_by_offset_and_scale_as_they_are_drawn() -> None:
    offsets = [float(error(replace(STILL, unit_offset=0.01, unit=unit)).mean()) for unit in range(60)]
    assert np.std(offsets) == pytest.approx(0.01, rel=0.3)
    scales = [float(error(replace(STILL, unit_scale=0.003, unit=unit), 4.0).mean()) for unit in range(60)]
    assert np.std(scales) == pytest.approx(0.012, rel=0.3)


def test_the_cyclic_error_runs_four_times_through_the_unambiguous_range() -> None:
    ranges = np.linspace(0.1, 7.4, 4000, dtype=np.float32)[None]
    phase = noise.unit_samples(4)[2]
    np.testing.assert_allclose(
        noise.wiggle(ranges, 7.5, phase), np.sin(4 * 2 * np.pi * ranges / 7.5 + phase), atol=0.01
    )
    model = replace(STILL, wiggle=0.004, unit=4)
    for z in (0.5, 1.3, 3.1):
        assert error(model, z).mean() == pytest.approx(0.004 * np.sin(4 * 2 * np.pi * z / 7.5 + phase), abs=5e-5)


@pytest.mark.parametrize("smooth_px", [0.7, 1.2, 3.0])
def test_smoothed_noise_has_variance_one_and_the_likeness_of_a_gaussian_filter(smooth_px: float) -> None:
    sampled = noise.gaussian_noise((600, 800), np.random.default_rng(2), smooth_px)
    assert sampled.std() == pytest.approx(1.0, rel=0.04)
    for lag in (1, 2, 3):
        alike = float((sampled[:, lag:] * sampled[:, :-lag]).mean())
        assert alike == pytest.approx(np.exp(-(lag**2) / (4 * smooth_px**2)), abs=0.04)


def test_a_thin_pole_hides_only_what_is_behind_it_in_the_second_image() -> None:
    disparity = np.full((3, 200), 10.0, np.float32)
    disparity[:, 120:124] = 50.0
    hidden = baseline_shadow(disparity)
    # The pole's columns 120-123 lie at 70-73 in the second image, as the wall's columns 80-83 do.
    assert np.array_equal(np.flatnonzero(hidden[1]), [*range(10), *range(80, 84)])


def test_a_leaning_surface_does_not_hide_itself() -> None:
    disparity = np.tile(np.linspace(40.0, 10.0, 200, dtype=np.float32), (2, 1))
    assert not baseline_shadow(disparity)[:, 45:].any()
    assert not baseline_shadow(disparity[:, ::-1])[:, 45:].any()


def test_what_is_behind_a_leaning_board_is_hidden_without_gaps() -> None:
    """The second eye sees the board larger, so that its columns lie farther apart there."""
    disparity = np.full((2, 300), 10.0, np.float32)
    disparity[:, 150:250] = np.linspace(70.0, 40.0, 100)
    hidden = np.flatnonzero(baseline_shadow(disparity)[0, 20:150]) + 20
    # The board's left edge lies at 150 - 70 = 80, where the wall's column 90 does.
    assert hidden.tolist() == list(range(90, 150))
