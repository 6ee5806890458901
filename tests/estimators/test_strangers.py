"""Estimators, detectors and segmenters of another package, found by its entry points alone."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

STRANGER = '''
import numpy as np
from scipy import ndimage
from warehouse_sim.estimators.image import Detection
from warehouse_sim.geometry.pose import transform_points
from warehouse_sim.schema import PoseEstimate


class AboveFloor:
    """Boxes about what stands on the floor, without saying what it is."""

    def detect(self, image):
        points = transform_points(image.T_world_camera, image.camera.unproject(image.depth).reshape(-1, 3))
        height = points[:, 2].reshape(image.depth.shape)
        parts, _ = ndimage.label((image.depth > 0) & (height > 0.02) & (height < 2))
        boxes = ndimage.find_objects(parts)
        return [Detection(box_xyxy=(u.start, v.start, u.stop - 1, v.stop - 1), score=0.5) for v, u in boxes]


class Outline:
    def segment(self, image):
        return [Detection(item.pixels(*image.depth.shape) & (image.depth > 0)) for item in image.detections]


class Centroid:
    """No network: an object is where the middle of its points is."""

    objects = None
    inputs = "depth"

    def onboard(self, objects):
        (self.obj_id,) = objects

    def estimate(self, image):
        found, points = [], image.camera.unproject(image.depth)
        for number, item in enumerate(image.detections):
            v, u = np.nonzero(item.pixels(*image.depth.shape) & (image.depth > 0))
            if len(u) == 0:
                continue
            T = np.eye(4)
            T[:3, 3] = np.median(points[v, u], axis=0)
            found.append(PoseEstimate(image.scene_id, image.image_id, self.obj_id, item.score, T, detection=number))
        return found
'''
ENTRY_POINTS = """[warehouse_sim.estimators]
centroid = stranger:Centroid
[warehouse_sim.detectors]
above-floor = stranger:AboveFloor
[warehouse_sim.segmenters]
outline = stranger:Outline
"""


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    site = tmp_path_factory.mktemp("site")
    (site / "stranger.py").write_text(STRANGER)
    info = site / "stranger-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: stranger\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(ENTRY_POINTS)
    return site


IN_TURN = """
import json, sys
from warehouse_sim.cli.main import main
for command in sys.argv[1:]:
    print(main(json.loads(command)), flush=True)
"""


def test_a_segmenter_outlines_what_a_detector_found_and_what_makes_no_sense_is_one_line(
    installed: Path, toy_root: Path, tmp_path: Path
) -> None:
    out = tmp_path / "poses.csv"
    predict = ["predict", "centroid", "--data", toy_root, "--out", tmp_path / "none.csv"]
    good = [*predict[:-1], out, "--split", "train", "--detections", "above-floor+outline"]
    cases = [
        (["train", "centroid", "--data", toy_root, "--out", tmp_path / "run"], "centroid needs no training"),
        ([*predict, "--refine", "icp"], "centroid selects and refines in its own way"),
        ([*predict, "--time-of-flight"], "leave --time-of-flight out"),
        ([*predict, "--detections", "abovefloor"], "detector or segmenter"),
    ]
    commands = [json.dumps(list(map(str, arguments))) for arguments in (good, *(case for case, _ in cases))]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(installed), *filter(None, sys.path)])}
    program = [sys.executable, "-c", IN_TURN, *commands]
    done = subprocess.run(program, capture_output=True, text=True, env=environment, check=False)
    assert [line for line in done.stdout.splitlines() if line in "02"] == ["0", *["2"] * len(cases)], done.stderr
    _, *rows = out.read_text().splitlines()
    assert rows
    assert {row.split(",")[3] for row in rows} == {"1.0"}
    lines = [line for line in done.stderr.splitlines() if line.startswith("error:")]
    assert len(lines) == len(cases)
    for line, (_, message) in zip(lines, cases, strict=True):
        assert message in line
    assert "Traceback" not in done.stderr
