"""Draw the image of docs/frames.md: all coordinate frames in one scene.

python -m docs.figures.frames
"""

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.transforms import Bbox
from mpl_toolkits.mplot3d import Axes3D

OUT = Path(__file__).resolve().parents[1] / "images" / "frames.png"
COLOURS = ("#c62828", "#2e7d32", "#1565c0")
_PALLET, _TRUCK = (1.2, 0.8, 0.144), (1.6, 1.0, 1.1)
CAMERA_AXES = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
"""Columns: x right, y down and z forward of a camera that looks along the world's x."""


def frames() -> dict[str, tuple[np.ndarray, np.ndarray, tuple[str, str, str]]]:
    """Return origin (m, world), axes as columns, and what each axis is called, by the frame's name."""
    level = np.eye(3)
    return {
        "world": (np.array([-2.3, -2.2, 0.0]), level, ("x", "y", "z up")),
        "vehicle": (np.array([-1.2, 0.0, 0.0]), level, ("x forward", "y left", "z")),
        "LiDAR": (np.array([-1.0, 0.0, 1.75]), level, ("x forward", "y left", "z up")),
        "camera": (np.array([-0.2, 0.0, 1.2]), CAMERA_AXES, ("x right", "y down", "z forward")),
        "dock": (np.array([2.0, 0.0, 0.072]), level, ("x in", "y left", "z")),
        "object": (np.array([2.6, 0.0, 0.072]), level, ("x", "y", "z up")),
    }


def draw_frame(axes: Axes3D, name: str, length: float = 0.6) -> None:
    """Draw three arrows and their names."""
    origin, directions, called = frames()[name]
    for direction, colour, text in zip(directions.T, COLOURS, called, strict=True):
        end = origin + length * direction
        axes.plot(*zip(origin, end, strict=True), color=colour, linewidth=2.2)
        axes.text(*(origin + 1.15 * length * direction), text, color=colour, fontsize=8)
    below = 0.1 if name == "camera" else -0.24  # the camera's y points down
    axes.text(*(origin + np.array((0.0, 0.0, below))), name, fontsize=11, fontweight="bold")


def draw_box(axes: Axes3D, middle: tuple[float, float, float], size: tuple[float, float, float], colour: str) -> None:
    """Draw the edges of an upright box."""
    corners = np.array(middle) + 0.5 * np.array(size) * np.array(
        [[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    )
    for first in range(8):
        for bit in (1, 2, 4):
            if not first & bit:
                axes.plot(*zip(corners[first], corners[first | bit], strict=True), color=colour, linewidth=0.9)


def main() -> None:
    """Write the image."""
    figure = plt.figure(figsize=(15, 9), dpi=100)
    axes = figure.add_subplot(projection="3d", proj_type="persp")
    draw_box(axes, (-1.2 + 0.3, 0.0, _TRUCK[2] / 2), _TRUCK, "#8d6e63")
    draw_box(axes, (2.6, 0.0, _PALLET[2] / 2), _PALLET, "#a1662f")
    for name in frames():
        draw_frame(axes, name)
    axes.set_box_aspect((6.2, 4.2, 2.6))
    axes.set_xlim(-2.6, 3.6)
    axes.set_ylim(-2.1, 2.1)
    axes.set_zlim(0.0, 2.6)
    axes.view_init(elev=24, azim=-112)
    axes.set_axis_off()
    axes.set_position((0.0, 0.0, 1.0, 1.0))
    figure.savefig(OUT, bbox_inches=Bbox(((4.7, 1.3), (11.0, 5.9))))


if __name__ == "__main__":
    main()
