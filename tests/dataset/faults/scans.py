"""Faults of LiDAR sweeps and of their calibration."""

import numpy as np

from tests.dataset.faults.folder import Folder, View, edit_calib, edit_numbers, exchange


def edit_points(view: View, change) -> None:
    edit_numbers(view.kitti("velodyne", "bin"), "<f4", 4, change)


def points_in_millimetres(folder: Folder) -> None:
    edit_points(folder.view(), lambda points: points * [1e3, 1e3, 1e3, 1])


def points_in_camera_axes(folder: Folder) -> None:
    edit_points(folder.view(), lambda points: points[:, [1, 2, 0, 3]] * [-1, -1, 1, 1])


def not_a_number(folder: Folder) -> None:
    def on(points: np.ndarray) -> np.ndarray:
        points[folder.rng.integers(len(points)), folder.rng.integers(4)] = np.nan
        return points

    edit_points(folder.view(), on)


def intensities_of_bytes(folder: Folder) -> None:
    edit_points(folder.view(), lambda points: points * [1, 1, 1, 255])


def sweep_of_zeros(folder: Folder) -> None:
    edit_points(folder.view(), np.zeros_like)


def ids_shuffled(folder: Folder) -> None:
    edit_numbers(folder.view().kitti("velodyne_ids", "bin"), "<i4", 1, lambda ids: folder.rng.permutation(ids))


def calibration_inverted(folder: Folder) -> None:
    view = folder.view()
    edit_calib(view, "Tr_velo_to_cam", lambda T: np.linalg.inv(np.vstack([T, [0, 0, 0, 1]]))[:3])


def sweep_of_another_frame(folder: Folder) -> None:
    first, second = folder.rng.choice(len(folder.views()), 2, replace=False)
    for kind in ("velodyne", "velodyne_ids", "velodyne_beams"):
        exchange(folder.views()[first].kitti(kind, "bin"), folder.views()[second].kitti(kind, "bin"))


def left_and_right_exchanged(folder: Folder) -> None:
    edit_points(folder.view(), lambda points: points * [1, -1, 1, 1])
