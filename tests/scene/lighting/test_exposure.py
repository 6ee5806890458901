import numpy as np
import pytest

from warehouse_sim.errors import ConfigError
from warehouse_sim.scene.lighting.exposure import ExposureConfig, ev_of_exposure, exposure_of_ev, metered_ev

EVEN = np.ones(3)


def test_exposure_values_are_those_of_photography() -> None:
    # 4000 cd/m^2, a sunlit scene, is EV 15 at ISO 100 by the usual tables and K = 12.5.
    assert metered_ev(np.full(3, 4096.0), EVEN) == pytest.approx(15.0)
    assert exposure_of_ev(15.0) == pytest.approx(1.0 / (1.2 * 2**15))
    assert exposure_of_ev(5.0) == pytest.approx(2 * exposure_of_ev(6.0))
    for ev in (-3.0, 0.0, 7.25):
        assert ev_of_exposure(exposure_of_ev(ev)) == pytest.approx(ev)


def test_the_meter_takes_the_weighted_mean_of_encoded_values() -> None:
    luminance, weights = np.array([0.0, 8.0]), np.array([3.0, 1.0])
    assert metered_ev(luminance, weights) == pytest.approx(np.log2(8 * 8.0) - 2 * 2.2)
    door = np.array([20.0] * 9 + [5000.0])
    log_average, average = (np.log2(8 * value) for value in (np.exp(np.log(door).mean()), door.mean()))
    assert log_average + 1 < metered_ev(door, np.ones(10)) < average - 1


def test_compensation_brightens_and_the_camera_has_a_limit() -> None:
    luminance = np.full(3, 1.0)  # EV 3
    assert ExposureConfig(compensation=1.0).ev_for(luminance, EVEN) == pytest.approx(2.0)
    assert ExposureConfig(min_ev=5.0).ev_for(luminance, EVEN) == 5.0
    assert ExposureConfig("fixed", ev=9.0).ev_for(luminance, EVEN) == 9.0


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"mode": "fixed"}, "ev belongs to the fixed mode"),
        ({"ev": 3.0}, "ev belongs to the fixed mode"),
        ({"mode": "fixed", "ev": 30.0}, "ev must be -6 to 18, found 30.0"),
        ({"compensation": 9.0}, "compensation must be -5 to 5 stops, found 9.0"),
        ({"min_ev": 30.0}, "min_ev must be -6 to 18, found 30.0"),
    ],
)
def test_what_makes_no_exposure_is_rejected(settings: dict, message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        ExposureConfig(**settings)
