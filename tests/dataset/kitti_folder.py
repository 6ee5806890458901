"""A small KITTI folder as KITTI distributes them, written by hand: boxes on a road, seen by camera and LiDAR."""

from dataclasses import dataclass, field
from pathlib import Path

import cv2
import numpy as np

WIDTH, HEIGHT = 320, 96
K = np.array([[180.0, 0.0, 158.5], [0.0, 180.0, 44.0], [0.0, 0.0, 1.0]])
BESIDE = np.array([0.0598, -0.0004, 0.0027])
"""Of the rectified frame's origin in camera 2, about as in KITTI (m)."""
CAMERA_HEIGHT = 1.65
SIZES = {"Car": (1.5, 1.6, 3.9), "Pedestrian": (1.75, 0.65, 0.85), "Kiosk": (2.2, 1.2, 1.4)}
"""Height, width, length (m)."""


def turned(axis: int, angle: float) -> np.ndarray:
    """Return a rotation about an axis (rad)."""
    c, s = np.cos(angle), np.sin(angle)
    R = np.eye(3)
    i, j = [k for k in range(3) if k != axis]
    R[i, i], R[j, j], R[i, j], R[j, i] = c, c, -s, s
    return R


R0 = turned(0, 0.004) @ turned(1, -0.007)
R_CAM_VELO = turned(2, 0.003) @ np.array([[0.0, -1, 0], [0, 0, -1], [1, 0, 0]])
T_CAM_VELO = np.array([-0.004, -0.076, -0.272])


@dataclass
class Thing:
    """A labelled box in the rectified frame."""

    kind: str
    x: float
    z: float
    heading: float
    size: tuple[float, float, float] = field(init=False)

    def __post_init__(self) -> None:
        self.size = SIZES[self.kind]

    def corners(self) -> np.ndarray:
        h, w, le = self.size
        box = np.array([[x, y, z] for x in (-le / 2, le / 2) for y in (0, -h) for z in (-w / 2, w / 2)])
        return self.placed(box)

    def placed(self, points: np.ndarray) -> np.ndarray:
        """Move points of the box's frame (x length, y down from the bottom, z width) to the rectified frame."""
        c, s = np.cos(self.heading), np.sin(self.heading)
        R = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
        return points @ R.T + [self.x, CAMERA_HEIGHT, self.z]

    def surface(self, count: int, rng: np.random.Generator) -> np.ndarray:
        """Draw points on those sides that face the origin, a little inside the box, as labels are rounded."""
        h, w, le = self.size
        half = np.array([le / 2, h / 2, w / 2])
        points, sides = rng.uniform(-1, 1, (12 * count, 3)), rng.integers(0, 6, 12 * count)
        points[np.arange(12 * count), sides // 2] = np.where(sides % 2, 1.0, -1.0)
        normals = np.zeros_like(points)
        normals[np.arange(12 * count), sides // 2] = points[np.arange(12 * count), sides // 2]
        centre = np.array([0.0, -h / 2, 0.0])
        placed = self.placed(0.98 * points * half + centre)
        outward = self.placed(normals) - self.placed(np.zeros((1, 3)))
        return placed[(outward * placed).sum(axis=1) < 0][:count]

    def box_2d(self) -> np.ndarray:
        pixels = project(self.corners())
        return np.clip(np.concatenate([pixels.min(0), pixels.max(0)]), 0, [WIDTH - 1, HEIGHT - 1] * 2)

    def row(self) -> str:
        numbers = [*self.box_2d(), *self.size, self.x, CAMERA_HEIGHT, self.z, self.heading]
        alpha = self.heading - np.arctan2(self.x, self.z)
        return f"{self.kind} 0.00 0 {alpha:.2f} " + " ".join(f"{value:.2f}" for value in numbers)


DONT_CARE = "DontCare -1 -1 -10 10.00 20.00 30.00 40.00 -1 -1 -1 -1000 -1000 -1000 -10"


def project(points_rect: np.ndarray) -> np.ndarray:
    """Project points of the rectified frame (m) into image 2."""
    pixels = (points_rect + BESIDE) @ K.T
    return pixels[:, :2] / pixels[:, 2:]


def to_velodyne(points_rect: np.ndarray) -> np.ndarray:
    return (points_rect @ R0 - T_CAM_VELO) @ R_CAM_VELO


def calib_lines() -> str:
    """Return a calib file in KITTI's own notation, with the blank line at its end."""
    P = np.hstack([K, (K @ BESIDE)[:, None]])
    velo = np.hstack([R_CAM_VELO, T_CAM_VELO[:, None]])
    rows = {f"P{number}": P for number in range(4)} | {"R0_rect": R0, "Tr_velo_to_cam": velo}
    rows["Tr_imu_to_velo"] = np.eye(4)[:3]
    return "".join(f"{key}: {' '.join(f'{v:.12e}' for v in rows[key].ravel())}\n" for key in rows) + "\n"


def write_frame(folder: Path, frame: int, things: list[Thing], seed: int, points_each: int = 300) -> np.ndarray:
    """Write one frame and return its sweep in the rectified frame; without things it has no label file."""
    rng = np.random.default_rng([seed, frame])
    for kind in ("image_2", "velodyne", "calib", "label_2"):
        (folder / kind).mkdir(parents=True, exist_ok=True)
    below = np.full(3000, CAMERA_HEIGHT + 0.02)  # so that no point is on the border of a box
    road = np.stack([rng.uniform(-15, 15, 3000), below, rng.uniform(3, 40, 3000)], axis=1)
    cloud = np.concatenate([road, *(thing.surface(points_each, rng) for thing in things)])
    image = rng.integers(90, 130, (HEIGHT, WIDTH, 3)).astype(np.uint8)
    for thing in sorted(things, key=lambda item: -item.z):
        hull = cv2.convexHull(project(thing.corners()).astype(np.float32)).astype(np.int32)
        cv2.fillConvexPoly(image, hull, (40, 60, 200) if thing.kind == "Car" else (60, 180, 60))
    cv2.imwrite(str(folder / "image_2" / f"{frame:06d}.png"), image)
    rows = np.hstack([to_velodyne(cloud), rng.uniform(0, 1, (len(cloud), 1))])
    (folder / "velodyne" / f"{frame:06d}.bin").write_bytes(rows.astype("<f4").tobytes())
    (folder / "calib" / f"{frame:06d}.txt").write_text(calib_lines())
    if things:
        text = "".join(f"{thing.row()}\n" for thing in things) + f"{DONT_CARE}\n\n"
        (folder / "label_2" / f"{frame:06d}.txt").write_text(text)
    return cloud


def street(frame: int, seed: int) -> list[Thing]:
    """Draw two cars and a pedestrian that stand apart."""
    rng = np.random.default_rng([seed, frame, 1])
    places = [(-3.0, 9.0, "Car"), (3.0, 10.0, "Car"), (0.0, 7.0, "Pedestrian")]
    return [
        Thing(kind, round(x + rng.uniform(-0.5, 0.5), 2), round(z + rng.uniform(-1, 1), 2), _heading(rng))
        for x, z, kind in places
    ]


def _heading(rng: np.random.Generator) -> float:
    return round(float(rng.uniform(-2.0, -1.1)), 2)


def write_street(root: Path, frames: int, testing: int = 0, seed: int = 5) -> Path:
    """Write labelled frames into training and frames without labels into testing."""
    for frame in range(frames):
        write_frame(root / "training", frame, street(frame, seed), seed)
    for frame in range(testing):
        write_frame(root / "testing", frame, [], seed + 1)
    return root
