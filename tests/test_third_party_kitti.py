"""A KITTI folder without CAD goes the whole way: classes are trained on, instances scored on their own clouds."""

import csv
import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from tests.dataset.kitti_folder import BESIDE, CAMERA_HEIGHT, street, write_frame, write_street
from warehouse_sim.cli.main import main
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.errors import TrainingError
from warehouse_sim.estimators.pose.densefusion.estimator import Estimator
from warehouse_sim.estimators.settings import PredictConfig
from warehouse_sim.evaluation import evaluate, measuring

NUMBERS = {"Car": 1, "Pedestrian": 4}
FRAMES, SEED = 21, 5
VAL = (9, 19)
"""Every tenth frame is kept apart."""


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_street(tmp_path_factory.mktemp("kitti") / "street", FRAMES, testing=1, seed=SEED)


def gt_csv(path: Path, shift: float = 0.0) -> Path:
    """Write the labelled poses of val as estimates in BOP's CSV, by hand, moved to the right by ``shift`` (m)."""
    rows = ["scene_id,im_id,obj_id,score,R,t,time"]
    for frame in VAL:
        for thing in street(frame, SEED):
            c, s = np.cos(thing.heading), np.sin(thing.heading)
            R = np.array([[c, s, 0], [0, 0, -1], [-s, c, 0]])
            t = np.array([thing.x + shift, CAMERA_HEIGHT - thing.size[0] / 2, thing.z]) + BESIDE
            words = " ".join(f"{v:.9f}" for v in R.ravel()), " ".join(f"{1000 * v:.6f}" for v in t)
            rows.append(f"{frame},0,{NUMBERS[thing.kind]},1.0,{words[0]},{words[1]},-1")
    path.write_text("\n".join(rows) + "\n")
    return path


def test_cars_and_pedestrians_are_trained_on_found_and_scored(
    data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run, found, scored, page = tmp_path / "run", tmp_path / "ours_val.csv", tmp_path / "scored", tmp_path / "page.html"
    train = ("train", "densefusion", "--data", data, "--out", run, "--size", "nano", "--max-steps", 12, "--batch", 8)
    for command in (
        train,
        ("predict", run, "--data", data, "--split", "val", "--selection", "argmax", "--out", found),
        ("evaluate", found, "--data", data, "--split", "val", "--out", scored),
        ("evaluate", found, "--data", data, "--split", "val", "--kitti", "--out", tmp_path / "protocol"),
        ("report", data, run, scored, "--out", page),
    ):
        assert main([str(word) for word in command]) == 0, command
    assert "diameter: box diagonal, model: cloud of the instance" in capsys.readouterr().out
    assert "diameter: box diagonal" in page.read_text(encoding="utf-8")
    scores = json.loads((scored / "scores.json").read_text())
    assert scores["dataset"] | {"model": "cloud of the instance", "diameter": "box diagonal"} == scores["dataset"]
    assert scores["counts"]["ground_truths"] == scores["counts"]["found"] == 6
    assert {item["label"]: item["gt_count"] for item in scores["groups"]["class"]} == {"Car": 4, "Pedestrian": 2}
    # From the mean pose of each class: a slip of frames or units would put them metres away.
    assert scores["overall"]["metrics"]["median_add"] < 1.0
    with pytest.raises(TrainingError, match="has no CAD surface of Car, Pedestrian, which ICP needs"):
        Estimator(run, PredictConfig(refine="icp"))


def test_ground_truth_fed_back_scores_one(data: Path, tmp_path: Path) -> None:
    scores = evaluate(gt_csv(tmp_path / "gt_val.csv"), data, "val")
    metrics = scores.to_plain()["overall"]["metrics"]
    fractions = {name: value for name, value in metrics.items() if "median" not in name and value is not None}
    assert len(fractions) > 12
    assert set(fractions.values()) == {1.0}
    assert scores.overall.metrics["median_add"] < 1e-8
    assert scores.counts["ground_truths"] == 6


def test_a_known_shift_is_measured_on_each_cloud_against_its_own_diagonal(data: Path, tmp_path: Path) -> None:
    table = evaluate(gt_csv(tmp_path / "gt_val.csv", shift=0.15), data, "val").table
    assert np.allclose(table.add, 0.15, atol=1e-8)
    assert np.allclose(table.mssd, 0.15, atol=1e-8)
    diagonal = {"Car": np.sqrt(1.5**2 + 1.6**2 + 3.9**2), "Pedestrian": np.sqrt(1.75**2 + 0.65**2 + 0.85**2)}
    assert np.allclose(table.diameter, [diagonal[name] for name in table.class_name])
    scores = evaluate(tmp_path / "gt_val.csv", data, "val")
    by_class = {item.label: item.metrics["add_5pct"] for item in scores.groups["class"]}
    assert by_class == {"Car": 1.0, "Pedestrian": 0.0}  # 5 % are 22 cm and 10 cm


def by_protocol(path: Path, data: Path) -> dict[tuple[str, str, str], dict]:
    """Score a pose CSV as KITTI does, and return what is stored by class, level and view."""
    out = path.with_suffix("")
    assert main(["evaluate", str(path), "--data", str(data), "--split", "val", "--kitti", "--out", str(out)]) == 0
    scores = json.loads((out / "kitti_scores.json").read_text())["scores"]
    return {(row["class_name"], row["level"], row["view"]): row for row in scores}


def test_poses_become_the_rows_that_were_labelled_by_hand(data: Path, tmp_path: Path) -> None:
    scores = by_protocol(gt_csv(tmp_path / "gt_val.csv"), data)
    for frame in VAL:
        labels = (data / "training/label_2" / f"{frame:06d}.txt").read_text().splitlines()
        expected = [line.split() for line in labels if line and not line.startswith("DontCare")]
        rows = (tmp_path / "gt_val/kitti_results" / f"{frame:06d}.txt").read_text().splitlines()
        found = [line.split() for line in rows]
        assert [row[0] for row in found] == [row[0] for row in expected]
        for ours, theirs in zip(found, expected, strict=True):
            np.testing.assert_allclose([*map(float, ours[3:15])], [*map(float, theirs[3:15])], atol=0.011)
            assert float(ours[15]) == 1.0
    cars = {view: scores["Car", "moderate", view] for view in ("image", "ground", "space")}
    # With so few of them, recall is sampled below 1.
    assert [row["ap_40"] for row in cars.values()] == [pytest.approx((row["wanted"] - 1) / 40) for row in cars.values()]
    assert cars["image"]["wanted"] == 4


def test_boxes_beside_the_labelled_ones_are_wrong_on_the_ground_and_in_space(data: Path, tmp_path: Path) -> None:
    scores = by_protocol(gt_csv(tmp_path / "beside.csv", shift=0.6), data)
    # Of 1.6 m of a car's width 1.0 are left: 45 % of what both boxes cover, where 70 are required.
    assert scores["Car", "moderate", "space"]["ap_40"] == scores["Car", "moderate", "ground"]["ap_40"] == 0.0


@pytest.mark.parametrize(
    ("change", "words"),
    [("9,0,1", "estimate is of frame 8, which is not in split 'val'"), ("9,0,4", "object 7, a class without labelled")],
)
def test_estimates_of_nothing_that_is_scored_are_rejected(
    change: str, words: str, data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = gt_csv(tmp_path / "wrong.csv")
    other = "8,0,1" if change == "9,0,1" else "9,0,7"
    path.write_text(path.read_text().replace(f"\n{change},", f"\n{other},"))
    assert main(["evaluate", str(path), "--data", str(data), "--split", "val", "--kitti", "--out", str(tmp_path / "o")])
    assert words in capsys.readouterr().err


def test_other_protocols_beside_it_are_rejected(data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = gt_csv(tmp_path / "gt.csv")
    assert main(["evaluate", str(path), "--data", str(data), "--kitti", "--bop", "--out", str(tmp_path / "o")])
    assert "leave out --sealed, --bop and --vsd" in capsys.readouterr().err


def test_what_is_not_of_kittis_layout_is_rejected(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = gt_csv(tmp_path / "gt.csv")
    (tmp_path / "empty").mkdir()
    assert main(["evaluate", str(path), "--data", str(tmp_path / "empty"), "--kitti", "--out", str(tmp_path / "o")])
    assert "is not of KITTI's layout" in capsys.readouterr().err


def test_what_the_lidar_hardly_hit_is_left_out(data: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = Path(shutil.copytree(data, tmp_path / "few"))
    write_frame(folder / "training", VAL[0], street(VAL[0], SEED), SEED, points_each=49)
    write_frame(folder / "training", VAL[1], street(VAL[1], SEED), SEED, points_each=50)
    path = gt_csv(tmp_path / "gt_val.csv")
    counts = evaluate(path, folder, "val").counts
    assert (counts["ground_truths"], counts["ground_truths_left_out"]) == (3, 3)
    monkeypatch.setattr(measuring, "MIN_MODEL_POINTS", 20)
    assert evaluate(path, folder, "val").counts["ground_truths"] == 6
    write_frame(folder / "training", VAL[0], street(VAL[0], SEED), SEED, points_each=0)
    monkeypatch.setattr(measuring, "MIN_MODEL_POINTS", 1)
    assert evaluate(path, folder, "val").counts["ground_truths"] == 3


@pytest.mark.real
def test_recorded_labels_fed_back_score_one(real_data: Path, tmp_path: Path) -> None:
    (image,) = DatasetReader(real_data / "kitti").images("val")
    path = tmp_path / "gt_val.csv"
    with path.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["scene_id", "im_id", "obj_id", "score", "R", "t", "time"])
        for target in image.targets:
            T = target.T_camera_object
            R, t = (" ".join(f"{v:.9f}" for v in values) for values in (T[:3, :3].ravel(), 1000 * T[:3, 3]))
            writer.writerow([142, 0, target.obj_id, 1.0, R, t, -1])
    scores = evaluate(path, real_data / "kitti", "val")
    assert scores.counts["ground_truths"] == 9  # those with 50 points
    metrics = scores.to_plain()["overall"]["metrics"]
    assert metrics["add_2pct"] == metrics["auc_add_10cm_posecnn"] == 1.0
    assert {item.label for item in scores.groups["class"]} == {"Car", "Pedestrian", "Cyclist"}
