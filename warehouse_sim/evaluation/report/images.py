"""Close-ups of true against estimated pose."""

import base64
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Float, UInt8

from warehouse_sim.dataset.reader import ObjectInfo
from warehouse_sim.dataset.viewing.overlay import Color, Image, draw_box_3d, draw_segment
from warehouse_sim.evaluation.docking.fork import approached_face, docking_faces
from warehouse_sim.geometry.boxes import box_corners
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform, transform_points

GT_COLOR: Color = (46, 204, 113)
ESTIMATE_COLOR: Color = (255, 150, 0)
_RIM_COLOR: Color = (16, 20, 24)
_RIM_STRENGTH = 0.55
_BACKDROP = (38, 42, 48)
"""What lies outside the image in a close-up."""
_CLOSE_UP_WH = (480, 300)


@dataclass(frozen=True, eq=False)
class DrawnPose:
    """A pose to draw with the look of its object."""

    T_camera_object: Transform
    color: Color
    width: int
    """Of thin lines (px); the side towards the camera is drawn about twice as strong."""


def jpeg_uri(image: Image) -> str:
    """Return an RGB image as a JPEG data URI."""
    encoded = cv2.imencode(".jpg", image[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 82])[1]
    return "data:image/jpeg;base64," + base64.b64encode(encoded.tobytes()).decode("ascii")


def close_up(
    rgb: Image, camera: PinholeCamera, info: ObjectInfo, T_gt: Transform, T_estimated: Transform | None
) -> Image:
    """Return a window around an object with its true and, if there is one, its estimated box and pockets.

    Args:
        rgb: The whole image.
        camera: Its intrinsics.
        info: The object.
        T_gt: ``T_camera_object`` of the ground truth.
        T_estimated: ``T_camera_object`` of the estimate, or None.
    """
    poses = [DrawnPose(T_gt, GT_COLOR, 3)]
    if T_estimated is not None:
        poses.append(DrawnPose(T_estimated, ESTIMATE_COLOR, 2))
    left, top, width, height = _window(camera, info, [pose.T_camera_object for pose in poses])
    scale = _CLOSE_UP_WH[0] / width
    window_camera = camera.crop(left, top, *_CLOSE_UP_WH, scale)
    canvas = _resize(_cut(rgb, left, top, width, height), *_CLOSE_UP_WH)
    draw_poses(canvas, window_camera, info, poses)
    return canvas


def draw_poses(image: Image, camera: PinholeCamera, info: ObjectInfo, poses: Sequence[DrawnPose]) -> None:
    """Draw an object's box at each pose, later ones on top, in place.

    The side towards the camera is stronger and shows the openings of its pockets. All lines have a dark rim: racks have
    the colours of warnings too.
    """
    rim = image.copy()
    for pose in poses:
        _draw_lines(rim, camera, info, DrawnPose(pose.T_camera_object, _RIM_COLOR, pose.width), extra=2)
    cv2.addWeighted(rim, _RIM_STRENGTH, image, 1.0 - _RIM_STRENGTH, 0.0, dst=image)
    for pose in poses:
        _draw_lines(image, camera, info, pose, extra=0)


def _draw_lines(image: Image, camera: PinholeCamera, info: ObjectInfo, pose: DrawnPose, extra: int) -> None:
    sides = docking_faces(info.size, ())
    side = sides[approached_face(pose.T_camera_object[None], sides)[0]]
    breadth = info.size[1] if side.name.endswith("x") else info.size[0]
    draw_box_3d(image, camera, pose.T_camera_object, info.size, pose.color, pose.width + extra)
    outline = _rectangle(pose.T_camera_object @ side.T_object_dock, breadth, info.size[2])
    rectangles = [(outline, 2 * pose.width - 1 + extra)]
    for pocket in info.pockets:
        if pocket.face == side.name:
            opening = _rectangle(pose.T_camera_object @ pocket.T_object_pocket, *pocket.size[1:])
            rectangles.append((opening, pose.width + extra))
    for corners, width in rectangles:
        for index in range(4):
            draw_segment(image, camera, corners[index], corners[(index + 1) % 4], pose.color, width)


def _rectangle(T_camera_face: Transform, width: float, height: float) -> Float[np.ndarray, "4 3"]:
    """Corners in the camera frame of an upright rectangle centred in the y-z plane of a frame that looks inwards."""
    corners = np.array([[0.0, y, z] for y, z in ((-1, -1), (1, -1), (1, 1), (-1, 1))])
    return transform_points(T_camera_face, corners * [0.0, width / 2.0, height / 2.0])


def _window(camera: PinholeCamera, info: ObjectInfo, poses: Sequence[Transform]) -> tuple[int, int, int, int]:
    """Return left, top, width and height (px) of a window of fixed shape around all poses; it may leave the image."""
    aspect = _CLOSE_UP_WH[0] / _CLOSE_UP_WH[1]
    pixels = np.concatenate([_outline(camera, info, pose) for pose in poses])
    low, high = pixels.min(axis=0), pixels.max(axis=0)
    centre, extent = (low + high) / 2.0, (high - low) * 1.35
    width = int(np.clip(max(extent[0], extent[1] * aspect), 120, 1.3 * camera.width))
    height = round(width / aspect)
    left, top = np.round(centre - np.array([width, height]) / 2.0).astype(int).tolist()
    return left, top, width, height


def _outline(camera: PinholeCamera, info: ObjectInfo, T_camera_object: Transform) -> Float[np.ndarray, "n 2"]:
    """Project the corners before the camera, clipped to the image so that a wild estimate cannot shrink the view."""
    corners = transform_points(T_camera_object, box_corners(info.size))
    corners = corners[corners[:, 2] > 0.2]
    if len(corners) == 0:
        return np.array([[camera.cx, camera.cy]])
    return np.clip(camera.project(corners), [0, 0], [camera.width - 1, camera.height - 1])


def _cut(rgb: Image, left: int, top: int, width: int, height: int) -> Image:
    canvas = np.empty((height, width, 3), np.uint8)
    canvas[:] = _BACKDROP
    rows = slice(max(0, top), min(rgb.shape[0], top + height))
    columns = slice(max(0, left), min(rgb.shape[1], left + width))
    canvas[rows.start - top : rows.stop - top, columns.start - left : columns.stop - left] = rgb[rows, columns]
    return canvas


def _resize(image: UInt8[np.ndarray, "h w 3"], width: int, height: int) -> Image:
    # Edges, not centres, are aligned by OpenCV's resize, as by PinholeCamera.crop.
    shrinks = width < image.shape[1]
    return cv2.resize(image, (width, height), interpolation=cv2.INTER_AREA if shrinks else cv2.INTER_CUBIC)
