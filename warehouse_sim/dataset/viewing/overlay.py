"""Draw labels on images, for people: boxes in space, colours of ids and depth, captions."""

from itertools import pairwise

import cv2
import numpy as np
from jaxtyping import Bool, Float, Int, UInt8

from warehouse_sim.geometry.boxes import box_corners, box_edges
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform, transform_points

Image = UInt8[np.ndarray, "h w 3"]
Color = tuple[int, int, int]

_NEAR = 0.05
"""Edges are cut at this depth (m); what is behind the camera has no projection."""
_NEAR_CLOUD = 0.1
"""Points of a cloud are drawn from this depth on (m)."""
_SUBPIXEL_BITS = 4
_PIECES = 24
"""Straight pieces that a line behind a lens is drawn with."""


def draw_box_3d(
    image: Image,
    camera: PinholeCamera,
    T_camera_object: Transform,
    size: Float[np.ndarray, " 3"],
    color: Color,
    width: int = 1,
) -> None:
    """Draw the edges of an object's box into ``image``.

    Args:
        image: RGB image, changed in place.
        camera: Intrinsics of the image.
        T_camera_object: Pose of the box's centre frame.
        size: Edge lengths (m).
        color: RGB, 0-255.
        width: Line width in pixels.
    """
    corners = transform_points(T_camera_object, box_corners(size))
    for a, b in box_edges():
        draw_segment(image, camera, corners[a], corners[b], color, width)


def draw_segment(
    image: Image,
    camera: PinholeCamera,
    start: Float[np.ndarray, " 3"],
    end: Float[np.ndarray, " 3"],
    color: Color,
    width: int = 1,
) -> None:
    """Draw a straight line between two camera-frame points (m), cut at the near plane."""
    pixels = segment_pixels(camera, start, end)
    if pixels is not None:
        places = np.round(pixels * (1 << _SUBPIXEL_BITS)).astype(int).tolist()
        for p, q in pairwise(places):
            cv2.line(image, p, q, color, width, cv2.LINE_AA, _SUBPIXEL_BITS)


def segment_pixels(
    camera: PinholeCamera, start: Float[np.ndarray, " 3"], end: Float[np.ndarray, " 3"]
) -> Float[np.ndarray, "n 2"] | None:
    """Return the pixels of a straight line between two camera-frame points (m), cut at the near plane; None behind it.

    Without a lens these are its two ends, with one the ends of the pieces that it is drawn with.
    """
    if start[2] < end[2]:
        start, end = end, start
    if start[2] <= _NEAR:
        return None
    if end[2] < _NEAR:
        end = start + (end - start) * (start[2] - _NEAR) / (start[2] - end[2])
    ends = np.stack([start, end])
    if camera.distortion is not None:
        # Straight in the pinhole's image, curved in this one.
        fraction = np.linspace(0.0, 1.0, _PIECES + 1)[:, None]
        tangents = ends[:, :2] / ends[:, 2:]
        ends = np.column_stack([tangents[0] + fraction * (tangents[1] - tangents[0]), np.ones(len(fraction))])
    return np.clip(camera.project(ends), -1e5, 1e5)


def colorize_instances(instance_mask: Int[np.ndarray, "h w"]) -> Image:
    """Give each instance id a colour of its own by the golden angle of hue; background is black."""
    ids = np.arange(int(instance_mask.max(initial=0)) + 1)
    hsv = np.stack([ids * 137.508 % 180, 110 + ids * 53 % 120, 150 + ids * 31 % 100], axis=-1).astype(np.uint8)
    palette = cv2.cvtColor(hsv[None], cv2.COLOR_HSV2RGB)[0]
    palette[0] = 0
    return palette[instance_mask]


def colorize_depth(depth: Float[np.ndarray, "h w"], nearest: float = 0.5, farthest: float = 20.0) -> Image:
    """Colour z-depth (m) on a logarithmic scale, near is warm; no reading is black."""
    valid: Bool[np.ndarray, "h w"] = depth > 0
    scaled = np.log(np.clip(np.where(valid, depth, farthest), nearest, farthest) / nearest) / np.log(farthest / nearest)
    # A table, since OpenCV divides by the number of pixels and ends the process where there are none.
    levels = np.arange(256, dtype=np.uint8)[None]
    table = cv2.cvtColor(cv2.applyColorMap(levels, cv2.COLORMAP_TURBO), cv2.COLOR_BGR2RGB)[0]
    colors = table[(255 * (1 - scaled)).astype(np.uint8)]
    colors[~valid] = 0
    return colors


def draw_caption(image: Image, text: str) -> None:
    """Write ``text`` on a dark band at the image's top left, in place."""
    (width, height), _ = cv2.getTextSize(text, cv2.FONT_HERSHEY_SIMPLEX, 0.6, 1)
    cv2.rectangle(image, (0, 0), (width + 16, height + 14), (24, 24, 24), -1)
    cv2.putText(image, text, (8, height + 7), cv2.FONT_HERSHEY_SIMPLEX, 0.6, (255, 255, 255), 1, cv2.LINE_AA)


def draw_cloud(rgb: Image, camera: PinholeCamera, T_camera_lidar: Transform, points: Float[np.ndarray, "n 3"]) -> Image:
    """Return the image in the dark with a dot at each point that lies in it, near is warm.

    Args:
        rgb: Colour image.
        camera: Intrinsics of the image.
        T_camera_lidar: Pose of the LiDAR in the camera frame.
        points: In the frame of the LiDAR (m).
    """
    image = (rgb * 0.45).astype(np.uint8)
    seen = transform_points(T_camera_lidar, points.astype(float))
    seen = seen[seen[:, 2] > _NEAR_CLOUD]
    pixels = np.round(camera.project(seen)).astype(int)
    inside = ((pixels >= 0) & (pixels < [camera.width, camera.height])).all(axis=1)
    colors = colorize_depth(seen[inside, 2][None])[0]
    for (u, v), color in zip(pixels[inside].tolist(), colors.tolist(), strict=True):
        cv2.circle(image, (u, v), 1, color, -1)
    return image
