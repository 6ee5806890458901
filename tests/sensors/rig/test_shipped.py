from pathlib import Path

import numpy as np
import pytest

from warehouse_sim.errors import ConfigError
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.resources import data_folder
from warehouse_sim.sensors.rig import RigConfig


def rig(data: dict) -> RigConfig:
    return RigConfig.from_plain(data, "here")


def test_kitti_has_the_geometry_of_kitti() -> None:
    found = rig({"rig": "kitti"})
    camera = found.make_camera()
    assert (camera.width, camera.height, camera.fx, camera.fy) == (1224, 370, 721.5377, 721.5377)
    assert found.camera_height == 1.65
    assert found.lidar is not None
    assert found.lidar.model == "hdl64e"
    assert found.right is not None
    assert found.right.baseline == 0.54
    T_camera_lidar = found.mounted()["lidar"].T_camera_sensor()
    assert found.camera_height - T_camera_lidar[1, 3] == pytest.approx(1.73)
    np.testing.assert_allclose(T_camera_lidar, [[0, -1, 0, 0], [0, 0, -1, -0.08], [1, 0, 0, -0.27], [0, 0, 0, 1]])
    assert np.array_equal(T_camera_lidar, RigConfig().mounted()["lidar"].T_camera_sensor())


def test_settings_of_the_recipe_replace_those_of_the_rig() -> None:
    found = rig({"rig": "amr", "lidar": "os1_128", "lidars": {}})
    assert found.lidar is not None
    assert found.lidar.model == "os1_128"
    assert found.lidars == {}
    assert found.lidar_mount == rig({"rig": "amr"}).lidar_mount


def test_a_rig_can_be_a_file(tmp_path: Path) -> None:
    path = tmp_path / "own.yaml"
    path.write_text("lidar: vlp16\nlidar_mount: {carrier: camera, up: 0.3}\n")
    assert rig({"rig": str(path)}).mounted()["lidar"].T_camera_sensor()[1, 3] == pytest.approx(-0.3)
    path.write_text("lidar_mout: {up: 0.3}\n")
    with pytest.raises(ConfigError, match="lidar_mout is not a setting; did you mean 'lidar_mount'"):
        rig({"rig": str(path)})


@pytest.mark.parametrize(
    ("name", "message"), [("kity", "here: rig: .*kitti"), ("no.yaml", "no.yaml: cannot be read"), (3, "here: rig")]
)
def test_an_unknown_rig_is_named(name: object, message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        rig({"rig": name})


def test_a_recipe_takes_the_rigs_camera_height_unless_it_names_one(tmp_path: Path) -> None:
    text = (data_folder("scenes") / "smoke.yaml").read_text().replace("rig: dissertation", "rig: kitti")
    path = tmp_path / "with_height.yaml"
    path.write_text(text)
    assert load_recipe(str(path)).scene.viewpoints == load_recipe("smoke").scene.viewpoints
    path.write_text(text.replace("    height: {min: 0.4, max: 2.5}\n", ""))
    height = load_recipe(str(path)).scene.viewpoints.height
    assert height is not None
    assert (height.low, height.high) == (1.65, 1.65)
