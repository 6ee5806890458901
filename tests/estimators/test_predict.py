import json
from pathlib import Path

import numpy as np
import pytest

from tests.dataset.toy import make_dataset, make_manifest
from tests.estimators.pose.densefusion.made_run import made_run
from warehouse_sim.cli.main import main
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.errors import DatasetError, InputError, TrainingError, UnknownNameError
from warehouse_sim.estimators.load import load_estimator
from warehouse_sim.estimators.predict import detect, predict
from warehouse_sim.estimators.registries import describe_model, trained_names
from warehouse_sim.estimators.settings import PredictConfig


def wanted(root: Path, split: str) -> list[tuple[int, int]]:
    return [
        (image.scene_id, image.image_id)
        for image in DatasetReader(root).images(split)
        for target in image.targets
        if target.visible_fraction >= 0.1 and target.pixels_visible >= 32
    ]


@pytest.mark.parametrize("name", trained_names())
@pytest.mark.parametrize("refine", ["none", "icp"])
def test_one_estimate_a_visible_target(toy_root: Path, tmp_path: Path, name: str, refine: str) -> None:
    fractions = []
    estimates = predict(
        made_run(tmp_path / "run", name),
        toy_root,
        "train",
        PredictConfig(refine=refine),
        lambda s, _: fractions.append(s),
    )
    assert [(item.scene_id, item.image_id) for item in estimates] == wanted(toy_root, "train")
    assert fractions[-1] == 1.0
    for item in estimates:
        assert (item.obj_id, item.name, item.class_name) == (1, "toy-pallet", "pallet")
        assert item.predicted_error is None
        assert 0.0 < item.score < 1.0
        assert 0.0 < item.time < 10.0
        np.testing.assert_allclose(item.T_camera_object[:3, :3] @ item.T_camera_object[:3, :3].T, np.eye(3), atol=1e-5)
        assert np.linalg.det(item.T_camera_object[:3, :3]) > 0
    times = {(item.scene_id, item.image_id): item.time for item in estimates}
    assert all(item.time == times[item.scene_id, item.image_id] for item in estimates)


def test_unknown_objects_and_empty_runs_are_named(toy_root: Path, tmp_path: Path) -> None:
    with pytest.raises(TrainingError, match="not trained on object 1 toy-pallet; it knows: 1 other"):
        predict(made_run(tmp_path / "run", object_name="other"), toy_root, "test", PredictConfig())
    run = made_run(tmp_path / "another", obj_id=77)
    with pytest.raises(TrainingError, match="trained on none of toy-pallet; it knows: 77 toy-pallet"):
        predict(run, toy_root, "test", PredictConfig())
    (tmp_path / "empty").mkdir()
    with pytest.raises(TrainingError, match="is not a run folder"):
        predict(tmp_path / "empty", toy_root, "test", PredictConfig())
    with pytest.raises(UnknownNameError, match="a bundled name or a run folder"):
        predict(tmp_path / "nothing", toy_root, "test", PredictConfig())
    run = made_run(tmp_path / "no-meshes")
    (run / "objects.safetensors").unlink()
    with pytest.raises(TrainingError, match=r"has no objects\.safetensors, which ICP needs"):
        predict(run, toy_root, "test", PredictConfig(refine="icp"))


def test_depth_that_a_dataset_lacks_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    root, nothing = (
        make_dataset(tmp_path / "data", make_manifest(formats=("coco",))),
        tmp_path / "found.json",
    )
    nothing.write_text("[]")
    given = PredictConfig(detections=str(nothing))
    for name, config in (("rectangle-fit", given), ("segment-rectangle-fit", PredictConfig())):
        with pytest.raises(DatasetError, match="holds no depth images"):
            predict(name, root, "train", config)
    with pytest.raises(DatasetError, match="holds no depth images"):
        detect("detector-depth", root, "train")
    assert len(detect(str(nothing), root, "train")[1]) == len(DatasetReader(root).images("train"))
    assert predict(lambda image: [], root, "train", given) == []
    out = tmp_path / "again.json"
    assert main(["detect", str(nothing), "--data", str(root), "--split", "train", "--out", str(out)]) == 0
    assert f"next:   warehouse-sim view {root} --summary" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("rectangle-fit", "in its own way; leave --time-of-flight out"),
        ("densefusion-depth", "choose --refine icp or verify"),
    ],
)
def test_what_time_of_flight_would_change_nothing_of_is_rejected(name: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        load_estimator(name, PredictConfig(time_of_flight=True, refine="none"))
    assert load_estimator("densefusion-depth", PredictConfig(time_of_flight=True, refine="icp")).objects


def test_a_model_is_described_by_its_card_else_by_its_training(tmp_path: Path) -> None:
    folder = tmp_path / "densefusion"
    folder.mkdir()
    assert describe_model(folder) == "bundled"
    (folder / "result.json").write_text(json.dumps({"val_within_5_percent": 97.25}))
    assert describe_model(folder) == "val: 97.2 % within 5 % of the diameter"
    (folder / "card.yaml").write_text("score: 99 % docked\nspeed: 12 ms for 8 objects\nmore: 1\n")
    assert describe_model(folder) == "99 % docked; 12 ms for 8 objects"
