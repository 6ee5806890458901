"""Recorded depth images against simulated ones of the same camera, place and kind of thing, by the same statistics.

    python -m benchmarks.acceptance.depth_against_real FOLDER            # prints every statistic of every camera
    python -m benchmarks.acceptance.depth_against_real FOLDER --write    # and stores results/depth_against_real.json

FOLDER holds what there is of: ``pallet_fronts/SITE`` (time of flight: ``labels.json``, ``NNN_depth.png``,
``NNN_mask.png``), ``linemod_cat`` (a Kinect v1: ``depth.png``, ``cat_mask.png``) and ``boxes`` (an active stereo
camera: ``raw_depth.png``, ``intrinsics.json``). Recordings are read where they are and never stored.

Each row is one statistic of one place: recorded, simulated, and their difference (``value`` without its sign). None is
left out. A simulated front
is a pallet of the catalog on the labelled floor before a stack of cartons, not the recorded pallet before what stood
there: differences of edges and bends are those of the things, too.
"""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import tyro

from benchmarks.acceptance.depth_recordings import recorded_faces
from benchmarks.acceptance.depth_scenes import simulated_face
from benchmarks.acceptance.depth_statistics import row_of, statistics_of
from benchmarks.acceptance.depth_surfaces import surface_rows
from benchmarks.result import RESULTS, rounded, write_result
from warehouse_sim.errors import DatasetError
from warehouse_sim.sensors.rgbd.depth import PRESETS
from warehouse_sim.sensors.rgbd.depth.flight.time_of_flight import TimeOfFlight

FACE_PRESETS = ("tof_industrial", "flexx2", "azure_kinect")
"""Cameras of the recordings' kind; only the first one is meant to be theirs."""
UNITS = 3
"""Built cameras whose statistics are averaged: which unit was recorded is not known."""
MIRRORING = 1.15
"""A floor is taken for a mirror where it is read farther than it is by this factor before the front."""


def main(folder: tyro.conf.Positional[Path], presets: tuple[str, ...] = FACE_PRESETS, write: bool = False) -> None:
    """Compare.

    Args:
        folder: Of the recordings.
        presets: Cameras that are compared with the recorded pallet faces.
        write: Whether to store the result.
    """
    rows = _face_rows(folder / "pallet_fronts", presets) if (folder / "pallet_fronts").is_dir() else []
    rows += surface_rows(folder)
    if not rows:
        raise DatasetError(f"{folder}: no pallet_fronts, linemod_cat or boxes in it; name the folder that holds them")
    for row in rows:
        print(f"{row['name']:<78} {row['recorded']:>8.4g} {row['simulated']:>8.4g} {row['residual']:>+8.3g}")
    if write:
        command = "python -m benchmarks.acceptance.depth_against_real FOLDER --write"
        write_result(RESULTS / "depth_against_real.json", command, rounded(rows))


def _face_rows(folder: Path, presets: tuple[str, ...]) -> list[dict[str, Any]]:
    rows = []
    for front in recorded_faces(folder):
        recorded = statistics_of(front)
        mirrors = recorded.get("floor before the front at 0.6-1 m, %", 100.0) > 100.0 * MIRRORING
        for preset in presets:
            model = PRESETS[preset]
            units = [replace(model, unit=unit) for unit in range(UNITS)] if isinstance(model, TimeOfFlight) else [model]
            found = [statistics_of(simulated_face(front, unit, mirrors, seed)) for seed, unit in enumerate(units)]
            for name, value in recorded.items():
                simulated = [one[name] for one in found if name in one]
                if simulated:
                    rows.append(row_of(f"{preset}, {front.name}: {name}", value, float(np.mean(simulated))))
    return rows


if __name__ == "__main__":
    tyro.cli(main, description=__doc__)
