"""The development kit's own evaluation (C++) scores the same files; the numbers must be ours to four digits.

WAREHOUSE_SIM_KITTI_EVAL names the program, for example ``evaluate_object_3d_offline.cpp`` of CenterNet's
``src/tools/kitti_eval`` with ``MIN_OVERLAP`` of 0.7 for cars and 0.5 for others in all three views, built with
``g++ -O1 -fpermissive`` and Boost's headers. Plots fail without gnuplot, the numbers are written before.
"""

import os
import subprocess
from pathlib import Path

import numpy as np
import pytest

from tests.evaluation.detection.test_kitti_ap import line
from warehouse_sim.dataset.formats.kitti.reader import KittiLabel
from warehouse_sim.dataset.formats.kitti.tolerant import read_labels
from warehouse_sim.evaluation.detection.kitti_ap import LEVELS, kitti_scores
from warehouse_sim.evaluation.detection.kitti_overlap import KittiObjects

pytestmark = pytest.mark.ecosystem

FRAMES = 40


@pytest.fixture(scope="module")
def program() -> Path:
    path = os.environ.get("WAREHOUSE_SIM_KITTI_EVAL")
    if not path or not Path(path).is_file():
        pytest.skip("WAREHOUSE_SIM_KITTI_EVAL names no build of KITTI's evaluate_object")
    return Path(path).absolute()


def sampled(rng: np.random.Generator) -> KittiLabel:
    name = str(
        rng.choice(
            ["Car", "Van", "Pedestrian", "Person_sitting", "Cyclist", "Tram"], p=[0.35, 0.1, 0.3, 0.1, 0.1, 0.05]
        )
    )
    left, top = rng.uniform(0, 900), rng.uniform(50, 200)
    box = (left, top, left + rng.uniform(20, 150), top + rng.uniform(15, 120))
    size, place = rng.uniform(0.5, 3, 3), (rng.uniform(-8, 8), rng.uniform(1, 2), rng.uniform(4, 30))
    occluded, truncated = int(rng.integers(0, 4)), round(float(rng.choice([0.0, 0.0, 0.1, 0.4])), 2)
    return KittiLabel(name, truncated, occluded, rng.uniform(-3, 3), box, tuple(size), place, rng.uniform(-3, 3))


def shaken(label: KittiLabel, rng: np.random.Generator) -> KittiLabel:
    much = rng.choice([0.0, 0.02, 0.08])

    def off(values, unit):
        return tuple(value + unit * much * rng.normal() for value in values)

    name = label.type if rng.random() < 0.9 else "Car"
    alpha, heading = label.alpha + 3 * much * rng.normal(), label.rotation_y + much * rng.normal()
    return KittiLabel(
        name, -1, -1, alpha, off(label.box_xyxy, 50), off(label.size_hwl, 0.5), off(label.location, 1.0), heading
    )


def write(path: Path, rows: list[str]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("".join(f"{row}\n" for row in rows))


@pytest.mark.parametrize("seed", [0, 1])
def test_all_curves_are_those_of_the_development_kit(tmp_path: Path, program: Path, seed: int) -> None:
    rng = np.random.default_rng(seed)
    for frame in range(FRAMES):
        gt = [sampled(rng) for _ in range(rng.integers(3, 14))]
        found = [shaken(item, rng) for item in gt if rng.random() < 0.85]
        found += [shaken(item, rng) for item in gt if rng.random() < 0.2] + [sampled(rng) for _ in range(3)]
        left = rng.uniform(0, 700)
        region = KittiLabel("DontCare", -1, -1, -10, (left, 40, left + 300, 300), (-1, -1, -1), (-1000,) * 3, -10)
        write(tmp_path / "labels" / f"{frame:06d}.txt", [line(item) for item in [*gt, region]])
        rows = [line(item, round(float(rng.random()), 2)) for item in found]
        write(tmp_path / "results" / "data" / f"{frame:06d}.txt", rows)
    command = [str(program), str(tmp_path / "labels"), f"{tmp_path}/results/data/"]
    subprocess.run(command, capture_output=True, timeout=200, check=False)
    names = [f"{frame:06d}.txt" for frame in range(FRAMES)]
    gt, found = [], []
    for name in names:
        gt.append(KittiObjects.of(read_labels((tmp_path / "labels" / name).read_text(), name)))
        text = (tmp_path / "results" / "data" / name).read_text()
        scores = [float(row.split()[15]) for row in text.splitlines()]
        found.append(KittiObjects.of(read_labels(text, name), scores))
    ours = kitti_scores(gt, found, {"Car": 0.7, "Pedestrian": 0.5, "Cyclist": 0.5})
    assert len(ours) == 27
    ending = {"image": "detection", "ground": "detection_ground", "space": "detection_3d"}
    for row in ours:
        theirs = curve(tmp_path, f"{row.class_name.lower()}_{ending[row.view]}", row.level)
        assert row.ap_40 == pytest.approx(theirs[1:].mean(), abs=5e-7)
        assert row.ap_11 == pytest.approx(theirs[::4].mean(), abs=5e-7)
        if row.view == "image":
            turn = curve(tmp_path, f"{row.class_name.lower()}_orientation", row.level)
            assert row.aos_40 == pytest.approx(turn[1:].mean(), abs=5e-7)
            assert row.aos_11 == pytest.approx(turn[::4].mean(), abs=5e-7)
    assert 0.05 < ours[0].ap_40 < 0.95


def curve(folder: Path, name: str, level: str) -> np.ndarray:
    """Return the 41 values that the program plots."""
    table = np.loadtxt(folder / "results" / "data" / ".." / "plot" / f"{name}.txt")
    return table[:, 1 + LEVELS.index(level)]
