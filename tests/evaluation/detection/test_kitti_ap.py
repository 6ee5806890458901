"""KITTI's average precision by closed forms; tests/ecosystem holds it against the C++ of the development kit."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from warehouse_sim.cli.commands.evaluate import evaluate
from warehouse_sim.dataset.formats.kitti.reader import KittiLabel
from warehouse_sim.errors import DatasetError, EvaluationError
from warehouse_sim.evaluation.detection.kitti_ap import (
    evaluate_kitti_results,
    kitti_lines,
    kitti_scores,
    write_kitti_scores,
)
from warehouse_sim.evaluation.detection.kitti_overlap import KittiObjects, overlaps, shared_areas


def pallet(number: int = 0, **changes) -> KittiLabel:
    box = (100.0 * number, 50.0, 100.0 * number + 80.0, 110.0)
    label = KittiLabel("pallet", 0.0, 0, 0.3, box, (0.144, 0.8, 1.2), (3.0 * number, 1.0, 6.0), 0.4)
    return replace(label, **changes)


def scores_of(gt, found, scores=()):
    rows = kitti_scores([KittiObjects.of(gt)], [KittiObjects.of(found, scores)], {"pallet": 0.5})
    return {(row.level, row.view): row for row in rows}


@pytest.mark.parametrize(("count", "r11", "r40"), [(10, 3 / 11, 9 / 40), (20, 5 / 11, 19 / 40), (41, 1, 1), (60, 1, 1)])
def test_the_ground_truth_scores_one_from_41_objects_on_and_less_below(count, r11, r40):
    labels = [pallet(number) for number in range(count)]
    for row in scores_of(labels, labels).values():
        assert (row.wanted, row.ap_11, row.ap_40) == (count, pytest.approx(r11), pytest.approx(r40))
        if row.view == "image":
            assert (row.aos_11, row.aos_40) == (pytest.approx(r11), pytest.approx(r40))


def test_every_right_one_beside_a_wrong_one_of_its_score_is_half():
    labels = [pallet(number) for number in range(50)]
    wrong = [pallet(number + 100) for number in range(50)]
    found = scores_of(labels, [item for pair in zip(labels, wrong, strict=True) for item in pair], [0.5] * 100)
    assert found["easy", "space"].ap_40 == pytest.approx(0.5)
    sure = scores_of(labels, labels + wrong, [0.9] * 50 + [0.1] * 50)
    assert sure["easy", "space"].ap_40 == 1.0


def test_kitti_counts_recall_by_the_surest_box_that_overlaps_and_not_by_the_nearest():
    """Of labels fed back in another order, one is left over where boxes overlap by more than is required."""
    labels = [
        pallet(box_xyxy=(25.0 * k, 50.0, 25.0 * k + 80.0, 110.0), location=(3.0 * k, 1.0, 6.0)) for k in range(60)
    ]
    for scores in ([1.0] * 60, [1.0 - 0.001 * k for k in range(60)]):  # ties or not
        assert scores_of(labels, labels, scores)["easy", "image"].ap_40 == 1.0
        turned = scores_of(labels, labels[::-1], scores)
        assert turned["easy", "image"].ap_40 == pytest.approx(39 / 40)
        assert turned["easy", "space"].ap_40 == 1.0, "boxes in space share nothing"


def test_what_is_turned_by_a_quarter_keeps_its_precision_and_half_its_orientation():
    labels = [pallet(number) for number in range(50)]
    turned = [replace(label, alpha=label.alpha + math.pi / 2) for label in labels]
    row = scores_of(labels, turned)["easy", "image"]
    assert (row.ap_40, row.aos_40) == (1.0, pytest.approx(0.5))


def test_a_box_too_far_is_found_in_the_image_and_not_on_the_ground():
    labels = [pallet(number) for number in range(50)]
    far = [replace(label, location=(*label.location[:2], 9.0)) for label in labels]
    high = [replace(label, location=(label.location[0], 0.5, label.location[2])) for label in labels]
    assert scores_of(labels, far)["easy", "image"].ap_40 == 1.0
    assert scores_of(labels, far)["easy", "ground"].ap_40 == 0.0
    assert scores_of(labels, high)["easy", "ground"].ap_40 == 1.0
    assert scores_of(labels, high)["easy", "space"].ap_40 == 0.0


def test_hard_ones_are_requested_only_at_their_level_and_cost_nothing_above():
    labels = [pallet(number) for number in range(50)] + [pallet(number, occluded=2) for number in range(50, 70)]
    found = scores_of(labels, labels)
    assert [found[level, "image"].wanted for level in ("easy", "moderate", "hard")] == [50, 50, 70]
    assert found["easy", "image"].ap_40 == 1.0
    ignored = KittiLabel("DontCare", -1, -1, -10, (4900.0, 0.0, 9000.0, 200.0), (-1, -1, -1), (-1000,) * 3, -10)
    on_it = labels[:50] + [pallet(number) for number in range(50, 80)]
    assert scores_of([*labels[:50], ignored], on_it, [0.5] * 80)["easy", "image"].ap_40 == 1.0
    assert scores_of(labels[:50], on_it, [0.5] * 80)["easy", "image"].ap_40 == pytest.approx(50 / 80)


def test_two_squares_turned_by_an_eighth_share_an_octagon():
    one, turned, shifted = [0, 0, 1, 1, 0.0], [0, 0, 1, 1, math.pi / 4], [0.25, 0.5, 1, 1, math.pi]
    shared = shared_areas(np.array([one], float), np.array([one, turned, shifted, [3, 0, 1, 1, 1]], float))
    assert shared[0] == pytest.approx([1.0, 2 * math.sqrt(2) - 2, 0.375, 0.0])


def test_areas_do_not_depend_on_where_and_how_both_lie():
    rng = np.random.default_rng(0)
    a, b = (
        np.column_stack([rng.normal(0, 0.5, (6, 2)), rng.uniform(0.3, 2, (6, 2)), rng.uniform(-4, 4, 6)]) for _ in "ab"
    )
    shared = shared_areas(a, b)
    assert shared == pytest.approx(shared_areas(b, a).T)
    angle, moved = 1.1, []
    for item in (a, b):
        turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
        moved.append(np.column_stack([item[:, :2] @ turn.T + [3, -7], item[:, 2:4], item[:, 4] + angle]))
    assert shared_areas(*moved) == pytest.approx(shared)


def line(label: KittiLabel, score: float | None = None) -> str:
    words = [label.type, label.truncated, label.occluded, label.alpha, *label.box_xyxy, *label.size_hwl]
    return " ".join(map(str, [*words, *label.location, label.rotation_y, *([] if score is None else [score])]))


def made_folder(root: Path, frames: int) -> Path:
    (root / "ImageSets").mkdir(parents=True)
    (root / "testing" / "label_2").mkdir(parents=True)
    (root / "ImageSets" / "test.txt").write_text("".join(f"{frame:06d}\n" for frame in range(frames)))
    for frame in range(frames):
        (root / "testing" / "label_2" / f"{frame:06d}.txt").write_text(line(pallet(frame)) + "\n")
    return root


def test_result_files_are_scored_from_outside(tmp_path):
    data, results = made_folder(tmp_path / "data", 45), tmp_path / "results"
    results.mkdir()
    for frame in range(45):
        (results / f"{frame:06d}.txt").write_text(line(pallet(frame), 0.8) + "\n\n")
    scores = evaluate_kitti_results(results, data, "test")
    assert {row.ap_40 for row in scores} == {1.0}
    assert "pallet           easy      image      45  100.00  100.00   100.00" in kitti_lines(scores)
    assert '"ap_40": 1.0' in write_kitti_scores(scores, tmp_path / "out").read_text()
    for frame in range(30, 45):
        (results / f"{frame:06d}.txt").unlink()  # nothing found there
    # Recall ends at 2/3, between 26/40 and 27/40, and the kit takes the last detection as a sample of its own.
    assert evaluate_kitti_results(results, data, "test")[0].ap_40 == pytest.approx(27 / 40)
    (results / "000003.txt").write_text(line(pallet(3)))
    with pytest.raises(EvaluationError, match=r"000003\.txt: row 1: needs a score as its sixteenth field"):
        evaluate_kitti_results(results, data, "test")
    (results / "000099.txt").write_text("")
    with pytest.raises(EvaluationError, match=r"000099\.txt: is of no frame of split 'test'"):
        evaluate_kitti_results(results, data, "test")


def test_the_command_says_where_the_scores_are_and_what_comes_next(tmp_path, capsys):
    data, results = made_folder(tmp_path / "data", 2), tmp_path / "results"
    results.mkdir()
    (results / "000000.txt").write_text(line(pallet(0), 0.8) + "\n")
    evaluate(results, tmp_path / "out", data)
    *_, where, then = capsys.readouterr().out.splitlines()
    assert where == f"output: {tmp_path / 'out' / 'kitti_scores.json'}"
    assert then.startswith(f"next:   warehouse-sim view {data} --summary")


def test_all_splits_are_scored_together(tmp_path):
    data, results = made_folder(tmp_path / "data", 45), tmp_path / "results"
    results.mkdir()
    (data / "training" / "label_2").mkdir(parents=True)
    (data / "ImageSets" / "train.txt").write_text("000045\n000046\n")
    for frame in range(47):
        (results / f"{frame:06d}.txt").write_text(line(pallet(frame), 0.8) + "\n")
    for frame in (45, 46):
        (data / "training" / "label_2" / f"{frame:06d}.txt").write_text(line(pallet(frame)) + "\n")
    assert {row.wanted for row in evaluate_kitti_results(results, data, "all")} == {47}
    with pytest.raises(EvaluationError, match=r"000045\.txt: is of no frame of split 'test', see .*test\.txt"):
        evaluate_kitti_results(results, data, "test")
    for name in ("train", "test"):
        (data / "ImageSets" / f"{name}.txt").unlink()
    with pytest.raises(DatasetError, match=r"all\.txt"):
        evaluate_kitti_results(results, data, "all")


LENGTH, WIDTH, HEIGHT = 4.0, 1.0, 1.5


def box(x: float, z: float, rotation_y: float) -> KittiLabel:
    return KittiLabel("Car", 0.0, 0, 0.0, (0.0, 0.0, 9.0, 9.0), (HEIGHT, WIDTH, LENGTH), (x, 1.6, z), rotation_y)


@pytest.mark.parametrize("rotation_y", [0.0, 0.6, -1.1, 2.5])
@pytest.mark.parametrize("view", ["ground", "space"])
def test_a_box_moved_by_half_its_length_ahead_keeps_a_third(view: str, rotation_y: float) -> None:
    # About y, which points down, ahead is (cos, 0, -sin): KITTI's object development kit, readme.txt.
    ahead = LENGTH / 2 * math.cos(rotation_y), -LENGTH / 2 * math.sin(rotation_y)
    one, other = (KittiObjects.of([box(x, 9.0 + z, rotation_y)]) for x, z in ((0.0, 0.0), ahead))
    assert overlaps(view, one, other)[0, 0] == pytest.approx(1 / 3)
