from dataclasses import replace

import pytest

from warehouse_sim.config import from_mapping
from warehouse_sim.errors import ConfigError
from warehouse_sim.sensors.lidar import LIDAR_PRESETS, LidarConfig
from warehouse_sim.sensors.rig import RigConfig


def test_a_preset_is_named_alone_or_with_what_differs() -> None:
    assert from_mapping(RigConfig, {"lidar": "vlp16"}, "here").lidar == LIDAR_PRESETS["vlp16"]
    changed = from_mapping(RigConfig, {"lidar": {"model": "vlp16", "range_noise": 0}}, "here").lidar
    assert changed == replace(LIDAR_PRESETS["vlp16"], range_noise=0.0)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (
            "vlp32",
            "here: lidar: 'vlp32' is no LiDAR preset (did you mean 'vlp16'?); known: hdl64e, hdl64e_s2, vlp16, os1_128",
        ),
        ({"model": ["vlp16"]}, "here: lidar: ['vlp16'] is no LiDAR preset"),
        ({"rage_noise": 1}, "here: lidar: rage_noise is not a setting; did you mean 'range_noise'?"),
        (3, "here: lidar: expected a mapping of settings, found 3"),
    ],
)
def test_wrong_presets_are_named_with_their_place(data: object, message: str) -> None:
    with pytest.raises(ConfigError) as caught:
        from_mapping(RigConfig, {"lidar": data}, "here")
    assert message in str(caught.value)


@pytest.mark.parametrize("settings", [{"azimuth_range_deg": (10.0, 5.0)}, {"max_range": 0.1}])
def test_impossible_settings_are_rejected_by_name(settings: dict) -> None:
    with pytest.raises(ConfigError, match=next(iter(settings))):
        LidarConfig(**settings)
