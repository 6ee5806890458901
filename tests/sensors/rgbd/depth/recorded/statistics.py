"""What a depth camera makes of pallet faces, in numbers: the same code for recordings and for simulated frames."""

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from jaxtyping import Bool, Float

Depth = Float[np.ndarray, "h w"]
DISTANCES = (0.5, 1.0, 1.5, 2.0)
"""Depths at which the spread over time is given (m), each within 0.1 m."""
OFF = 0.060
"""Pixels of a rim that are farther off the front's plane did not read the front (m)."""
_ROBUST = 1.4826
"""From the median absolute deviation to the standard deviation of a Gaussian."""
_STILL = 0.010
"""Between frames of a camera at rest the labelled front moves by less (m)."""


@dataclass(frozen=True, eq=False)
class Face:
    """Frames of one pallet face from one place."""

    name: str
    K: Float[np.ndarray, "3 3"]
    depths: tuple[Depth, ...]
    """Along the optical axis (m), 0 = none."""
    docks: tuple[Float[np.ndarray, "4 4"], ...]
    """``T_camera_dock`` of each frame: x into the pallet, y to the left, z up."""
    outline_px: Float[np.ndarray, "4 2"]
    pockets_px: tuple[Float[np.ndarray, "4 2"], ...]
    mask: Bool[np.ndarray, "h w"]
    """Pixels that show the pallet."""
    down: Float[np.ndarray, " 3"]
    floor_distance: float
    """From the camera down to the floor (m)."""

    @property
    def rays(self) -> Float[np.ndarray, "h w 3"]:
        """Return each pixel's point at z = 1."""
        height, width = self.mask.shape
        u, v = np.meshgrid(np.arange(width), np.arange(height))
        return np.stack(
            [(u - self.K[0, 2]) / self.K[0, 0], (v - self.K[1, 2]) / self.K[1, 1], np.ones(u.shape)], axis=-1
        )

    @property
    def face(self) -> Bool[np.ndarray, "h w"]:
        """Return the pixels of the front itself, without its pockets."""
        sampled = np.zeros(self.mask.shape, np.uint8)
        cv2.fillPoly(sampled, [np.rint(self.outline_px).astype(np.int32)], 1)
        for pocket in self.pockets_px:
            cv2.fillPoly(sampled, [np.rint(pocket).astype(np.int32)], 0)
        return (sampled > 0) & self.mask


def statistics_of(front: Face) -> dict[str, float]:
    """Return all statistics that the frames allow; each name tells its unit."""
    return {
        **_over_time(front),
        **_alike(front),
        **_scatter(front),
        **_edges(front),
        **_by_angle(front),
        **_on_the_floor(front),
    }


def row_of(name: str, recorded: float, simulated: float) -> dict[str, Any]:
    """Return a row of the table; ``value`` is the residual without its sign."""
    residual = simulated - recorded
    row = {"name": name, "value": abs(residual), "recorded": recorded, "simulated": simulated}
    return row | {"residual": residual}


def _pairs(front: Face) -> list[tuple[Depth, Depth]]:
    places = [dock[:3, 3] for dock in front.docks]
    return [
        (front.depths[i], front.depths[i + 1])
        for i in range(len(places) - 1)
        if np.linalg.norm(places[i + 1] - places[i]) < _STILL
    ]


def _over_time(front: Face) -> dict[str, float]:
    found: dict[str, list[float]] = {}
    for one, other in _pairs(front):
        for z in DISTANCES:
            near = (np.abs(one - z) < 0.1) & (other > 0) & (np.abs(other - one) < 0.15)
            if near.sum() > 500:
                found.setdefault(f"sigma over time at {z:g} m, mm", []).append(
                    _spread((other - one)[near]) / np.sqrt(2)
                )
    return {name: 1000 * float(np.mean(values)) for name, values in found.items()}


def _alike(front: Face) -> dict[str, float]:
    """Return how alike the noise over time of neighbours is, on the front and on what is about as far."""
    fractions: dict[int, list[float]] = {1: [], 2: [], 3: []}
    for one, other in _pairs(front):
        good = (one > 0.8) & (one < 2.2) & (other > 0) & (np.abs(other - one) < 0.1)
        step = np.where(good, other - one, 0.0)
        count = cv2.blur(good.astype(float), (31, 31))
        step = np.where(good, step - cv2.blur(step, (31, 31)) / np.maximum(count, 1e-6), 0.0)
        for lag, found in fractions.items():
            both = good[:, lag:] & good[:, :-lag]
            a, b = step[:, lag:][both], step[:, :-lag][both]
            found.append(float((a * b).mean() / np.sqrt((a * a).mean() * (b * b).mean())))
    return {f"noise alike at {lag} px": float(np.mean(found)) for lag, found in fractions.items() if found}


def _off_plane(front: Face, index: int) -> tuple[Depth, Bool[np.ndarray, "h w"]]:
    """Return the deviation from the front's own plane (m), and the inner pixels of the front that were read."""
    depth, dock = front.depths[index], front.docks[index]
    expected = (dock[:3, 3] @ dock[:3, 0]) / (front.rays @ dock[:3, 0])
    off = depth - expected
    inner = cv2.erode(front.face.astype(np.uint8), np.ones((7, 7), np.uint8)) > 0
    inner &= (depth > 0) & (np.abs(off) < 0.2)
    return off, inner


def _scatter(front: Face) -> dict[str, float]:
    rays = front.rays
    spreads, offs = [], []
    for index in range(len(front.depths)):
        off, inner = _off_plane(front, index)
        a = rays[inner]
        kept = np.ones(len(a), bool)
        for _ in range(3):
            fit = np.linalg.lstsq(a[kept], off[inner][kept], rcond=None)[0]
            rest = off[inner] - a @ fit
            kept = np.abs(rest) < 2.5 * _spread(rest)
        spreads.append(_spread(rest))
        offs.append(np.where(inner, off - rays @ fit, np.nan))
    result = {"front: spread about its plane, mm": 1000 * float(np.mean(spreads))}
    still = _still_frames(front)
    if len(still) > 1:
        stack = np.stack([offs[index] for index in still])
        seen = np.isfinite(stack).all(axis=0)
        mean, moving = stack[:, seen].mean(axis=0), stack[:, seen].std(axis=0, ddof=1)
        left = _spread(mean) ** 2 - float(np.median(moving) ** 2) / len(still)
        result["front: fixed pattern, mm"] = 1000 * float(np.sqrt(max(left, 0.0)))
    return result


def _still_frames(front: Face) -> list[int]:
    """Return the longest run of frames in which the front stays where it is."""
    runs = [[0]]
    for index in range(1, len(front.docks)):
        moved = np.linalg.norm(front.docks[index][:3, 3] - front.docks[index - 1][:3, 3])
        if moved < _STILL:
            runs[-1].append(index)
        else:
            runs.append([index])
    return max(runs, key=len)


def _edges(front: Face) -> dict[str, float]:
    face = front.face.astype(np.uint8)
    rim = front.face & (cv2.erode(face, np.ones((5, 5), np.uint8)) == 0)
    near = front.face & (cv2.erode(face, np.ones((7, 7), np.uint8)) == 0)
    wide, invalid = [], []
    for depth, dock in zip(front.depths, front.docks, strict=True):
        expected = (dock[:3, 3] @ dock[:3, 0]) / (front.rays @ dock[:3, 0])
        read = rim & (depth > 0)
        wide.append((np.abs(depth - expected)[read] > OFF).sum() / max(int(read.sum()), 1))
        invalid.append((depth[near] == 0).mean())
    return {
        "rim pixels off by more than 60 mm, %": 100 * float(np.mean(wide)),
        "invalid within 3 px of edges, %": 100 * float(np.mean(invalid)),
    }


def _by_angle(front: Face) -> dict[str, float]:
    """Return the front's median deviation by angle of incidence, against that of the whole front."""
    found: dict[str, list[float]] = {}
    for index, dock in enumerate(front.docks):
        off, inner = _off_plane(front, index)
        rays = front.rays[inner]
        angle = np.rad2deg(np.arccos(np.clip(rays @ dock[:3, 0] / np.linalg.norm(rays, axis=1), -1, 1)))
        for low in range(0, 40, 5):
            here = (angle >= low) & (angle < low + 5)
            if here.sum() > 150:
                value = np.median(off[inner][here]) - np.median(off[inner])
                found.setdefault(f"front: bend at {low}-{low + 5} deg, mm", []).append(float(value))
    return {name: 1000 * float(np.mean(values)) for name, values in found.items()}


def _on_the_floor(front: Face) -> dict[str, float]:
    """Return the read depth of the floor over the true one, before the front and beside it, in percent."""
    result: dict[str, float] = {}
    slope = front.rays @ front.down
    floor = front.floor_distance / np.maximum(slope, 1e-6)
    dock = front.docks[0]
    expected = (dock[:3, 3] @ dock[:3, 0]) / (front.rays @ dock[:3, 0])
    columns = np.arange(front.mask.shape[1])
    before = (columns > front.outline_px[:, 0].min() + 10) & (columns < front.outline_px[:, 0].max() - 10)
    free = (slope > 0.02) & ~cv2.dilate(front.mask.astype(np.uint8), np.ones((9, 9), np.uint8)).astype(bool)
    free &= floor < expected - 0.05
    for name, where in (("before the front", before), ("beside it", ~before)):
        for low, high in ((0.3, 0.6), (0.6, 1.0), (1.0, 1.5)):
            here = free & where[None, :] & (floor >= low) & (floor < high) & (front.depths[0] > 0)
            if here.sum() > 200:
                result[f"floor {name} at {low:g}-{high:g} m, %"] = 100 * float(
                    np.median(front.depths[0][here] / floor[here])
                )
    return result


def _spread(values: Float[np.ndarray, " n"]) -> float:
    """Return the standard deviation that the median absolute deviation stands for."""
    return float(_ROBUST * np.median(np.abs(values - np.median(values))))
