"""What was detected once is read back as it was, for whoever shares the detector; other weights detect again."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from tests.benchmark.made import bench_folder
from tests.shared import Shared
from warehouse_sim.benchmark.entrants.detected import SEEN, read_found, write_found
from warehouse_sim.benchmark.entrants.entrant import Evaluated, Request
from warehouse_sim.benchmark.entrants.ways import Way
from warehouse_sim.benchmark.suite import ConditionConfig
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.estimators.image import Detection, RgbdImage
from warehouse_sim.estimators.registries import DETECTORS
from warehouse_sim.estimators.settings import PredictConfig
from warehouse_sim.schema import PoseEstimate


def test_detections_are_read_back_as_they_were(tmp_path: Path) -> None:
    mask = np.zeros((20, 30), bool)
    mask[3:9, 5:8] = True
    probability = np.where(mask, np.float32(0.3), np.float32(0.0))
    written = (
        Detection(mask, "epal1", 0.123456789, mask_probability=probability),
        Detection(None, 3, 0.5, number=7, box_xyxy=(1.5, 2.25, 9.0, 8.125), class_name="pallet", may_be=(1, "epal2")),
        Detection(np.zeros((20, 30), bool), class_name="carton"),
    )
    write_found(tmp_path / "a.npz", written, 0.25)
    found, seconds = read_found(tmp_path / "a.npz", (20, 30))
    assert seconds == 0.25
    for mine, other in zip(found, written, strict=True):
        for name in ("mask", "mask_probability"):
            one, two = getattr(mine, name), getattr(other, name)
            assert (one is None) == (two is None)
            assert one is None or (one.dtype == two.dtype and np.array_equal(one, two))
        for name in ("model", "score", "number", "box_xyxy", "class_name", "may_be"):
            assert getattr(mine, name) == getattr(other, name)


class Counting:
    """Finds one box, and counts how often."""

    reads_depth = True
    calls = 0

    def detect(self, image: RgbdImage) -> Sequence[Detection]:
        Counting.calls += 1
        return [Detection(box_xyxy=(100.0, 50.0, 180.0, 120.0), class_name="pallet")]


@pytest.mark.gl
def test_a_detector_looks_once_for_all_who_share_it(
    shared: Shared, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(DETECTORS, "names", lambda: ["counting"])
    monkeypatch.setattr(DETECTORS, "get", lambda name: Counting)
    (root,) = (bench_folder(shared, tmp_path) / "data").glob("smoke-*")
    reader, out = DatasetReader(root), tmp_path / "out"
    images = len(reader.images("test"))

    def answers(name: str, kept: Path | None, gravity: str = "rig") -> list[PoseEstimate]:
        condition = ConditionConfig("smoke", predict={"detections": "counting", "gravity": gravity})
        member = Evaluated(name, Way(name, PredictConfig()))
        return member.estimates(Request(reader, "test", condition, lambda done, note: None, kept))

    alone = answers("rectangle-fit", None)
    assert Counting.calls == images
    first, again = answers("rectangle-fit", out), answers("icp-multistart", out)
    assert Counting.calls == 2 * images
    assert len(list((out / SEEN).rglob("*.npz"))) == images
    assert again
    for mine, other in zip(first, alone, strict=True):
        assert np.array_equal(mine.T_camera_object, other.T_camera_object)
    answers("rectangle-fit", out, gravity="none")
    assert Counting.calls == 3 * images, "it sees another image"
