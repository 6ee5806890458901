"""Against Nguyen, Izadi & Lovell 2012, and geometry in closed form."""

import numpy as np
import pytest

from tests.sensors.targets import capture_of, corner, plane, step, with_constants
from warehouse_sim.schema import RenderBuffers
from warehouse_sim.sensors.rgbd.depth.structured_light import StructuredLight

KINECT = StructuredLight(min_range=0.4, max_range=5.0)
CAPTURE = capture_of()


def read(buffers: RenderBuffers, model: StructuredLight = KINECT) -> np.ndarray:
    return model.read(buffers, CAPTURE, np.random.default_rng(3))


def published(z: float, lean_deg: float) -> float:
    theta = np.deg2rad(lean_deg)
    lean = theta**2 / (np.pi / 2 - theta) ** 2
    return 0.0012 + 0.0019 * (z - 0.4) ** 2 + 0.0001 / np.sqrt(z) * lean


@pytest.mark.parametrize("z", [0.8, 1.2, 2.0, 3.0])
@pytest.mark.parametrize("lean", [0.0, 30.0, 60.0])
def test_the_spread_on_flat_targets_is_the_published_one(z: float, lean: float) -> None:
    buffers = plane(z, lean)
    middle = np.s_[:, 145:175]  # narrow, so that distance and angle are nearly those of the axis
    error = (read(buffers) - buffers.depth)[middle]
    assert error.std() == pytest.approx(published(z, lean), rel=0.12)
    assert (read(buffers)[middle] > 0).all()


def test_depth_comes_in_eighths_of_a_pixel_of_disparity() -> None:
    found = np.unique(read(plane(3.0)))
    steps = 585.5 * 0.075 * 8 / found[found > 0]
    np.testing.assert_allclose(steps, np.rint(steps), atol=2e-3)
    assert len(steps) > 3


def test_nothing_is_read_beyond_80_degrees() -> None:
    assert (read(plane(1.5, 77.0))[100:140, 155:165] > 0).mean() > 0.95
    assert (read(plane(1.5, 84.0))[100:140, 155:165] == 0).all()


def test_the_shadow_of_the_projector_is_as_wide_as_triangulation_says() -> None:
    buffers = step(1.0, 2.0, slice(150, 250))
    width = 585.5 * 0.075 * (1 / 1.0 - 1 / 2.0)
    lost = read(buffers)[120] == 0
    first = np.flatnonzero(lost & (np.arange(320) > 60))[0]
    # The window's vote eats up to four pixels more on either side.
    assert 0 <= (150 - first) - width <= 6
    right = lost[250:300].sum()
    assert right <= 6


def test_a_bend_is_read_but_a_jump_is_not() -> None:
    bend = read(corner(1.5, concave=True))[100:140, 100:220]
    assert (bend > 0).mean() > 0.97
    jump = read(step(1.0, 1.3, slice(150, 320)))[100:140, 148:152]
    assert (jump == 0).mean() > 0.9


def test_edges_are_ragged_by_the_lateral_noise() -> None:
    model = with_constants(KINECT, agreement_px=1e6)
    buffers = step(1.0, 2.0, slice(0, 160))
    near = read(buffers, model) < 1.5
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
