"""A target that leans: DontCare in KITTI, its full pose in BOP, and nothing that validate would not understand."""

import json
import math
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.dataset.toy import failures, make_dataset, make_scene, observation_of
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.validate import validate
from warehouse_sim.geometry.pose import make_transform, rotation_x
from warehouse_sim.schema import SceneSpec

LABELS, IDS = (Path(f"kitti/training/{kind}/000000.txt") for kind in ("label_2", "label_2_ids"))
LEANING = 10


def with_a_leaning_pallet(scene: SceneSpec) -> SceneSpec:
    lean = make_transform(rotation_x(math.radians(25.0)), np.array([0.0, 0.0, 0.2]))
    instances = [
        replace(item, T_world_object=item.T_world_object @ lean) if item.instance_id == LEANING else item
        for item in scene.instances
    ]
    return replace(scene, instances=tuple(instances))


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("leaning") / "data"
    return make_dataset(folder, scene_of=lambda index: with_a_leaning_pallet(make_scene(index)))


@pytest.fixture
def root(made: Path, tmp_path: Path) -> Path:
    """A copy of the dataset, to break."""
    return Path(shutil.copytree(made, tmp_path / "data"))


def test_it_is_dont_care_with_its_box_and_its_id_and_comes_last(root: Path) -> None:
    rows = [line.split(" ") for line in (root / LABELS).read_text().splitlines()]
    assert [row[0] for row in rows] == ["pallet", "pallet", "DontCare"]
    assert (root / IDS).read_text() == "11\n12\n10\n"
    scene = with_a_leaning_pallet(make_scene(0))
    gt = observation_of(scene, 0, scene.viewpoints[0].T_world_camera).annotations[0]
    assert [float(word) for word in rows[2][4:8]] == list(gt.box_amodal_xyxy)
    assert rows[2][1:4] + rows[2][8:] == ["-1", "-1", "-10", "-1", "-1", "-1", "-1000", "-1000", "-1000", "-10"]


def test_bop_has_its_full_pose(root: Path) -> None:
    (target,) = [item for item in DatasetReader(root).images("train")[0].targets if item.instance_id == LEANING]
    scene = with_a_leaning_pallet(make_scene(0))
    gt = observation_of(scene, 0, scene.viewpoints[0].T_world_camera).annotations[0]
    assert np.abs(target.T_camera_object - gt.T_camera_object).max() < 1e-9


def test_validate_understands_it(root: Path) -> None:
    assert failures(root) == {}
    details = {check.name: check.detail for check in validate(root)}
    assert details["kitti labels"] == "9 labels of 15 fields, 3 of them DontCare: they lean"


def test_what_stands_must_not_be_dont_care(root: Path) -> None:
    lines = (root / LABELS).read_text().splitlines()
    lines[1] = lines[2]
    (root / LABELS).write_text("\n".join(lines) + "\n")
    (root / IDS).write_text("11\n10\n12\n")
    assert "leans by 0.00 deg only, but is DontCare" in failures(root)["kitti labels"]


@pytest.mark.parametrize(
    ("ids", "complaint"),
    [
        ("11\n12\n20\n", "object 20 is a carton, which is no target"),
        ("12\n11\n10\n", "is no pallet where the scene record has object 12"),
        ("11\n12\n77\n", "the scene record has no object 77"),
        ("11\n12\n", "must hold the id of each of 3 labels"),
        ("11\n12\n-1\n", "must hold the id of each of 3 labels"),
    ],
)
def test_wrong_ids_are_found(root: Path, ids: str, complaint: str) -> None:
    (root / IDS).write_text(ids)
    assert complaint in failures(root)["kitti labels"]


def test_a_leaning_object_must_not_have_an_upright_box(root: Path) -> None:
    record = root / "scenes/000000.json"
    data = json.loads(record.read_text())
    item = next(item for item in data["objects"] if item["instance_id"] == 11)
    lean = np.array(item["T_world_object"]) @ make_transform(rotation_x(math.radians(5.0)))
    item["T_world_object"] = lean.tolist()
    record.write_text(json.dumps(data))
    assert "object 11 leans by 5.00 deg and must be DontCare" in failures(root)["kitti labels"]
