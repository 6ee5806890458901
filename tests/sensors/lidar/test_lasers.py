import numpy as np
import pytest

from warehouse_sim.sensors.lidar import LIDAR_PRESETS
from warehouse_sim.sensors.lidar.lasers import LASERS
from warehouse_sim.sensors.lidar.sweep import make_sweep


def test_the_hdl64e_spans_what_its_data_sheet_says_but_irregularly() -> None:
    lasers = LASERS["hdl64e"]()
    elevation = np.sort(np.degrees(lasers.elevation))[::-1]
    assert len(elevation) == 64
    assert elevation[0] == pytest.approx(2.0, abs=0.1)
    assert elevation[-1] == pytest.approx(-24.9, abs=0.4)
    upper, lower = -np.diff(elevation[:32]), -np.diff(elevation[32:])
    assert upper.mean() == pytest.approx(1 / 3, abs=0.02)
    assert lower.mean() == pytest.approx(1 / 2, abs=0.02)
    assert upper.std() > 0.03
    assert lower.std() > 0.05
    assert set(np.round(lasers.left, 6)) == {0.026, -0.026}


def test_the_hdl64e_s2_is_the_calibrated_unit_of_the_drivers() -> None:
    """Three rows of 64e_s2.1-sztaki.yaml, as they stand there (rad, m)."""
    lasers = LASERS["hdl64e_s2"]()
    rows = np.stack([lasers.elevation, lasers.azimuth, lasers.up, lasers.left], axis=1)[[0, 29, 41]]
    expected = [
        [-0.15304134919741974, -0.1248942899601548, 0.19548199, 0.026],
        [0.08674443287511571, 0.043892943273872005, 0.21282616, -0.026],
        [-0.3511493721000192, 0.1679293847080498, 0.11138678, -0.026],
    ]
    np.testing.assert_allclose(rows, expected, atol=6e-5)
    assert np.degrees(lasers.azimuth).max() == pytest.approx(9.6, abs=0.05)


def test_the_vlp16_fires_in_its_order_and_time() -> None:
    lasers = LASERS["vlp16"]()
    order = [-15, 1, -13, 3, -11, 5, -9, 7, -7, 9, -5, 11, -3, 13, -1, 15]
    np.testing.assert_allclose(np.degrees(lasers.elevation), order, atol=1e-12)
    np.testing.assert_allclose(lasers.delay, np.arange(16) * 2.304e-6)
    np.testing.assert_allclose(lasers.up[[0, 1, 2, 15]], [0.0112, -0.0007, 0.0097, -0.0112], atol=6e-5)
    assert lasers.rings()[-1] == 0
    assert lasers.rings()[0] == 15


def test_the_os1_is_a_measured_unit() -> None:
    """A few of the numbers in the metadata of part 840-103575-06, and what they have in common."""
    lasers = LASERS["os1_128"]()
    elevation, right = np.degrees(lasers.elevation), -np.degrees(lasers.azimuth)
    np.testing.assert_allclose(elevation[[0, 1, 63, 127]], [20.95, 20.67, -0.28, -21.82], atol=1e-9)
    np.testing.assert_allclose(right[[0, 1, 2, 3, 104, 127]], [4.21, 1.41, -1.4, -4.22, 4.22, -4.2], atol=1e-9)
    assert lasers.ahead == 0.015806
    np.testing.assert_allclose(right.reshape(-1, 4), np.broadcast_to([4.21, 1.41, -1.4, -4.21], (32, 4)), atol=0.031)
    steps = -np.diff(elevation)
    assert 0.27 < steps.min() < steps.max() < 0.38
    assert steps.std() > 0.01


@pytest.mark.parametrize(
    ("name", "per_second", "tolerance"),
    [("hdl64e", 1_333_000, 0.001), ("vlp16", 300_000, 0.04), ("os1_128", 2_621_440, 0.0), ("safety2d", 271 * 15, 0.0)],
)
def test_shots_a_second_are_those_of_the_data_sheet(name: str, per_second: int, tolerance: float) -> None:
    config = LIDAR_PRESETS[name]
    assert len(make_sweep(config).time) * config.turns_per_second == pytest.approx(per_second, rel=tolerance)
