import json
import math
import shutil
from dataclasses import replace

import numpy as np
import pytest

from tests.evaluation.made_dataset import estimates_of, make_dataset, write_estimates
from tests.evaluation.pallet import nudge
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.errors import DatasetError, EvaluationError
from warehouse_sim.evaluation import evaluate, read_scores, write_scores
from warehouse_sim.evaluation.measuring import measure
from warehouse_sim.geometry.pose import make_transform, rotation_x, rotation_z


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    return make_dataset(tmp_path_factory.mktemp("made") / "data")


@pytest.fixture
def score(data, tmp_path):
    def run(estimates):
        return evaluate(write_estimates(estimates, tmp_path / "method_made-test.csv"), data, "test")

    return run


@pytest.fixture(scope="module")
def exact(data, tmp_path_factory):
    """The scores of the ground truth as predictions."""
    predictions = write_estimates(estimates_of(data), tmp_path_factory.mktemp("exact") / "method_made-test.csv")
    return evaluate(predictions, data, "test")


def moved(estimates, motion):
    return [replace(item, T_camera_object=item.T_camera_object @ motion) for item in estimates]


def test_ground_truth_as_predictions_scores_exactly_one(exact):
    plain = exact.to_plain()
    every_summary = [plain["overall"], *(item for group in plain["groups"].values() for item in group)]
    checked = 0
    for summary in every_summary:
        for name, value in summary["metrics"].items():
            if not name.startswith("median_") and value is not None:
                assert value == 1.0, (summary["label"], name)
                checked += 1
    assert checked > 100
    assert plain["overall"]["metrics"]["dock_20mm"] == 1.0
    assert plain["overall"]["metrics"]["median_mssd"] == 0.0
    assert plain["counts"] == {
        "scenes": 2, "images": 4, "ground_truths": 20, "ground_truths_left_out": 0, "predictions": 20, "found": 20,
        "rejected": 0,
    }  # fmt: skip
    assert sum(plain["docking_failures"].values()) == 0
    assert plain["seconds_per_image"] == 0.05


def test_the_half_turn_of_a_printed_carton_is_right_in_shape_only(data, score):
    turned = moved(estimates_of(data), make_transform(rotation_z(np.pi)))
    group = {item.label: item.metrics for item in score(turned).groups["class"]}
    assert (group["carton"]["add_10pct"], group["carton"]["add_shape_2pct"]) == (0.0, 1.0)
    pallet = group["pallet"]
    assert [pallet[name] for name in ("add_2pct", "add_shape_2pct", "mssd_2pct", "dock_20mm")] == [1.0] * 4
    upside_down = moved(estimates_of(data), make_transform(rotation_x(np.pi)))
    assert score(upside_down).overall.metrics["add_shape_10pct"] == 0.0


def test_a_known_shift_is_the_median_of_all_lengths(data, score):
    got = score(moved(estimates_of(data), nudge(z=0.04))).overall.metrics
    assert got["median_add"] == pytest.approx(0.04)
    assert got["median_mssd"] == pytest.approx(0.04)
    assert got["median_vertical"] == pytest.approx(0.04)
    assert got["median_lateral"] == pytest.approx(0.0, abs=1e-9)
    assert (got["dock_0mm"], got["pose_5cm_5deg"]) == (0.0, 1.0)


def test_missing_estimates_count_in_every_denominator(data, score):
    estimates = estimates_of(data)
    kept = estimates[::2]
    got = score(kept)
    fraction = len(kept) / len(estimates)
    assert got.overall.metrics["add_2pct"] == pytest.approx(fraction)
    pallets = [item for item in kept if item.obj_id == 1]
    assert got.overall.metrics["dock_0mm"] == pytest.approx(len(pallets) / 16)
    assert got.docking_failures["missed"] == 16 - len(pallets)
    assert got.overall.gt_count == 20


def test_no_estimate_at_all_scores_zero_with_a_warning(score, caplog):
    got = score([])
    assert "method_made-test.csv: holds no estimate; every object counts as missed" in caplog.text
    assert "no median: half or more are missed" in "\n".join(got.summary())
    assert got.overall.metrics["add_10pct"] == 0.0
    assert got.overall.metrics["median_add"] == math.inf
    assert got.seconds_per_image is None
    assert got.to_plain()["overall"]["metrics"]["median_add"] is None


def test_bins_by_distance_hold_the_objects_at_that_distance(exact):
    counts = {summary.label: summary.gt_count for summary in exact.groups["distance"]}
    assert counts == {"0-2 m": 0, "2-4 m": 8, "4-6 m": 4, "6-8 m": 4, "8-12 m": 4, "over 12 m": 0}
    assert {summary.label: summary.gt_count for summary in exact.groups["class"]} == {"carton": 4, "pallet": 16}


def test_light_on_the_objects_comes_from_the_scene_records(data, exact, tmp_path):
    assert set(exact.table.illuminance) == {100.0, 200.0, 300.0, 400.0, 500.0}
    assert [summary.gt_count for summary in exact.groups["illuminance"]] == [0, 0, 4, 8, 8, 0]
    elsewhere = shutil.copytree(data, tmp_path / "data")
    shutil.rmtree(elsewhere / "scenes")
    predictions = write_estimates(estimates_of(data), tmp_path / "method_x.csv")
    assert np.isnan(evaluate(predictions, elsewhere, "test").table.illuminance).all()


def test_what_is_hardly_visible_is_left_out_and_its_estimate_costs_nothing(data):
    reader = DatasetReader(data)
    images = reader.images("test")
    targets = [target for image in images for target in image.targets]
    hidden = sum(target.visible_fraction < 0.9 for target in targets)
    assert hidden > 0
    table = measure(estimates_of(data), images, reader.objects, min_visible=0.9)
    assert len(table) == len(targets) - hidden
    assert (table.mssd < 0.02 * table.diameter).all()


def test_docking_is_judged_at_the_side_towards_the_camera(exact):
    pallets = exact.table.select(exact.table.dockable)
    short = np.isin(pallets.face, ["-x", "+x"])
    assert 0 < short.sum() < len(pallets)
    assert pallets.slack_lateral[short] == pytest.approx(0.06375)
    assert pallets.slack_lateral[~short] == pytest.approx(0.14125)
    assert pallets.slack_vertical == pytest.approx(0.030)


INWARDS = {"-x": [1, 0, 0], "+x": [-1, 0, 0], "-y": [0, 1, 0], "+y": [0, -1, 0]}


def test_ground_truth_moved_along_the_forks_docks_within_the_limits_of_depth(data, score, exact):
    estimates = estimates_of(data)
    faces = exact.table.face
    # The tips reach 1.10 m, and two thirds of the pallet must be on them.
    short = np.array([1.10 - 2 / 3 * {"x": 1.2, "y": 0.8}[face[1]] for face in faces])
    assert len(set(short)) == 2

    def docked(deeper):
        along = deeper * np.ones(len(estimates))
        shifted = [
            replace(item, T_camera_object=item.T_camera_object @ nudge(*(metres * np.array(INWARDS[face]))))
            for item, face, metres in zip(estimates, faces, along, strict=True)
        ]
        scores = score(shifted)
        return scores.overall.metrics["dock_0mm"], {axis: n for axis, n in scores.docking_failures.items() if n}

    assert docked(0.049) == docked(-short + 0.01) == (1.0, {})
    assert docked(0.051) == (0.0, {"too_deep": 16})
    assert docked(-short - 0.01) == (0.0, {"too_short": 16})


def test_a_pallet_upside_down_is_not_docked(data, score):
    scores = score(moved(estimates_of(data), make_transform(rotation_x(np.pi))))
    assert [scores.overall.metrics[name] for name in ("dock_0mm", "dock_gate_50mm_3deg")] == [0.0, 0.0]
    assert scores.docking_failures["upside_down"] == 16


def test_an_estimate_a_diameter_away_is_no_match(data, score):
    far = moved(estimates_of(data), nudge(z=50.0))
    got = score(far)
    assert got.counts["found"] == 0


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"scene_id": 0}, r"line 2: scene 0 image 0 is not in split 'test'"),
        ({"image_id": 77}, r"line 2: scene 2 image 77 is not in split 'test'"),
        ({"obj_id": 900}, r"line 2: object 900 is not in"),
    ],
)
def test_a_prediction_of_another_dataset_is_rejected_by_its_line(data, score, change, message):
    first, *rest = estimates_of(data)
    with pytest.raises(EvaluationError, match=message):
        score([replace(first, **change), *(item for item in rest if item.image_id != 77)])


def scaled(estimates, factor):
    def T(item):
        return make_transform(item.T_camera_object[:3, :3], factor * item.T_camera_object[:3, 3])

    return [replace(item, T_camera_object=T(item)) for item in estimates]


@pytest.mark.parametrize(
    ("factor", "message"),
    [
        (1e-3, r"method_made-test\.csv: t looks like metres: read as millimetres.*multiply t by 1000"),
        (1.5e-3, "t looks like metres"),
        (1e3, r"t looks like micrometres.*multiply t by 0\.001"),
    ],
)
def test_predictions_in_another_unit_are_rejected_with_a_hint(data, score, factor, message):
    with pytest.raises(EvaluationError, match=message):
        score(scaled(estimates_of(data), factor))


@pytest.mark.parametrize("factor", [0.1, 0.5, 2.0, 10.0])
def test_predictions_that_are_merely_wrong_are_scored(data, score, factor):
    assert score(scaled(estimates_of(data), factor)).overall.metrics["add_2pct"] == 0.0


def test_the_unit_is_judged_by_the_images_that_have_predictions(data, score):
    estimates = [item for item in scaled(estimates_of(data), 1e-3) if item.image_id == 1]
    with pytest.raises(EvaluationError, match="metres"):
        score(estimates)
    assert score(estimates_of(data)[:1]).counts["found"] == 1


def test_repeated_predictions_are_rejected_by_their_lines(data, score):
    first, *rest = estimates_of(data)
    with pytest.raises(DatasetError, match=r"csv:22: repeats line 2; remove one of the two"):
        score([first, *rest[1:], rest[0], first])


def test_a_split_without_images_is_rejected(data, tmp_path):
    with pytest.raises(EvaluationError, match=r"the split 'val' has no images; choose another"):
        evaluate(write_estimates([], tmp_path / "a.csv"), data, "val")


def test_a_split_without_ground_truth_is_rejected(data, tmp_path):
    hidden = tmp_path / "hidden"
    shutil.copytree(data, hidden)
    for path in hidden.glob("bop/*/*/scene_gt_info.json"):
        rows = json.loads(path.read_text())
        for row in (row for image in rows.values() for row in image):
            row["visib_fract"] = 0.05
        path.write_text(json.dumps(rows))
    with pytest.raises(EvaluationError, match="no ground truth that is visible enough"):
        evaluate(write_estimates([], tmp_path / "a.csv"), hidden, "test")


def test_a_dataset_whose_objects_are_incomplete_is_rejected(data, tmp_path):
    broken = tmp_path / "broken"
    shutil.copytree(data, broken)
    objects = json.loads((broken / "objects.json").read_text())
    gone = objects.pop("1")
    (broken / "objects.json").write_text(json.dumps(objects))
    assert gone["class_name"] == "pallet"
    with pytest.raises(EvaluationError, match=r"objects\.json: lacks the labelled objects \[1\]"):
        evaluate(write_estimates([], tmp_path / "a.csv"), broken, "test")


QUARTER_TURNS = [np.round(make_transform(rotation_z(k * np.pi / 2))).tolist() for k in range(4)]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"diameter": 0}, "diameter must be 0.0001-10,000 m, found 0.0"),
        ({"diameter": -1}, "diameter must be 0.0001-10,000 m, found -1.0"),
        ({"diameter": 14.49}, "diameter 14.49 m does not go with size"),
        ({"diameter": 1.25}, "diameter is 1.25 m, the mesh has 1.44939 m"),
        ({"symmetries": QUARTER_TURNS}, "moves the surface elsewhere"),
        ({"size": [1.2, 0.8, 0.3]}, "size is"),
        ({"pockets": []}, "a pallet has pockets"),
    ],
)
def test_an_object_that_its_mesh_contradicts_is_rejected(data, tmp_path, change, message):
    broken = shutil.copytree(data, tmp_path / "broken")
    objects = json.loads((broken / "objects.json").read_text())
    objects["1"].update(change)
    (broken / "objects.json").write_text(json.dumps(objects))
    with pytest.raises((EvaluationError, DatasetError), match=r"objects\.json: 1: ") as caught:
        evaluate(write_estimates([], tmp_path / "a.csv"), broken, "test")
    assert message in str(caught.value)


def behind(estimate):
    T = estimate.T_camera_object.copy()
    T[:3, 3] *= -1.0
    return replace(estimate, T_camera_object=T)


def test_an_estimate_behind_the_camera_is_wrong_and_all_others_count(data, score):
    first, second, *rest = estimates_of(data)
    metrics = score([first, behind(second), *rest]).overall.metrics
    assert metrics["add_10pct"] == metrics["mssd_10pct"] == 19 / 20
    assert metrics == score([first, *rest]).overall.metrics


def test_predictions_that_all_lie_behind_the_camera_are_in_another_frame(data, score):
    with pytest.raises(EvaluationError, match=r"method_made-test\.csv: every estimate is behind the camera"):
        score([behind(item) for item in estimates_of(data)])


@pytest.mark.parametrize(("factor", "place"), [(-1.0, "behind"), (0.0, "around")])
def test_a_ground_truth_that_no_camera_sees_is_rejected_by_file_and_target(data, tmp_path, factor, place):
    broken = shutil.copytree(data, tmp_path / "broken")
    path = next(broken.glob("bop/test/*/scene_gt.json"))
    poses = json.loads(path.read_text())
    image = next(key for key in poses if poses[key])
    poses[image][0]["cam_t_m2c"] = [factor * value for value in poses[image][0]["cam_t_m2c"]]
    path.write_text(json.dumps(poses))
    with pytest.raises(EvaluationError, match=rf"scene_gt\.json .*image {image}: target 0 is {place} the camera"):
        evaluate(write_estimates([], tmp_path / "a.csv"), broken, "test")


def test_a_near_object_whose_centre_is_beside_the_camera_is_scored(data, score):
    first, *rest = estimates_of(data)
    T = first.T_camera_object.copy()
    T[:3, 3] = [0.9, 0.0, -0.05]
    assert score([replace(first, T_camera_object=T), *rest]).counts["found"] == len(rest)


def test_an_evaluation_folder_is_read_as_it_was_written(data, score, tmp_path):
    scores = score(estimates_of(data)[3:])
    path = write_scores(scores, tmp_path / "eval")
    again = read_scores(path.parent)
    assert again.to_plain() == scores.to_plain() == json.loads(path.read_text())
    assert again.table.prediction.tolist() == scores.table.prediction.tolist()
    assert len(again.estimates) == 17
    assert (again.method, again.dataset["recipe"], again.dataset["split"]) == ("method", "made", "test")


def test_scores_do_not_depend_on_where_files_lie(data, exact, tmp_path):
    elsewhere = write_estimates(estimates_of(data), tmp_path / "deeper" / "method_x.csv")
    assert evaluate(elsewhere, data, "test").to_plain() == exact.to_plain()
    assert str(data) not in json.dumps(exact.to_plain())


def test_a_folder_without_a_score_of_this_format_is_rejected(tmp_path):
    for content in ('{"format": 3}', "[]"):
        (tmp_path / "scores.json").write_text(content)
        with pytest.raises(
            EvaluationError, match=r"a score of format (3|4|None), not 6.*evaluate again on the predictions"
        ):
            read_scores(tmp_path)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("method", 3),
        ("overall", None),
        ("overall", {"metrics": [], "intervals": {}}),
        ("groups", {"class": 3}),
        ("groups", []),
        ("counts", "x"),
        ("docking_failures", {"pitch": "x"}),
        ("seconds_per_image", "x"),
    ],
)
def test_a_score_with_a_value_of_another_kind_is_rejected(exact, tmp_path, key, value):
    path = write_scores(exact, tmp_path / "eval")
    path.write_text(json.dumps(json.loads(path.read_text()) | {key: value}))
    with pytest.raises(EvaluationError, match=r"scores\.json.*; run warehouse-sim evaluate again"):
        read_scores(path.parent)


@pytest.mark.parametrize("value", [-1.0, 1.5])
def test_a_fraction_out_of_range_or_without_an_interval_is_rejected(exact, tmp_path, value):
    path = write_scores(exact, tmp_path / "eval")
    content = json.loads(path.read_text())
    content["overall"]["metrics"]["add_10pct"] = value
    path.write_text(json.dumps(content))
    with pytest.raises(EvaluationError, match=r"overall: metrics: add_10pct must be 0-1 with an interval"):
        read_scores(path.parent)
    content["overall"]["metrics"]["add_10pct"] = 0.5
    del content["overall"]["intervals"]["add_10pct"]
    path.write_text(json.dumps(content))
    with pytest.raises(EvaluationError, match="with an interval"):
        read_scores(path.parent)
