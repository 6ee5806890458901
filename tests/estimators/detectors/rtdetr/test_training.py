"""Training on the toy warehouse, as a person starts it."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import safetensors.torch
import torch
from pycocotools.coco import COCO
from pycocotools.cocoeval import COCOeval

from tests.estimators.detectors.rtdetr.conftest import CONFIG, IMAGES, SMALLEST
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.errors import TrainingError, UnknownNameError
from warehouse_sim.estimators.detections import open_front_end
from warehouse_sim.estimators.detectors.estimator import DetectConfig, TrainedDetector
from warehouse_sim.estimators.detectors.rtdetr.network import RTDETR_DETECT, RtdetrNetwork, TrainedRtdetr, make_detr
from warehouse_sim.estimators.detectors.rtdetr.train import start_from
from warehouse_sim.estimators.image import RgbdImage
from warehouse_sim.estimators.images import compose
from warehouse_sim.estimators.images.settings import ImageAugmentConfig, ImageConfig
from warehouse_sim.estimators.train import train

MEMORY = Path("none")


def test_a_run_folder_detects_and_another_training_begins_with_it(run: Path, toy_root: Path, tmp_path: Path) -> None:
    reader = DatasetReader(toy_root)
    image = RgbdImage.from_dataset(reader, reader.images("train")[0], ())
    detector = TrainedRtdetr(run, replace(RTDETR_DETECT, min_score=0.001))
    found = detector.detect(image)
    assert 0 < len(found) <= 100
    assert {detection.class_name for detection in found} == {"pallet"}
    assert open_front_end(run)(image) is not None
    with pytest.raises(TrainingError, match="of the kind rtdetr, not detector"):
        TrainedDetector(run)
    # What inference left in the library's caches must not be in the way of training.
    small = replace(CONFIG, max_steps=1, validations=1)
    other = train("rtdetr-depth", toy_root, tmp_path / "run", small, init=run, cache=MEMORY)
    log = (other / "train.log").read_text()
    assert f"tensors from {run / 'weights.safetensors'}; fresh: model.backbone.model.embedder" in log
    assert "started_from" in (other / "config.yaml").read_text()


def test_a_pallet_behind_another_is_not_suppressed(run: Path, toy_root: Path) -> None:
    detector = TrainedRtdetr(run)
    boxes = torch.tensor([[[10.0, 10.0, 50.0, 40.0], [14.0, 10.0, 54.0, 40.0], [10.0, 10.5, 50.0, 40.0]]])
    scores = torch.tensor([[[0.9], [0.8], [0.7]]])
    detector._network.decode = lambda raw: (boxes, scores)  # type: ignore[method-assign]
    reader = DatasetReader(toy_root)
    found = detector.detect(RgbdImage.from_dataset(reader, reader.images("train")[0], ()))
    # Overlaps of 0.82 and 0.98 with the first.
    assert [detection.score for detection in found] == pytest.approx([0.9, 0.8])


@pytest.mark.gpu
@pytest.mark.skipif(not torch.cuda.is_available(), reason="no CUDA device")
def test_a_gpu_trains_and_detects(toy_root: Path, tmp_path: Path) -> None:
    made = train("rtdetr-rgbd", toy_root, tmp_path / "run", CONFIG, cache=MEMORY)
    reader = DatasetReader(toy_root)
    TrainedRtdetr(made).detect(RgbdImage.from_dataset(reader, reader.images("train")[0], ()))
    assert '"device": "cuda' in (made / "result.json").read_text()


# Weights of the library as a person has them: its folders and files.


RGB = torch.randint(0, 256, (2, 64, 96, 3), dtype=torch.uint8, generator=torch.Generator().manual_seed(3))


def shaken(network: torch.nn.Module) -> torch.nn.Module:
    with torch.no_grad():
        for value in network.parameters():
            value += 0.02 * torch.randn(value.shape)
    return network.eval()


@pytest.fixture(scope="module")
def theirs(library) -> torch.nn.Module:
    torch.manual_seed(1)
    return shaken(make_detr(SMALLEST, 3))


@pytest.fixture(scope="module")
def folder(theirs, tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("theirs")
    theirs.save_pretrained(place)
    return place


def assert_alike(network: RtdetrNetwork, theirs: torch.nn.Module) -> None:
    with torch.no_grad():
        expected = theirs(pixel_values=RGB.permute(0, 3, 1, 2) / 255.0)
        logits, boxes = network.eval()(RGB, None).layers[-1]
    torch.testing.assert_close(logits, expected.logits)
    torch.testing.assert_close(boxes, expected.pred_boxes)


@pytest.mark.parametrize("what", ["folder", "file"])
def test_what_the_library_saved_gives_what_the_library_gives(what: str, folder: Path, theirs) -> None:
    network = RtdetrNetwork(SMALLEST, IMAGES)
    path = folder if what == "folder" else folder / "model.safetensors"
    started, remark = start_from(path, network)
    own = sum(not name.endswith("num_batches_tracked") for name in network.state_dict())
    assert remark == f"{own} of {own} tensors from {folder / 'model.safetensors'}"
    assert started.name == str(path)
    assert_alike(network, theirs)


def test_files_of_the_first_version_are_taken_too(library, tmp_path: Path) -> None:
    own = make_detr(SMALLEST, 3).config
    known = library.RTDetrConfig().to_dict().keys() - {"backbone_config", "model_type", "architectures"}
    config = {name: value for name, value in own.to_dict().items() if name in known}
    first = shaken(
        library.RTDetrForObjectDetection(library.RTDetrConfig(backbone_config=own.backbone_config, **config))
    )
    first.save_pretrained(tmp_path)
    network = RtdetrNetwork(SMALLEST, IMAGES)
    start_from(tmp_path, network)
    assert_alike(network, first)


def test_weights_for_other_classes_and_inputs_stay_fresh_and_are_named(folder: Path) -> None:
    network = RtdetrNetwork(replace(SMALLEST, classes=1), ImageConfig(("rgb", "depth")))
    before = {name: value.clone() for name, value in network.state_dict().items()}
    _, remark = start_from(folder, network)
    assert "; fresh: model.backbone.model.embedder.embedder.0.convolution.weight, " in remark
    stayed = {name for name, value in network.state_dict().items() if value.equal(before[name])}
    assert {"model.enc_score_head.weight", "model.decoder.class_embed.0.weight"} <= stayed
    assert "model.enc_output.0.weight" not in stayed


def test_what_is_no_weights_is_rejected_in_one_line(folder: Path, tmp_path: Path) -> None:
    network = RtdetrNetwork(SMALLEST, IMAGES)
    (tmp_path / "model.pth").write_bytes(b"pickle")
    (tmp_path / "broken.safetensors").write_bytes(b"no such thing")
    safetensors.torch.save_file({"other": torch.zeros(3)}, tmp_path / "other.safetensors")
    with pytest.raises(TrainingError, match=r"model\.pth.*safetensors"):
        start_from(tmp_path / "model.pth", network)
    with pytest.raises(TrainingError, match=r"broken\.safetensors cannot be read"):
        start_from(tmp_path / "broken.safetensors", network)
    with pytest.raises(TrainingError, match=r"other\.safetensors fits 0 of \d+ tensors"):
        start_from(tmp_path / "other.safetensors", network)
    with pytest.raises(UnknownNameError):
        start_from("no-such-model", network)


# A few images, seen often, are known by heart: average precision counted by pycocotools.


AS_THEY_ARE = ImageAugmentConfig(zoom=1)


@pytest.mark.slow
def test_what_is_seen_often_is_found(library, toy_root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compose, "_MOSAIC", 0.0)
    monkeypatch.setattr(compose, "_SHIFT", 0.0)
    monkeypatch.setattr(compose, "_FLIP", 0.0)
    monkeypatch.setattr(compose, "_ERRORS", compose.ImageErrors(0.0, 0.0, 0.0, 0, 0.0))
    config = replace(CONFIG, max_steps=200, input_wh=(160, 96), learning_rate=1e-3, ema=0.9, augment=AS_THEY_ARE)
    detector = TrainedRtdetr(
        train("rtdetr-depth", toy_root, tmp_path / "run", config, cache=Path("none")), DetectConfig(min_score=0.01)
    )
    reader = DatasetReader(toy_root)
    gt, found = list[dict](), list[dict]()
    images = reader.images("train")
    for number, image in enumerate(images, start=1):
        for target in image.targets:
            left, top, right, bottom = target.box_visible_xyxy
            box = [left, top, right - left + 1, bottom - top + 1]
            hidden = target.visible_fraction < 0.1 or box[3] < 4
            row = {"id": len(gt) + 1, "image_id": number, "category_id": 1, "bbox": box, "area": box[2] * box[3]}
            gt.append({**row, "iscrowd": int(hidden)})
        for detection in detector.detect(RgbdImage.from_dataset(reader, image, ())):
            left, top, right, bottom = np.add(detection.box_xyxy, 0.5)
            box = [left, top, right - left, bottom - top]
            found.append({"image_id": number, "category_id": 1, "bbox": box, "score": detection.score})
    assert coco_ap50(len(images), gt, found) >= 0.95


def coco_ap50(images: int, gt: list[dict], found: list[dict]) -> float:
    coco = COCO()
    numbers = [{"id": number} for number in range(1, images + 1)]
    coco.dataset = {"images": numbers, "annotations": gt, "categories": [{"id": 1}]}
    coco.createIndex()
    scored = COCOeval(coco, coco.loadRes(found), "bbox")
    scored.evaluate()
    scored.accumulate()
    scored.summarize()
    return float(scored.stats[1])
