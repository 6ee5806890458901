"""Recorded frames: labelled faces are entered by the ground truth, and what cannot be scored is said."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from tests.benchmarks.test_recorded_faces import face
from tests.dataset.kitti_folder import write_street
from warehouse_sim.benchmark.recorded.entries import BASELINE
from warehouse_sim.benchmark.recorded.score import find_recorded
from warehouse_sim.benchmark.run import RunConfig, run_suite
from warehouse_sim.benchmark.suite import load_suite
from warehouse_sim.errors import InputError


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "real" / "faces").mkdir(parents=True)
    face(tmp_path / "real" / "faces")
    mask = np.zeros((48, 64), np.uint8)
    mask[20:28, 20:40] = 255
    cv2.imwrite(str(tmp_path / "real" / "faces" / "site" / "001_mask.png"), mask)
    bare = tmp_path / "real" / "boxes"
    bare.mkdir()
    cv2.imwrite(str(bare / "color_image.png"), np.full((48, 64, 3), 90, np.uint8))
    cv2.imwrite(str(bare / "raw_depth.png"), np.full((48, 64), 900, np.uint16))
    cv2.imwrite(str(bare / "mask_0.png"), np.pad(np.full((8, 20), 255, np.uint8), 20)[:48, :64])
    (bare / "intrinsics.json").write_text('{"fx": 60, "fy": 60, "cx": 31.5, "cy": 23.5}')
    (tmp_path / "real" / "notes").mkdir()
    (tmp_path / "real" / "notes" / "readme.txt").write_text("nothing")
    return tmp_path / "real"


def test_what_can_be_scored_is_and_the_rest_is_said(folder: Path, tmp_path: Path) -> None:
    suite, config = load_suite("real"), RunConfig(tmp_path / "out", workers=1)
    result = run_suite(suite, ("oracle", "shuffled", "rectangle-fit"), config=config, data=folder)
    docked = {row.estimator: row.value for row in result.rows if "masks: gt, gravity: gt" in row.condition}
    assert docked["oracle"] == 1.0
    assert BASELINE in docked
    assert docked["shuffled"] == 0.0, "of a single frame there is no other to take the pose of"
    assert all(row.interval[0] < row.interval[1] for row in result.rows)
    assert any("boxes: 1 images, 1 masks, no poses" in note for note in result.notes)
    assert any(note.startswith("notes: not in a format") for note in result.notes)
    assert {item.estimator for item in result.left_out} == {"rectangle-fit"}


def test_without_a_folder_it_says_so_and_scores_nothing(tmp_path: Path) -> None:
    result = run_suite(load_suite("real"), config=RunConfig(tmp_path / "out"))
    assert result.rows == ()
    assert "--data" in result.notes[0]
    with pytest.raises(InputError, match="is no folder"):
        run_suite(load_suite("real"), config=RunConfig(tmp_path / "out"), data=tmp_path / "nowhere")


def test_malformed_labels_are_named(folder: Path, tmp_path: Path) -> None:
    labels = next((folder / "faces").glob("*/labels.json"))
    labels.write_text(labels.read_text().replace('"T_camera_dock"', '"T_camera"'))
    result = run_suite(load_suite("real"), ("oracle",), config=RunConfig(tmp_path / "out", workers=1), data=folder)
    assert any("labels.json: is malformed" in item.reason for item in result.left_out)


def test_folders_within_one_are_told_apart_and_one_alone_is_taken(folder: Path) -> None:
    write_street(folder / "kitti", 4)
    kinds = {item.path.name: item.kind for item in find_recorded(folder)}
    assert kinds == {"boxes": "other", "faces": "faces", "kitti": "posed", "notes": "other"}
    (alone,) = find_recorded(folder / "kitti")
    assert (alone.kind, alone.split) == ("posed", "val")
    assert [item.kind for item in find_recorded(folder / "faces")] == ["faces"]
    assert [item.kind for item in find_recorded(folder / "boxes")] == ["other"]


def test_bare_images_are_told_what_they_lack(tmp_path: Path) -> None:
    cat = tmp_path / "cat"
    cat.mkdir()
    for name in ("cat.jpg", "depth.png", "cat_mask.png"):
        cv2.imwrite(str(cat / name), np.full((48, 64), 90, np.uint8))
    np.save(cat / "cat_pose.npy", np.eye(4)[:3])
    (found,) = find_recorded(cat)
    assert found.note.startswith("cat: 3 images in no layout that is read; to predict, name them color.png")
    for word in ("intrinsics.json", "BOP or LINEMOD", "meshes and poses"):
        assert word in found.note
