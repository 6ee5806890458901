"""Arrays of a frame as text for a page: its picture, its depth as what unprojects to a cloud, its sweep, outlines."""

import base64
from typing import Any

import cv2
import numpy as np
from jaxtyping import Float, UInt8

from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.records import ImageRecord
from warehouse_sim.dataset.viewing.overlay import Image, colorize_depth, segment_pixels
from warehouse_sim.geometry.boxes import box_edges
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import transform_points

_WIDTHS, _QUALITIES = (640, 480, 400), (80, 65, 50)
_ROOMY = 60_000
"""Characters a frame from which on its depth image is the wider one."""
_NEAREST, _FARTHEST = 0.1, 65.0
"""Depth (m) of the first and the last step."""
_STEPS = 4095
_SWEEP_POINTS = 1500
_MOST_TANGENT = 3.0
"""Beyond this slope the view behind a lens is cut from the cloud."""


def base_picture(reader: DatasetReader, image: ImageRecord) -> Image:
    """Return the colour image; depth in colours where the dataset was made without.

    Raises:
        DatasetError: It holds neither.
    """
    if reader.leaves_out("rgb") and reader.has_depth:
        return colorize_depth(reader.depth(image))
    return reader.rgb(image)


def picture_of(reader: DatasetReader, image: ImageRecord, budget: int) -> str:
    """Return the colour image as a WebP data URI, as large and good as ``budget`` characters allow."""
    rgb, uri = base_picture(reader, image), ""
    for width in _WIDTHS:
        width = min(width, rgb.shape[1])
        small = cv2.resize(rgb, (width, round(rgb.shape[0] * width / rgb.shape[1])), interpolation=cv2.INTER_AREA)
        for quality in _QUALITIES:
            encoded = cv2.imencode(".webp", small[..., ::-1], [cv2.IMWRITE_WEBP_QUALITY, quality])[1]
            uri = _uri("image/webp", encoded.tobytes())
            if len(uri) <= budget:
                return uri
    return uri


def depth_of(reader: DatasetReader, image: ImageRecord, budget: int) -> dict[str, Any] | None:
    """Return a small depth image without lens; None where there is no depth, or no calibration.

    The PNG holds steps of a logarithmic scale, their upper eight bits above their lower four; 0 = no reading.
    """
    if not (reader.has_depth and image.calibrated) or reader.leaves_out("depth"):
        return None
    depth, camera = reader.depth(image), _small(image.camera, 200 if budget >= _ROOMY else 120)
    seen = np.round(image.camera.project(camera.rays())).astype(int)
    inside = np.all((seen >= 0) & (seen < [image.camera.width, image.camera.height]), axis=-1)
    u, v = np.where(inside[..., None], seen, 0).transpose(2, 0, 1)
    small = np.where(inside, depth[v, u], 0.0)
    ratio = np.log(np.clip(small, _NEAREST, _FARTHEST) / _NEAREST) / np.log(_FARTHEST / _NEAREST)
    steps = np.where(small > 0, 1 + np.round(ratio * (_STEPS - 1)), 0).astype(np.uint16)
    planes = np.vstack([steps >> 4, steps & 15]).astype(np.uint8)
    encoded = cv2.imencode(".png", planes, [cv2.IMWRITE_PNG_COMPRESSION, 9])[1]
    return {
        "png": _uri("image/png", encoded.tobytes()),
        "camera": [round(value, 4) for value in (camera.fx, camera.fy, camera.cx, camera.cy)],
        "scale": [_NEAREST, _FARTHEST, _STEPS],
        "pixels": _colors_at(reader, image, u, v),
    }


def _small(camera: PinholeCamera, columns: int) -> PinholeCamera:
    """Return a pinhole camera of few columns that sees what a camera sees, but for the rim of a wide lens."""
    left, right, top, bottom = np.clip(camera.tangent_bounds(), -_MOST_TANGENT, _MOST_TANGENT).tolist()
    columns = min(columns, camera.width)
    focal = columns / (right - left)
    rows = max(round((bottom - top) * focal), 1)
    return PinholeCamera(columns, rows, focal, focal, -left * focal - 0.5, -top * focal - 0.5)


def _colors_at(reader: DatasetReader, image: ImageRecord, u: np.ndarray, v: np.ndarray) -> str:
    """Return the colours of the depth image's pixels as a data URI."""
    colors: UInt8[np.ndarray, "h w 3"] = np.ascontiguousarray(base_picture(reader, image)[v, u])
    return _uri("image/webp", cv2.imencode(".webp", colors[..., ::-1], [cv2.IMWRITE_WEBP_QUALITY, 60])[1].tobytes())


def sweep_of(reader: DatasetReader, image: ImageRecord) -> str | None:
    """Return points of the main LiDAR in the camera frame as base64 of int16 (cm); None without one."""
    sweep = reader.sweep(image)
    if sweep is None:
        return None
    points = sweep.reading.points[:: max(len(sweep.reading.points) // _SWEEP_POINTS, 1)]
    seen = np.round(100.0 * transform_points(sweep.T_camera_sensor, points.astype(float)))
    return base64.b64encode(np.clip(seen, -32767, 32767).astype("<i2").tobytes()).decode("ascii")


def outline(camera: PinholeCamera, corners: Float[np.ndarray, "8 3"]) -> str:
    """Return the edges of a box, given in the camera frame (m), as the path of an SVG in pixels of the image."""
    path = []
    for a, b in box_edges():
        pixels = segment_pixels(camera, corners[a], corners[b])
        if pixels is not None and _near(camera, pixels):
            path.append("M" + "L".join(f"{u:.0f} {v:.0f}" for u, v in pixels))
    return "".join(path)


def _near(camera: PinholeCamera, pixels: Float[np.ndarray, "n 2"]) -> bool:
    """Return whether a line may touch the image."""
    low, high = pixels.min(axis=0), pixels.max(axis=0)
    return bool((high >= 0).all() and (low <= [camera.width, camera.height]).all())


def _uri(kind: str, data: bytes) -> str:
    return f"data:{kind};base64,{base64.b64encode(data).decode('ascii')}"
