"""What stands beside a pose CSV: covariances, bounds, rejections."""

import json

import numpy as np
import pytest

from warehouse_sim.dataset.results import pose_csv, predictions
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.pose import make_transform
from warehouse_sim.schema import PoseEstimate


def estimate(number: int, **changes) -> PoseEstimate:
    T_camera_object = make_transform(None, np.array([0.1 * number, 0.0, 3.0]))
    return PoseEstimate(0, number, 1, 0.5, T_camera_object, -1.0, **changes)


def with_uncertainty(number: int, **changes) -> PoseEstimate:
    half = np.random.default_rng(number).normal(size=(6, 6))
    return estimate(number, covariance=half @ half.T, predicted_error=0.01, error_bound=0.03, **changes)


def test_uncertainty_comes_back_row_by_row(tmp_path):
    path = tmp_path / "new" / "preds.csv"
    written = [with_uncertainty(0), estimate(1), with_uncertainty(2)]
    predictions.write(path, written)
    read = predictions.read(path)
    assert [item.error_bound for item in read] == [0.03, None, 0.03]
    assert [item.predicted_error for item in read] == [0.01, None, 0.01]
    assert read[1].covariance is None
    for one, other in zip(read[::2], written[::2], strict=True):
        assert np.array_equal(one.covariance, other.covariance)


def test_the_file_says_order_units_and_frame_for_who_reads_it_with_json_alone(tmp_path):
    predictions.write(tmp_path / "a.csv", [with_uncertainty(0)])
    data = json.loads((tmp_path / "a.uncertainty.json").read_text())
    assert data["covariance"]["order"] == ["x", "y", "z", "about x", "about y", "about z"]
    assert data["covariance"]["units"] == "m, rad"
    first = data["rows"][0]["covariance"]
    assert len(first) == 21
    assert first[0] == with_uncertainty(0).covariance[0, 0]
    assert first[-1] == with_uncertainty(0).covariance[5, 5]


def test_rejected_estimates_have_no_row_but_are_kept_to_be_looked_at(tmp_path):
    path = tmp_path / "a.csv"
    predictions.write(path, [with_uncertainty(0, rejected=True), with_uncertainty(1)])
    assert [item.image_id for item in pose_csv.read(path)] == [1]
    assert [item.image_id for item in predictions.read(path)] == [1]
    assert predictions.count_rejected(path) == 1
    (kept,) = json.loads(predictions.uncertainty_file(path).read_text())["rejected"]
    assert (kept["im_id"], kept["error_bound"]) == (0, 0.03)


def test_without_uncertainty_there_is_no_second_file_and_an_old_one_goes(tmp_path):
    path = tmp_path / "a.csv"
    predictions.write(path, [with_uncertainty(0)])
    predictions.write(path, [estimate(0)])
    assert [item.name for item in tmp_path.iterdir()] == ["a.csv"]
    assert predictions.count_rejected(path) == 0


def test_a_csv_that_changed_is_rejected_with_the_old_uncertainty(tmp_path):
    path = tmp_path / "a.csv"
    predictions.write(path, [with_uncertainty(0), with_uncertainty(1)])
    lines = path.read_text().splitlines()
    path.write_text("\n".join(lines[:2]) + "\n")
    with pytest.raises(DatasetError, match=r"a\.uncertainty\.json: belongs to another a\.csv.*remove it"):
        predictions.read(path)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda data: data.update(format=2), "format 2, not 1"),
        (lambda data: data["rows"][0].update(row=7), "no row 7"),
        (lambda data: data["rows"][0].update(covariance=[1.0]), "21 numbers"),
        (lambda data: data["rows"][0].update(covariance=[-1.0] + [0.0] * 20), "negative variance"),
        (lambda data: data["rows"][0].update(error_bound=-1), "error_bound"),
        (lambda data: data.update(rejected=None), "rejected"),
    ],
)
def test_malformed_uncertainty_is_told_with_its_place(tmp_path, change, message):
    path = tmp_path / "a.csv"
    predictions.write(path, [with_uncertainty(0)])
    beside = predictions.uncertainty_file(path)
    data = json.loads(beside.read_text())
    change(data)
    beside.write_text(json.dumps(data))
    with pytest.raises(DatasetError, match=message) as problem:
        (predictions.read(path), predictions.count_rejected(path))
    assert "a.uncertainty.json" in str(problem.value)
