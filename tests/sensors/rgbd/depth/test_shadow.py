import numpy as np

from warehouse_sim.sensors.rgbd.depth.edges import baseline_shadow


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
