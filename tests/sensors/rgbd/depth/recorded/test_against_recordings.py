"""Recorded depth images against simulated ones of the same camera, place and kind of thing, by the same statistics.

The folder of recordings holds ``pallet_fronts/SITE`` (time of flight: ``labels.json``, ``NNN_depth.png``,
``NNN_mask.png``), ``linemod_cat`` (a Kinect v1: ``depth.png``, ``cat_mask.png``) and ``boxes`` (active stereo:
``raw_depth.png``, ``intrinsics.json``). A simulated front is a pallet of the catalog on the labelled floor before a
stack of cartons, not the recorded pallet before what stood there: differences of edges are those of the things, too.
"""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.result import RESULTS
from tests.sensors.rgbd.depth.recorded.recordings import recorded_faces
from tests.sensors.rgbd.depth.recorded.scenes import simulated_face
from tests.sensors.rgbd.depth.recorded.statistics import statistics_of
from tests.sensors.rgbd.depth.recorded.surfaces import surface_rows
from warehouse_sim.sensors.rgbd.depth import PRESETS
from warehouse_sim.sensors.rgbd.depth.time_of_flight import TimeOfFlight

FACE_PRESETS = ("tof_industrial", "flexx2", "azure_kinect")
"""Cameras of the recordings' kind; only the first one is meant to be theirs."""
UNITS = 3
"""Built cameras whose statistics are averaged: which unit was recorded is not known."""
MIRRORING = 1.15
"""A floor is taken for a mirror where it is read farther than it is by this factor before the front."""
STORED = {row["name"]: row for row in json.loads((RESULTS / "depth_against_real.json").read_text())["rows"]}


def compare(name: str, recorded: float, simulated: float) -> None:
    """Hold a statistic against the stored row: the residual that docs/sensors.md tells has not grown."""
    row = STORED[name]
    slack = 0.05 if "alike" in name else 4.0 if name.endswith("mm") else 6.0
    assert recorded == pytest.approx(row["recorded"], rel=2e-3, abs=2e-3), name
    assert abs(simulated - recorded) <= 1.2 * row["value"] + slack, name


@pytest.mark.gl
@pytest.mark.real
@pytest.mark.slow
@pytest.mark.parametrize("preset", FACE_PRESETS)
def test_pallet_faces_are_read_as_stored(preset: str, real_data: Path) -> None:
    for front in recorded_faces(real_data / "pallet_fronts"):
        recorded = statistics_of(front)
        mirrors = recorded.get("floor before the front at 0.6-1 m, %", 100.0) > 100.0 * MIRRORING
        model = PRESETS[preset]
        units = [replace(model, unit=unit) for unit in range(UNITS)] if isinstance(model, TimeOfFlight) else [model]
        found = [statistics_of(simulated_face(front, unit, mirrors, seed)) for seed, unit in enumerate(units)]
        for name, value in recorded.items():
            if simulated := [one[name] for one in found if name in one]:
                compare(f"{preset}, {front.name}: {name}", value, float(np.mean(simulated)))


@pytest.mark.real
@pytest.mark.slow
def test_single_images_scatter_as_stored(real_data: Path) -> None:
    rows = surface_rows(real_data)
    assert rows
    for row in rows:
        compare(row["name"], row["recorded"], row["simulated"])
