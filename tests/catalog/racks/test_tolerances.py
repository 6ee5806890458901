import numpy as np
import pytest

from warehouse_sim.catalog.racks.pallet_racks import (
    beam_pose,
    frame_pose,
)
from warehouse_sim.geometry.pose import transform_points


@pytest.mark.parametrize("height", [2.0, 8.0])
def test_frames_lean_by_at_most_a_350th_about_their_foot(height: float) -> None:
    rng = np.random.default_rng(1)
    ends = np.array([[0.0, 0.0, -height / 2], [0.0, 0.0, height / 2]])
    leans = []
    for _ in range(300):
        foot, top = transform_points(frame_pose(height, rng), ends)
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
        poses = np.array([beam_pose(length, rng) for _ in range(300)])
        z = transform_points(poses, np.broadcast_to(ends, (300, 2, 3)))[..., 2]
        assert 0.6 * limit < np.abs(z[:, 1] - z[:, 0]).max() <= limit
        twist = np.abs(np.rad2deg(np.arctan2(poses[:, 2, 1], poses[:, 2, 2])))
        assert 0.3 * length < twist.max() <= length / 2 + 1e-9
