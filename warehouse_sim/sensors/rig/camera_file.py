"""Third-party calibration files as camera settings: ROS ``camera_info``, OpenCV YAML and JSON, BOP ``camera.json``."""

import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from warehouse_sim.errors import ConfigError, shown
from warehouse_sim.yaml_file import parse_yaml

_MOST_BYTES = 1_000_000
_LARGEST = 1e15
"""No number of a camera is larger, and whole numbers beyond the range of floats cannot be calculated with."""
_WIDTHS = ("image_width", "width", "image_Width", "imageWidth", "w")
_HEIGHTS = ("image_height", "height", "image_Height", "imageHeight", "h")
_SIZES = ("image_size", "imageSize", "resolution")
_MATRICES = ("camera_matrix", "cameraMatrix", "Camera_Matrix", "K", "k", "cam_K", "mtx", "intrinsic_matrix")
_LENSES = (
    "distortion_coefficients", "Distortion_Coefficients", "distCoeffs", "dist_coeffs", "distortion_coeffs", "D", "d",
    "dist", "distortion",
)  # fmt: skip
_FISHEYES = ("equidistant", "fisheye", "kannala_brandt4", "kannala_brandt")
_BROWNS = ("plumb_bob", "rational_polynomial", "radtan", "brown_conrady", "none", "")
_BROWN = ("k1", "k2", "p1", "p2", "k3")
_COUNTS = (0, 4, 5, 8, 12, 14)
"""Numbers of coefficients that OpenCV's lens model comes with."""
_BARE_EXPONENT = re.compile(r"[-+]?[0-9]+[eE][-+]?[0-9]+")
"""A number as the drivers of ROS write it, which is text in YAML 1.1: 1e-05."""
_OPENCV = re.compile(r"\A%YAML[: ][^\n]*\n(---[^\n]*\n)?")


def read_camera_file(path: Path) -> dict[str, Any]:
    """Return the settings of a rig's camera as a recipe writes them.

    Raises:
        ConfigError: The file cannot be read, lacks size or focal length, or holds a lens, a skew, a binning or a region
            of interest that the camera model has no place for.
    """
    try:
        return _settings(_parsed(path), str(path))
    except RecursionError as problem:
        raise ConfigError(f"{path}: nests too many levels deep; that is no camera file") from problem


def _settings(data: Any, where: str) -> dict[str, Any]:
    if not isinstance(data, dict):
        raise ConfigError(f"{where}: expected a mapping with the camera's matrix, found {shown(data)}")
    data = data.get("camera_info", data) if isinstance(data.get("camera_info"), dict) else data
    _reject_parts_of_images(data, where)
    width, height = _size(data, where)
    fx, fy, cx, cy = _matrix(data, where)
    settings: dict[str, Any] = {"width": width, "height": height, "focal_px": fx, "cx": cx, "cy": cy}
    if fy != fx:
        settings["focal_y_px"] = fy
    return settings | _lens(data, where)


def _parsed(path: Path) -> Any:
    try:
        if path.stat().st_size > _MOST_BYTES:
            raise ConfigError(f"{path}: is larger than {_MOST_BYTES // 1000} kB; that is no camera file")
        if path.exists() and not path.is_file():  # what has no end, such as a device, is not read
            raise ConfigError(f"{path}: is no file; check the path")
        text = path.read_text(encoding="utf-8")
    except (OSError, ValueError) as problem:
        reason = getattr(problem, "strerror", None) or "it is no text"
        raise ConfigError(f"{path}: cannot be read ({reason}); check the path") from problem
    if path.suffix.lower() == ".json":
        try:
            return json.loads(text)
        except ValueError as problem:
            raise ConfigError(f"{path}: is not valid JSON ({problem})") from problem
    plain = _OPENCV.sub("", text).replace("!!opencv-matrix", "")
    first = next((part for part in re.split(r"(?m)^---[^\n]*$", plain) if part.strip()), "")  # of several messages
    return parse_yaml(first, str(path))


def _reject_parts_of_images(data: Mapping[str, Any], where: str) -> None:
    """Reject calibrations of which the image is a part or a shrunk copy."""
    for key in ("binning_x", "binning_y"):
        if data.get(key) not in (None, 0, 1):
            raise ConfigError(
                f"{where}: {key} {shown(data[key])}: give the camera_info of the full image, without binning"
            )
    region = data.get("roi")
    if isinstance(region, dict) and any(region.get(key) for key in ("x_offset", "y_offset", "width", "height")):
        raise ConfigError(f"{where}: roi {shown(region)}: give the camera_info of the full image, without a region")


def _size(data: Mapping[str, Any], where: str) -> tuple[int, int]:
    sizes = next((_flat(data[key]) for key in _SIZES if key in data), [_first(data, _WIDTHS), _first(data, _HEIGHTS)])
    whole = [int(value) for value in sizes if _is_finite(value) and value == int(value)]
    if len(whole) != 2:
        raise ConfigError(f"{where}: does not say the size of the image; add width and height (px)")
    return whole[0], whole[1]


def _matrix(data: Mapping[str, Any], where: str) -> tuple[float, float, float, float]:
    """Return focal lengths and optical axis (px)."""
    key = next((key for key in _MATRICES if key in data), None)
    if key is None:
        keys = [("fx", "f_x"), ("fy", "f_y"), ("cx", "c_x", "ppx"), ("cy", "c_y", "ppy")]
        values = [_first(data, names) for names in keys]
        if not all(map(_is_number, values)):
            raise ConfigError(f"{where}: holds no camera matrix; add camera_matrix, K, or fx, fy, cx and cy (px)")
        return _finite(values, where)
    matrix = _flat(data[key])
    if len(matrix) == 4:
        return _finite(matrix, f"{where}: {key}")
    if len(matrix) != 9:
        raise ConfigError(f"{where}: {key} must have 9 numbers, row by row, found {len(matrix)}")
    fx, skew, cx, zero, fy, cy, *last = _finite(matrix, f"{where}: {key}")
    if skew != 0 or zero != 0 or last != [0.0, 0.0, 1.0]:
        raise ConfigError(
            f"{where}: {key}: a skew of {skew} px has no place in the camera model; calibrate without one"
        )
    return fx, fy, cx, cy


def _lens(data: Mapping[str, Any], where: str) -> dict[str, Any]:
    """Return the lens as settings, none where it does nothing."""
    named = [key for key in ("fisheye", *_LENSES) if key in data and data[key] is not None]
    if not named:
        return {}
    values = list(_finite(_flat(data[named[0]]), f"{where}: {named[0]}"))
    stated = _first(data, ("distortion_model", "camera_model", "model"))
    if any(values) and stated == "":
        raise ConfigError(f"{where}: has coefficients of a lens and an empty distortion_model; name it (plumb_bob)")
    model = str(stated or "").lower()
    is_fisheye = named[0] == "fisheye" or model in _FISHEYES or bool(data.get("fisheye_model"))
    if is_fisheye:
        if len(values) != 4:
            raise ConfigError(f"{where}: a fisheye has 4 coefficients k1 to k4, found {len(values)}")
        return {"fisheye": {f"k{number}": value for number, value in enumerate(values, start=1)}}
    if model not in (*_BROWNS, "pinhole", "opencv", "perspective"):
        raise ConfigError(
            f"{where}: the lens model {shown(model)} has no place here; calibrate as plumb_bob (k1 k2 p1 p2 k3) or "
            "as equidistant (a fisheye, k1 k2 k3 k4)"
        )
    if len(values) not in _COUNTS:
        raise ConfigError(f"{where}: {named[0]} must have 4 or 5 coefficients (k1 k2 p1 p2 k3), found {len(values)}")
    if any(values[5:]):
        raise ConfigError(
            f"{where}: {named[0]} has {len(values)} coefficients, of which the camera model holds k1 k2 p1 p2 k3; "
            "calibrate without the rational, thin prism and tilted model (ROS: plumb_bob)"
        )
    return {"distortion": dict(zip(_BROWN, values[:5], strict=False))} if any(values) else {}


def _flat(value: Any) -> list[Any]:
    """Return the numbers of a matrix, however it is written: nested lists, or OpenCV's mapping with ``data``."""
    if isinstance(value, dict):
        return _listed(value.get("data", [value[key] for key in ("width", "height") if key in value]))
    return _listed(value)


def _listed(value: Any) -> list[Any]:
    if isinstance(value, list):
        return [number for item in value for number in _listed(item)]
    return [float(value) if isinstance(value, str) and _BARE_EXPONENT.fullmatch(value) else value]


def _finite(values: Sequence[Any], where: str) -> Any:
    if not all(map(_is_finite, values)):
        raise ConfigError(f"{where}: expected finite numbers, found {shown(list(values))}")
    return tuple(float(value) for value in values)


def _first(data: Mapping[str, Any], keys: Sequence[str]) -> Any:
    return next((data[key] for key in keys if key in data), None)


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _is_finite(value: Any) -> bool:
    return _is_number(value) and -_LARGEST <= value <= _LARGEST
