import numpy as np
import pytest

from warehouse_sim.catalog.racks.tolerances import (
    RackTolerances,
    aisle_width,
    bay_widths,
    beam_pose,
    beam_sag,
    frame_pose,
    rack_yaw,
)
from warehouse_sim.geometry.pose import transform_points

LIMITS = RackTolerances()
NONE = RackTolerances(*[0.0] * len(vars(LIMITS)))


def test_bay_widths_stay_within_3_mm_and_use_the_range() -> None:
    errors = 1000 * (bay_widths(2.7, 5000, LIMITS, np.random.default_rng(0)) - 2.7)
    assert np.abs(errors).max() <= 3.0 + 1e-9
    assert errors.std() == pytest.approx(1.0, rel=0.05)
    assert abs(errors.mean()) < 0.05


@pytest.mark.parametrize("height", [2.0, 8.0])
def test_frames_lean_by_at_most_a_350th_about_their_foot(height: float) -> None:
    rng = np.random.default_rng(1)
    ends = np.array([[0.0, 0.0, -height / 2], [0.0, 0.0, height / 2]])
    leans = []
    for _ in range(300):
        foot, top = transform_points(frame_pose(height, LIMITS, rng), ends)
        assert foot[2] == pytest.approx(-height / 2)
        assert foot[0] == pytest.approx(0.0, abs=1e-12)
        assert abs(foot[1]) <= 0.010 + 1e-12
        leans.append(top[:2] - foot[:2])
    largest = np.abs(leans).max(axis=0)
    assert np.all(largest <= height / 350 + 1e-9)
    assert np.all(largest > 0.6 * height / 350)


def test_beam_ends_are_level_to_the_larger_of_3_mm_and_a_500th() -> None:
    rng = np.random.default_rng(2)
    for length, limit in ((1.0, 0.003), (2.7, 2.7 / 500)):
        ends = np.array([[-length / 2, 0.0, 0.0], [length / 2, 0.0, 0.0]])
        poses = np.array([beam_pose(length, LIMITS, rng) for _ in range(300)])
        z = transform_points(poses, np.broadcast_to(ends, (300, 2, 3)))[..., 2]
        assert 0.6 * limit < np.abs(z[:, 1] - z[:, 0]).max() <= limit
        twist = np.abs(np.rad2deg(np.arctan2(poses[:, 2, 1], poses[:, 2, 2])))
        assert 0.3 * length < twist.max() <= length / 2 + 1e-9


def test_a_full_beam_sags_by_a_200th() -> None:
    assert beam_sag(2.7, 1.0, LIMITS) == pytest.approx(0.0135)
    assert beam_sag(2.7, 0.0, LIMITS) == 0.0


def test_aisle_and_rack_line_stay_in_tolerance() -> None:
    rng = np.random.default_rng(3)
    assert max(abs(aisle_width(3.0, LIMITS, rng) - 3.0) for _ in range(500)) <= 0.015 + 1e-9
    yaws = [np.arctan2(*rack_yaw(10.0, LIMITS, rng)[1::-1, 0]) for _ in range(500)]
    assert 0.0 < max(np.abs(yaws)) <= 0.02 / 10.0 + 1e-9


def test_no_tolerance_means_the_drawing() -> None:
    rng = np.random.default_rng(4)
    np.testing.assert_array_equal(bay_widths(2.7, 3, NONE, rng), 2.7)
    np.testing.assert_allclose(frame_pose(4.5, NONE, rng), np.eye(4), atol=1e-12)
    np.testing.assert_array_equal(beam_pose(2.7, NONE, rng), np.eye(4))


def test_a_negative_tolerance_is_rejected() -> None:
    with pytest.raises(ValueError, match="plumb must be >= 0, found -1"):
        RackTolerances(plumb=-1.0)
