"""Recorded pallet faces, read from a folder of sites."""

import json
from pathlib import Path

import cv2
import numpy as np

from tests.sensors.rgbd.depth.recorded.statistics import Face
from warehouse_sim.errors import DatasetError


def recorded_faces(folder: Path) -> list[Face]:
    """Return one front for each site, that is a folder with ``labels.json``, ``NNN_depth.png`` and ``NNN_mask.png``.

    Raises:
        DatasetError: There is no site, or a file of one is missing.
    """
    sites = sorted(path.parent for path in folder.glob("*/labels.json"))
    if not sites:
        raise DatasetError(f"{folder}: no SITE/labels.json in it; name the folder that holds the recorded sites")
    return [_site(path) for path in sites]


def _site(path: Path) -> Face:
    labels = json.loads((path / "labels.json").read_text(encoding="utf-8"))
    frames = labels["frames"]
    first = frames[0]
    K = np.array(labels["K"])
    dock = np.array(first["T_camera_dock"])
    down = np.array(first["gravity"])
    # Where the floor's distance could not be labelled, the pallet's lower edge tells it.
    floor = first["floor_distance_m"] or _lower_edge(np.array(first["front_corners_px"]), K, dock, down)
    return Face(
        name=path.name,
        K=K,
        depths=tuple(_image(path / frame["depth"]).astype(float) / 1000 for frame in frames),
        docks=tuple(np.array(frame["T_camera_dock"]) for frame in frames),
        outline_px=np.array(first["front_corners_px"]),
        pockets_px=(np.array(first["pocket_left_px"]), np.array(first["pocket_right_px"])),
        mask=_image(path / first["mask"]) > 0,
        down=down,
        floor_distance=float(floor),
    )


def _lower_edge(corners: np.ndarray, K: np.ndarray, dock: np.ndarray, down: np.ndarray) -> float:
    """Return how far below the camera the front's lower corners are (m)."""
    rays = np.column_stack([corners[2:], np.ones(2)]) @ np.linalg.inv(K).T
    z = (dock[:3, 3] @ dock[:3, 0]) / (rays @ dock[:3, 0])
    return float(((rays * z[:, None]) @ down).mean())


def _image(path: Path) -> np.ndarray:
    image = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    if image is None:
        raise DatasetError(f"{path}: missing or no image; the folder is not complete")
    return image
