"""Third-party folders in the dissertation's protocol: what counts, what symmetric objects are forgiven."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.dataset.formats.test_linemod import write_preprocessed
from tests.dataset.kitti_folder import Thing, write_frame
from tests.dataset.toy import make_dataset as make_toy
from tests.evaluation.made_dataset import estimates_of, make_dataset, write_estimates
from warehouse_sim.benchmark.entrants.entrant import Group, Oracle, Request, Shuffled
from warehouse_sim.benchmark.rows.scores import metric_columns
from warehouse_sim.benchmark.run import RunConfig, run_suite
from warehouse_sim.benchmark.suite import load_suite
from warehouse_sim.benchmark.third_party import KITTI_CLASSES, LINEMOD_OBJECTS
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.errors import EvaluationError, InputError
from warehouse_sim.evaluation import evaluate

EVALUATED = ("oracle", "shuffled")


def write_near_street(root: Path) -> Path:
    """Near frames with cars and a pedestrian, one with few points on each, and what is no class of the protocol."""
    for frame in range(6):
        turn = -1.5 + 0.1 * frame
        things = [Thing("Car", -2.0, 5.0, turn), Thing("Pedestrian", 1.2, 4.5, turn), Thing("Kiosk", 3.0, 5.5, turn)]
        things.append(Thing("Car", 4.0, 12.0, turn))
        write_frame(root / "training", frame, things, seed=1, points_each=400 if frame < 5 else 60)
    lists = root / "ImageSets"
    lists.mkdir()
    (lists / "train.txt").write_text("000000\n")
    (lists / "val.txt").write_text("000001\n")
    (lists / "test.txt").write_text("".join(f"{frame:06d}\n" for frame in range(2, 6)))
    return root


def run(name: str, data: Path, out: Path):
    return run_suite(load_suite(name), EVALUATED, config=RunConfig(out, workers=1), data=data)


@pytest.mark.parametrize("name", ["multimodal", "selection", "lidar"])
def test_of_kitti_near_cars_and_pedestrians_with_enough_points_count(name: str, tmp_path: Path) -> None:
    result = run(name, write_near_street(tmp_path / "kitti"), tmp_path / "out")
    labels_given = [row for row in result.rows if (row.estimator, row.table) == ("oracle", "scores")]
    assert {row.group for row in labels_given} >= {"all", *KITTI_CLASSES}
    assert not [row for row in labels_given if row.group == "Kiosk" or row.metric.startswith("dock")]
    assert all(row.value == 1.0 for row in labels_given)
    # Three frames with a near car and a pedestrian; the fourth has too few points, the far car is too far.
    assert {row.n for row in labels_given if row.group == "all" and not row.metric.startswith("found")} == {6}
    chance = [row.value for row in result.rows if (row.estimator, row.metric) == ("shuffled", "add_10pct")]
    assert chance
    assert "nearer than 7 m" in result.notes[0]


def test_the_suite_of_distances_has_groups_by_points(tmp_path: Path) -> None:
    result = run("distance", write_near_street(tmp_path / "kitti"), tmp_path / "out")
    rows = {row.group: row for row in result.rows if (row.estimator, row.metric) == ("oracle", "add_10pct")}
    assert rows["0-7 m"].n == 8
    assert rows["7-15 m"].n == 4
    assert rows["0-7 m, at least 100 points"].n == 6
    assert rows["0-7 m, at least 50 points"].n == 8
    assert all(row.value == 1.0 for row in rows.values())


def test_of_linemod_thirteen_objects_count_in_a_protocol_of_their_own(tmp_path: Path) -> None:
    folder = write_preprocessed(tmp_path / "linemod")
    result = run("multimodal", folder, tmp_path / "out")
    labels_given = [row for row in result.rows if (row.estimator, row.table) == ("oracle", "scores")]
    assert {row.metric for row in labels_given} >= {"add_adds_10pct", "add_10pct"}
    assert all(row.value == 1.0 for row in labels_given)
    assert len(LINEMOD_OBJECTS) == 13
    assert not {3, 7} & set(LINEMOD_OBJECTS)
    assert result.data[0].recipe == ""
    for kind in ("data", "models"):
        for path in (folder / kind).iterdir():
            if "01" in path.name or "02" in path.name:
                path.rename(path.with_name(path.name.replace("01", "03").replace("02", "07")))
    text = (folder / "models" / "models_info.yml").read_text()
    (folder / "models" / "models_info.yml").write_text(text.replace("1: {dia", "3: {dia").replace("2: {dia", "7: {dia"))
    for number, old in (("03", 1), ("07", 2)):
        gt = folder / "data" / number / "gt.yml"
        gt.write_text(gt.read_text().replace(f"obj_id: {old}\n", f"obj_id: {int(number)}\n"))
    with pytest.raises(EvaluationError, match="no ground truth that counts"):
        run("multimodal", folder, tmp_path / "out")


def test_a_folder_that_a_suite_does_not_take_is_rejected(tmp_path: Path) -> None:
    street = write_near_street(tmp_path / "kitti")
    with pytest.raises(InputError, match="the suite robustness takes no third-party data"):
        run("robustness", street, tmp_path / "out")
    with pytest.raises(InputError, match="fusion takes third-party data of linemod, found kitti"):
        run("fusion", street, tmp_path / "out")
    with pytest.raises(InputError, match="multimodal takes third-party data of linemod and kitti; leave --data out"):
        run("multimodal", make_toy(tmp_path / "toy"), tmp_path / "out")


def test_eggbox_and_glue_are_forgiven_what_adds_forgives(tmp_path: Path) -> None:
    data = make_dataset(tmp_path / "data")
    upside_down = np.diag([1.0, -1.0, -1.0, 1.0])
    rows = [replace(item, T_camera_object=item.T_camera_object @ upside_down) for item in estimates_of(data)]
    table = evaluate(write_estimates(rows, tmp_path / "p.csv"), data, "test").table
    as_other = metric_columns(table)["add_adds_10pct"]
    as_glue = metric_columns(replace(table, obj_id=np.full_like(table.obj_id, 11)))["add_adds_10pct"]
    boxes = table.class_name == "pallet"
    assert not as_other[boxes].any()
    assert np.array_equal(as_glue, metric_columns(table)["add_s_10pct"])
    assert as_glue[boxes].all()


def test_chance_takes_poses_of_other_places_and_none_twice(tmp_path: Path) -> None:
    reader = DatasetReader(make_dataset(tmp_path / "data"))
    (group,) = [Group("shuffled", (Shuffled(),))]
    condition = load_suite("industrial").evaluated["industrial"]
    found = group.members[0].estimates(Request(reader, "test", condition, lambda fraction, note: None))
    labels_given = Oracle().estimates(Request(reader, "test", condition, lambda fraction, note: None))
    assert len(found) == len(labels_given)
    of_image = {}
    for item in labels_given:
        of_image.setdefault((item.scene_id, item.image_id), []).append(item.T_camera_object)
    seen = set()
    for item in found:
        place = item.scene_id, item.image_id
        assert not any(np.array_equal(item.T_camera_object, T) for T in of_image[place])
        key = (*place, item.T_camera_object.tobytes())
        assert key not in seen
        seen.add(key)
