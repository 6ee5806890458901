import numpy as np
import pytest

from warehouse_sim.scene.viewpoints.paths import Arc, FloorPose, Path, SpeedProfile

CORNER = (Arc(3.0), Arc(1.5 * np.pi / 2, 1 / 1.5), Arc(0.5))


def test_a_quarter_circle_to_the_left_ends_where_geometry_says() -> None:
    end, curvature = Path(FloorPose(1.0, 2.0, 0.0), CORNER).at(3.0 + 0.75 * np.pi + 0.5)
    np.testing.assert_allclose([end.x, end.y, end.yaw], [1.0 + 3.0 + 1.5, 2.0 + 1.5 + 0.5, np.pi / 2], atol=1e-12)
    assert curvature == 0.0


@pytest.mark.parametrize("curvature", [-0.7, 0.0, 1e-12, 0.4])
def test_going_back_undoes_going_ahead(curvature: float) -> None:
    there = FloorPose(0.3, -2.0, 1.1).after(1.7, curvature)
    back = there.after(-1.7, curvature)
    np.testing.assert_allclose([back.x, back.y, back.yaw], [0.3, -2.0, 1.1], atol=1e-9)


def test_a_path_made_from_its_end_ends_there() -> None:
    end = FloorPose(-1.0, 4.0, 2.0)
    path = Path.ending_at(end, CORNER)
    reached, _ = path.at(path.length)
    np.testing.assert_allclose([reached.x, reached.y, reached.yaw], [-1.0, 4.0, 2.0], atol=1e-12)


def test_a_part_of_a_path_follows_the_whole() -> None:
    whole = Path(FloorPose(0.0, 0.0, 0.3), CORNER)
    part = whole.part(1.2, 4.9)
    assert part.length == pytest.approx(3.7, abs=1e-12)
    for distance in np.linspace(0.0, 3.7, 9):
        a, b = part.at(distance)[0], whole.at(1.2 + distance)[0]
        np.testing.assert_allclose([a.x, a.y, a.yaw], [b.x, b.y, b.yaw], atol=1e-12)


@pytest.mark.parametrize("rolling", [False, True])
@pytest.mark.parametrize(("length", "speed"), [(10.0, 1.5), (1.0, 6.0), (4.5, 1.5)])
def test_a_profile_covers_its_length_and_ends_at_rest(rolling: bool, length: float, speed: float) -> None:
    profile = SpeedProfile.over(length, speed, 0.5, rolling)
    assert profile.at(0.0)[0] == 0.0
    assert profile.at(0.0)[1] == (profile.peak if rolling else 0.0)
    distance, last = profile.at(profile.duration)
    assert distance == pytest.approx(length, abs=1e-9)
    assert last == pytest.approx(0.0, abs=1e-9)
    times = np.linspace(0.0, profile.duration, 4001)
    distances, speeds = np.array([profile.at(time) for time in times]).T
    assert speeds.max() <= min(speed, profile.peak) + 1e-12
    assert np.abs(np.diff(speeds) / np.diff(times)).max() <= 0.5 + 1e-6
    np.testing.assert_allclose(np.diff(distances) / np.diff(times), (speeds[1:] + speeds[:-1]) / 2, atol=1e-3)


def test_a_long_path_reaches_the_wanted_speed_and_a_short_one_does_not() -> None:
    assert SpeedProfile.over(10.0, 1.5, 0.5).peak == 1.5
    assert SpeedProfile.over(1.0, 1.5, 0.5).peak == pytest.approx(np.sqrt(0.5))
    assert SpeedProfile.over(1.0, 1.5, 0.5, rolling=True).peak == pytest.approx(1.0)
