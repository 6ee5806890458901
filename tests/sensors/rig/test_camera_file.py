import json
from pathlib import Path
from typing import Any

import pytest

from warehouse_sim.errors import ConfigError
from warehouse_sim.sensors.rig import read_camera_file

MATRIX = [525.3, 0.0, 319.2, 0.0, 526.9, 241.7, 0.0, 0.0, 1.0]
PINHOLE = {"width": 640, "height": 480, "focal_px": 525.3, "focal_y_px": 526.9, "cx": 319.2, "cy": 241.7}
BROWN = {"k1": -0.12, "k2": 0.05, "p1": 0.001, "p2": -0.0005, "k3": 0.01}
COEFFICIENTS = list(BROWN.values())

ROS = """
image_width: 640
image_height: 480
camera_name: head
camera_matrix:
  rows: 3
  cols: 3
  data: [525.3, 0.0, 319.2, 0.0, 526.9, 241.7, 0.0, 0.0, 1.0]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [-0.12, 0.05, 0.001, -0.0005, 0.01]
projection_matrix: {rows: 3, cols: 4, data: [500, 0, 320, 0, 0, 500, 240, 0, 0, 0, 1, 0]}
"""
MESSAGE = """
header: {stamp: {sec: 1, nanosec: 2}, frame_id: head}
height: 480
width: 640
distortion_model: plumb_bob
d: [-0.12, 0.05, 0.001, -0.0005, 0.01]
k: [525.3, 0.0, 319.2, 0.0, 526.9, 241.7, 0.0, 0.0, 1.0]
p: [525.3, 0.0, 319.2, 0.0, 0.0, 526.9, 241.7, 0.0, 0.0, 0.0, 1.0, 0.0]
binning_x: 0
binning_y: 0
roi: {x_offset: 0, y_offset: 0, height: 0, width: 0, do_rectify: false}
---
height: 1
"""
OPENCV = """%YAML:1.0
---
image_width: 640
image_height: 480
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 525.3, 0., 319.2, 0., 526.9, 241.7, 0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: 1
   cols: 5
   dt: d
   data: [ -0.12, 0.05, 0.001, -0.0005, 0.01 ]
"""


def read(folder: Path, name: str, content: Any) -> dict[str, Any]:
    path = folder / name
    path.write_text(content if isinstance(content, str) else json.dumps(content), encoding="utf-8")
    return read_camera_file(path)


@pytest.mark.parametrize("text", [ROS, MESSAGE, OPENCV], ids=["ros file", "ros message", "opencv"])
def test_yaml_of_a_calibration(text: str, tmp_path: Path) -> None:
    assert read(tmp_path, "camera.yaml", text) == {**PINHOLE, "distortion": BROWN}


def test_numbers_without_a_point_as_drivers_write_them(tmp_path: Path) -> None:
    lens = "distortion: [-1e-01, 2e-2, 1e-05, -5E-04, 0]\n"
    text = f"width: 640\nheight: 480\nK: {MATRIX}\n{lens}"
    found = read(tmp_path, "camera.yaml", text)["distortion"]
    assert found == {"k1": -0.1, "k2": 0.02, "p1": 1e-05, "p2": -5e-04, "k3": 0.0}


@pytest.mark.parametrize(
    "lens", [{"type_id": "opencv-matrix", "rows": 1, "cols": 5, "dt": "d", "data": COEFFICIENTS}, [COEFFICIENTS]]
)
def test_json_of_opencv(lens: Any, tmp_path: Path) -> None:
    matrix = [MATRIX[:3], MATRIX[3:6], MATRIX[6:]]
    data = {"image_size": [640, 480], "camera_matrix": matrix, "dist_coeffs": lens}
    assert read(tmp_path, "camera.json", data) == {**PINHOLE, "distortion": BROWN}


def test_bop(tmp_path: Path) -> None:
    data = {"cx": 325.26, "cy": 242.05, "depth_scale": 0.1, "fx": 572.41, "fy": 573.57, "height": 480, "width": 640}
    expected = {"width": 640, "height": 480, "focal_px": 572.41, "focal_y_px": 573.57, "cx": 325.26, "cy": 242.05}
    assert read(tmp_path, "camera.json", data) == expected
    fisheye = {**data, "fisheye": [0.1, 0.2, 0.3, 0.4]}
    assert read(tmp_path, "camera.json", fisheye)["fisheye"] == {"k1": 0.1, "k2": 0.2, "k3": 0.3, "k4": 0.4}


def test_a_fisheye_of_ros(tmp_path: Path) -> None:
    text = MESSAGE.replace("plumb_bob", "equidistant").replace(", 0.01]", "]")
    assert read(tmp_path, "camera.yaml", text)["fisheye"] == {"k1": -0.12, "k2": 0.05, "k3": 0.001, "k4": -0.0005}


@pytest.mark.parametrize("tail", [[0.0, 0.0, 0.0], [0.0] * 7, [0.0] * 9])
def test_coefficients_of_larger_models_may_be_zero(tail: list[float], tmp_path: Path) -> None:
    data = {"width": 640, "height": 480, "K": MATRIX, "D": [*COEFFICIENTS, *tail], "distortion_model": "plumb_bob"}
    assert read(tmp_path, "camera.json", data)["distortion"] == BROWN


def test_a_lens_that_does_nothing_is_none(tmp_path: Path) -> None:
    assert read(tmp_path, "camera.json", {"width": 640, "height": 480, "K": MATRIX, "D": [0.0] * 5}) == PINHOLE


GOOD = {"width": 640, "height": 480, "K": MATRIX, "D": COEFFICIENTS}


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"D": [*COEFFICIENTS, 0.3, 0.1, 0.2]}, ["8 coefficients", "k1 k2 p1 p2 k3", "plumb_bob"]),
        ({"distortion_model": "thin_prism"}, ["'thin_prism'", "plumb_bob", "equidistant"]),
        ({"distortion_model": ""}, ["an empty distortion_model", "plumb_bob"]),
        ({"distortion_model": "equidistant"}, ["fisheye has 4 coefficients", "found 5"]),
        ({"D": [1.0, 2.0]}, ["D must have 4 or 5", "found 2"]),
        ({"K": [525.3, 0.7, 319.2, 0.0, 526.9, 241.7, 0.0, 0.0, 1.0]}, ["K", "skew of 0.7", "without one"]),
        ({"K": MATRIX[:8]}, ["K must have 9 numbers", "found 8"]),
        ({"K": ["a", *MATRIX[1:]]}, ["finite numbers", "'a'"]),
        ({"width": None}, ["size of the image", "width and height"]),
        ({"binning_x": 2}, ["binning_x 2", "without binning"]),
        ({"roi": {"x_offset": 10, "y_offset": 0, "width": 100, "height": 100}}, ["roi", "full image"]),
        ({"K": None, "fx": 5.0}, ["K"]),
        ({"K": [*MATRIX[:8], "one"]}, ["K", "finite numbers", "'one'"]),
        ({"width": float("inf")}, ["size of the image"]),
        ({"D": {"data": [*COEFFICIENTS[:4], {"k3": 0.1}]}}, ["D", "finite numbers", "k3"]),
        ({"K": [10**400, *MATRIX[1:]]}, ["K", "finite numbers"]),
    ],
)
def test_what_the_camera_model_cannot_hold_is_an_error(changes: dict, words: list[str], tmp_path: Path) -> None:
    with pytest.raises(ConfigError) as caught:
        read(tmp_path, "camera.json", GOOD | changes)
    message = str(caught.value)
    assert message.startswith(str(tmp_path / "camera.json"))
    assert all(word in message for word in words)


@pytest.mark.parametrize("text", ["[1, 2]", "{", "", "fx: 1", "[" * 3000 + "]" * 3000])
def test_what_is_no_calibration_is_an_error(text: str, tmp_path: Path) -> None:
    for name in ("camera.json", "camera.yaml"):
        with pytest.raises(ConfigError, match=name):
            read(tmp_path, name, text)
    for path in ("/dev/zero", str(tmp_path)):
        with pytest.raises(ConfigError, match="is no file"):
            read_camera_file(Path(path))
    with pytest.raises(ConfigError, match="cannot be read"):
        read_camera_file(tmp_path / "missing.yaml")
