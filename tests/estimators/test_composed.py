"""From pixels to poses in one call, with a front end that was trained on the toy warehouse."""

import json
import shutil
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from warehouse_sim.cli.main import main
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.results.detections import read_results
from warehouse_sim.errors import InputError, TrainingError, UnknownNameError
from warehouse_sim.estimators import load as module
from warehouse_sim.estimators.api import Detector, PoseEstimator, Segmenter
from warehouse_sim.estimators.detections import Finder
from warehouse_sim.estimators.image import Detection, RgbdImage
from warehouse_sim.estimators.load import Composed, load_estimator
from warehouse_sim.estimators.matching import taken_by
from warehouse_sim.estimators.own.estimator import NamedObject
from warehouse_sim.estimators.pipeline import WithFrontEnd
from warehouse_sim.estimators.predict import predict
from warehouse_sim.estimators.registries import ESTIMATORS
from warehouse_sim.estimators.settings import PredictConfig
from warehouse_sim.schema import PoseEstimate


class GroundTruthBoxes(Detector):
    """A detector that knows the ground truth, and counts how often it is asked."""

    def __init__(self, reader: DatasetReader, kinds: Mapping[str, float] | None = None) -> None:
        self._reader, self.requested, self._kinds = reader, 0, kinds or {}

    def detect(self, image: RgbdImage) -> list[Detection]:
        self.requested += 1
        records = [record for split in self._reader.splits for record in self._reader.images(split)]
        (record,) = [item for item in records if (item.scene_id, item.image_id) == (image.scene_id, image.image_id)]
        mask = self._reader.mask_visible
        return [
            Detection(mask(record, item.gt_index), score=0.8, class_name="pallet", kind_likelihood=self._kinds)
            for item in record.targets
            if item.pixels_visible > 60 and self._reader.objects[item.obj_id].class_name == "pallet"
        ]


class Always(Detector):
    """Finds the same in every image."""

    def __init__(self, found: Detection) -> None:
        self.found = found

    def detect(self, image: RgbdImage) -> list[Detection]:
        return [self.found]


class Knowing(PoseEstimator):
    """Knows objects, and estimates nothing."""

    objects = ()

    def __init__(self, objects: list[NamedObject]) -> None:
        self.objects = objects

    def estimate(self, image: RgbdImage) -> list[PoseEstimate]:
        return []


def test_images_without_detections_get_those_of_the_front_end(toy_root: Path) -> None:
    reader = DatasetReader(toy_root)
    detector = GroundTruthBoxes(reader)
    estimator = WithFrontEnd(load_estimator("rectangle-fit"), [detector])
    estimator.onboard(reader.objects)
    alone = load_estimator("rectangle-fit")
    alone.onboard(reader.objects)
    found = 0
    for record in reader.images("train"):
        bare = RgbdImage.from_arrays(reader.depth(record), record.camera.K, rgb=reader.rgb(record))
        bare = replace(bare, scene_id=record.scene_id, image_id=record.image_id)
        boxes = tuple(detector.detect(bare))
        poses, requested = estimator.estimate(bare), detector.requested
        inner = alone.estimate(replace(bare, detections=boxes))
        assert len(poses) == len(inner)
        for a, b in zip(poses, inner, strict=True):
            np.testing.assert_allclose(a.T_camera_object, b.T_camera_object)
        estimator.estimate(replace(bare, detections=boxes[:1]))
        assert detector.requested == requested + (not boxes)
        found += len(poses)
    assert found > 0


def test_prediction_leaves_finding_to_the_chain_unless_it_is_told(
    toy_root: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    detector = GroundTruthBoxes(DatasetReader(toy_root))
    monkeypatch.setattr(module, "open_stages", lambda names: [detector])
    monkeypatch.setattr(module, "CHAIN", Composed("detector-depth", "rectangle-fit"), raising=False)
    monkeypatch.setitem(ESTIMATORS._targets, "toy-chain", f"{module.__name__}:CHAIN")
    own = predict("toy-chain", toy_root, "train", PredictConfig())
    assert detector.requested == len(DatasetReader(toy_root).images("train"))
    assert own
    assert {pose.score for pose in own} != {1.0}
    told = predict("toy-chain", toy_root, "train", PredictConfig(detections="gt"))
    assert detector.requested == len(DatasetReader(toy_root).images("train"))
    plain = predict("rectangle-fit", toy_root, "train", PredictConfig())
    assert [pose.detection for pose in told] == [pose.detection for pose in plain]


def test_who_names_the_objects_of_a_hall_is_offered_no_others() -> None:
    known = [
        SimpleNamespace(obj_id=number, name=name, class_name=name.rstrip("12"))
        for number, name in enumerate(("pallet1", "pallet2", "carton1"), start=1)
    ]
    estimator = Knowing(known)
    box = {"box_xyxy": (0.0, 0.0, 9.0, 9.0)}
    found = [
        Detection(class_name="pallet", **box),
        Detection(class_name="carton", **box),
        Detection(class_name="truck", **box),
        Detection(model="pallet1", **box),
        Detection(**box),
    ]
    assert [item.may_be for item in taken_by(estimator, found)] == [()] * 4
    some = taken_by(estimator, found, ("pallet2",))
    assert [(item.class_name, item.model, item.may_be) for item in some] == [
        ("pallet", None, ("pallet2",)),
        ("", "pallet1", ()),
        ("", None, ("pallet2",)),
    ]
    with pytest.raises(UnknownNameError, match=r"under --objects 'palet2'"):
        taken_by(estimator, found, ("palet2",))
    assert len(taken_by(SimpleNamespace(objects=None), found, ("pallet2",))) == 5


def test_what_a_dataset_does_not_hold_is_not_tried(toy_root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    reader = DatasetReader(toy_root)
    there = [(obj_id, info.name) for obj_id, info in reader.objects.items()]
    # A number of the dataset that stands for something else there is another object.
    strange = [(max(reader.objects) + 1, there[0][1]), (there[0][0], "another")]
    known = [NamedObject(number, name) for number, name in (*strange, *there)]
    nameless = Detection(box_xyxy=(0.0, 0.0, 9.0, 9.0))
    monkeypatch.setattr(Finder, "_opened", lambda self, reader=None: [Always(nameless)])
    record = reader.images("train")[0]
    for limited, expected in (((), tuple(name for _, name in there)), (("another",), ("another",))):
        estimator = Knowing(known)
        found = Finder("detector-depth", objects=limited).find(estimator, reader, record)
        assert found is not None
        assert [item.may_be for item in found.detections] == [expected]
        chain = WithFrontEnd(estimator, [Always(nameless)], limited)
        plain = replace(found, detections=())
        assert [item.may_be for item in chain._with_detections(plain).detections] == [limited]
        chain.onboard({})  # another dataset before this one
        chain.onboard({number: SimpleNamespace(name=name) for number, name in strange})
        chain.onboard(reader.objects)
        assert [item.may_be for item in chain._with_detections(plain).detections] == [expected]


@pytest.mark.parametrize(
    "name", ["detect-densefusion", "detect-depth", "detect-keypoints", "segment-densefusion-depth"]
)
def test_chains_say_what_they_are_made_of(name: str) -> None:
    assert "then" in ESTIMATORS.get(name).inputs


def test_a_chain_without_weights_says_which(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("warehouse_sim.learning.trainable.model_names", lambda: [])
    with pytest.raises(TrainingError, match="detector-depth has no bundled weights"):
        load_estimator("segment-icp-multistart")


def test_a_segmenter_needs_boxes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    class Outliner(Segmenter):
        needs_detections = True

        def segment(self, image: RgbdImage) -> list[Detection]:
            return []

    monkeypatch.setattr("warehouse_sim.estimators.detections.open_front_end", lambda name: Outliner())
    with pytest.raises(InputError, match="name a detector before it"):
        Finder("segmenter-depth")
    Finder("gt-boxes+segmenter-depth")


def test_a_file_of_detections_takes_the_place_of_a_detector(
    toy_root: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    data = shutil.copytree(toy_root, tmp_path / "data")
    objects = json.loads((data / "objects.json").read_text())
    objects["2"] = objects["1"] | {"name": "toy-other"}
    (data / "objects.json").write_text(json.dumps(objects))
    for models in (data / "bop" / "models", data / "bop" / "models_eval"):
        shutil.copy(models / "obj_000001.ply", models / "obj_000002.ply")
        (models / "SHA256SUMS").unlink()
    reader = DatasetReader(data)
    detector = GroundTruthBoxes(reader, {"toy-pallet": 0.01, "toy-other": 0.9})
    monkeypatch.setattr("warehouse_sim.estimators.detections.open_front_end", lambda name: detector)
    out = tmp_path / "new" / "found.json"
    words = ["detect", "any", "--data", str(data), "--out", str(out), "--split", "train"]
    assert main([*words, "--labels", str(tmp_path / "labels"), "--height-px", "2"]) == 0
    assert "pallet" in capsys.readouterr().out
    assert len(read_results(out, reader, "train")) > 0
    monkeypatch.undo()
    by_file = predict("rectangle-fit", data, "train", PredictConfig(detections=str(out)))
    monkeypatch.setattr("warehouse_sim.estimators.detections.open_front_end", lambda name: detector)
    direct = predict("rectangle-fit", data, "train", PredictConfig(detections="any"))
    assert len(by_file) == len(direct) > 0
    for a, b in zip(by_file, direct, strict=True):
        np.testing.assert_allclose(a.T_camera_object, b.T_camera_object, atol=1e-9)
        assert a.obj_id == b.obj_id == 2
    boxes = predict("rectangle-fit", data, "train", PredictConfig(detections=str(tmp_path / "labels")))
    assert boxes == [] or boxes[0].detection is not None
