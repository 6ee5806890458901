from pathlib import Path

import numpy as np
import pytest

from warehouse_sim.api.camera import Camera
from warehouse_sim.errors import ConfigError, InputError, UnknownNameError, WarehouseSimError
from warehouse_sim.sensors.rgbd.depth import PRESETS

FILES = Path(__file__).parents[1] / "sensors" / "rig"


def test_a_preset_brings_its_image_and_its_depth_errors() -> None:
    camera = Camera("kitti")
    assert (camera.width, camera.height, camera.K[0, 0]) == (1224, 370, 721.5377)
    assert camera.rig.lidar is None
    assert camera.rig.imu is None


def test_own_numbers_replace_those_of_a_preset() -> None:
    camera = Camera("kitti", height=300, depth="d455")
    assert (camera.width, camera.height) == (1224, 300)
    assert camera.rig.rgbd.depth == PRESETS["d455"]


def test_depth_without_errors() -> None:
    assert Camera(width=64, height=48, focal_px=60, depth="ideal").rig.rgbd.depth.kind == "ideal"


def test_pixels_that_are_not_square() -> None:
    camera = Camera(width=640, height=480, focal_px=500, focal_y_px=520, cx=310.5, cy=200)
    np.testing.assert_array_equal(camera.K, [[500, 0, 310.5], [0, 520, 200], [0, 0, 1]])


@pytest.mark.parametrize(
    ("settings", "error", "words"),
    [
        (dict(preset="d453"), UnknownNameError, ["unknown camera 'd453'", "kitti"]),
        (dict(preset="D435"), UnknownNameError, ["unknown camera 'D435' (did you mean 'd435'?)"]),
        (dict(preset=5), InputError, ["Camera", "preset", "5"]),
        (dict(widht=640), InputError, ["width"]),
        (dict(width=0, height=480, focal_px=500), ConfigError, ["ws.Camera: camera", "width", "16-8,192"]),
        (dict(width=640, height=480, focal_px=float("nan")), WarehouseSimError, ["focal_px"]),
        (dict(preset="kitti", depth="d4355"), UnknownNameError, ["depth camera", "'d4355'", "d435"]),
        (dict(preset="kitti", distortion={"k9": 1.0}), ConfigError, ["distortion", "k9"]),
        (dict(preset="d435", hfov_deg=1.57), ConfigError, ["5-170 degrees"]),
    ],
)
def test_what_is_no_camera_is_an_error_in_one_line(settings: dict, error: type[Exception], words: list[str]) -> None:
    with pytest.raises(error) as caught:
        Camera(**settings)
    assert all(word in str(caught.value) for word in words)
    assert "\n" not in str(caught.value)


def test_a_file_of_ros(tmp_path: Path) -> None:
    path = tmp_path / "camera_info.yaml"
    path.write_text(
        "image_width: 640\nimage_height: 480\n"
        "camera_matrix: {rows: 3, cols: 3, data: [525, 0, 319, 0, 527, 241, 0, 0, 1]}\n"
        "distortion_model: plumb_bob\ndistortion_coefficients: {rows: 1, cols: 5, data: [-0.1, 0.02, 0.001, 0, 0]}\n"
    )
    camera = Camera.from_file(path, depth="d435")
    np.testing.assert_array_equal(camera.K, [[525, 0, 319], [0, 527, 241], [0, 0, 1]])
    assert camera.model.distortion is not None
    assert camera.model.distortion.coefficients == (-0.1, 0.02, 0.001, 0.0, 0.0)
    assert camera.rig.rgbd.depth == PRESETS["d435"]
    with pytest.raises(InputError, match="path"):
        Camera.from_file(3)  # type: ignore[arg-type]
    path.write_text('{"seed": 1}')
    with pytest.raises(WarehouseSimError, match=r"camera_info\.yaml"):
        Camera.from_file(path)
