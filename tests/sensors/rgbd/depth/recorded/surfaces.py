"""Single recorded depth images of two kinds of camera: how flat pieces of surface scatter, and simulated ones as far.

One image tells no noise over time and no pattern that stays, but their sum over small windows of flat surfaces.
"""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from jaxtyping import Bool, Float

from tests.sensors.rgbd.depth.planes import of_material, plane
from tests.sensors.rgbd.depth.recorded.statistics import row_of
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.sensors.rgbd.depth import PRESETS

Depth = Float[np.ndarray, "h w"]
WINDOW = 15
"""Edge of a window (px)."""
BINS = ((0.75, 1.0), (1.0, 1.25), (1.25, 1.5), (1.5, 1.75), (1.75, 2.0), (2.0, 2.25))
"""Depths that windows are put together by (m)."""
_LEAST = 12
"""Windows that a bin must have."""
LINEMOD_FOCAL = 572.4
"""Of LINEMOD's camera (px)."""


def surface_rows(folder: Path) -> list[dict[str, Any]]:
    """Return the rows of all single images that are in ``folder``.

    Raises:
        DatasetError: A file of an image is missing.
    """
    rows: list[dict[str, Any]] = []
    if (folder / "linemod_cat").is_dir():
        depth = _image(folder / "linemod_cat" / "depth.png") / 1000
        rows += _rows("kinect_v1", "linemod_cat", depth, LINEMOD_FOCAL, depth > 0, "white")
    if (folder / "boxes").is_dir():
        depth = _image(folder / "boxes" / "raw_depth.png") / 1000
        on_boxes = np.zeros(depth.shape, bool)
        for path in sorted((folder / "boxes").glob("small_box_mask_*.png")):
            on_boxes |= cv2.erode((_image(path) > 0).astype(np.uint8), np.ones((7, 7), np.uint8)) > 0
        intrinsics = json.loads((folder / "boxes" / "intrinsics.json").read_text(encoding="utf-8"))
        for preset in ("d435", "d455"):
            rows += _rows(preset, "boxes", depth, float(intrinsics["fx"]), on_boxes, "kraft")
    return rows


def _rows(
    preset: str, name: str, depth: Depth, focal_px: float, where: Bool[np.ndarray, "h w"], material: str
) -> list[dict[str, Any]]:
    """Return spread and likeness of neighbours for each distance at which there are enough windows."""
    windows = list(_windows(depth, focal_px, where))
    camera = PinholeCamera.from_focal(320, 240, focal_px)
    rows = []
    for low, high in BINS:
        here = [item for item in windows if low <= item[0] < high]
        if len(here) < _LEAST:
            continue
        z, angle_deg = (float(np.median([item[k] for item in here])) for k in (0, 1))
        buffers = plane(z, angle_deg, camera=camera)
        read = PRESETS[preset].read(buffers, of_material(material, camera), np.random.default_rng(0)).astype(float)
        simulated = list(_windows(np.rint(1000 * read) / 1000, focal_px, read > 0))
        for k, what in ((2, "spread about planes, mm"), (3, "noise alike at 2 px")):
            recorded = float(np.percentile([item[k] for item in here], 25))
            # A camera that reads no whole window there has a spread of nothing, which its residual shows.
            found = float(np.percentile([item[k] for item in simulated], 25)) if simulated else 0.0
            title = f"{preset}, {name}, {z:.2f} m, {angle_deg:.0f} deg, {len(here)} windows: {what}"
            rows.append(row_of(title, recorded, found))
    return rows


def _windows(
    depth: Depth, focal_px: float, where: Bool[np.ndarray, "h w"]
) -> Iterator[tuple[float, float, float, float]]:
    """Yield depth (m), angle of incidence (deg), spread (mm) and likeness at 2 px of windows that are read whole.

    The lower quartile of these is that of windows on flat surfaces, if a quarter is; 1 / z is linear on a plane.
    """
    height, width = depth.shape
    v, u = np.mgrid[0:WINDOW, 0:WINDOW] - WINDOW // 2
    a = np.column_stack([u.ravel(), v.ravel(), np.ones(u.size)])
    solve = np.linalg.pinv(a)
    for top in range(0, height - WINDOW, WINDOW):
        for left in range(0, width - WINDOW, WINDOW):
            piece = (slice(top, top + WINDOW), slice(left, left + WINDOW))
            z = depth[piece]
            if not where[piece].all() or (z <= 0).any() or np.ptp(z) > 0.2 * z.min():
                continue
            inverse = 1.0 / z.ravel()
            fit = solve @ inverse
            rest = ((a @ fit - inverse) / inverse**2).reshape(WINDOW, WINDOW)
            x, y = (left + WINDOW / 2 - width / 2) / focal_px, (top + WINDOW / 2 - height / 2) / focal_px
            normal = np.array(
                [fit[0] * focal_px, fit[1] * focal_px, fit[2] - fit[0] * focal_px * x - fit[1] * focal_px * y]
            )
            ray = np.array([x, y, 1.0])
            cosine = abs(normal @ ray) / np.linalg.norm(normal) / np.linalg.norm(ray)
            alike = float((rest[:, 2:] * rest[:, :-2]).mean() / max(float(rest.var()), 1e-12))
            yield 1.0 / float(fit[2]), float(np.rad2deg(np.arccos(min(cosine, 1.0)))), 1000 * float(rest.std()), alike


def _image(path: Path) -> np.ndarray:
    image = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    if image is None:
        raise DatasetError(f"{path}: missing or no image; the folder is not complete")
    return image.astype(float) if image.ndim == 2 else image[..., 0].astype(float)
