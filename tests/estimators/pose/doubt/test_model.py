"""Steps, their file, and what an estimator does with them."""

from dataclasses import replace

import numpy as np
import pytest

from warehouse_sim.errors import InputError, TrainingError
from warehouse_sim.estimators.load import load_estimator
from warehouse_sim.estimators.pose.doubt.estimator import Doubtful
from warehouse_sim.estimators.pose.doubt.model import Doubt, DoubtModel, Steps, StepSum, read_doubt, write_doubt
from warehouse_sim.estimators.settings import PredictConfig
from warehouse_sim.schema import PoseEstimate

MODEL = DoubtModel(
    "argmax",
    "none",
    StepSum(0.5, (Steps("explained", (0.4, 0.8), (-3.0, 0.0, 2.0)),)),
    StepSum(float(np.log(2.0)), ()),
    StepSum(0.0, ()),
    (4.0,),
    (1.0, 3.0),
    100,
    0.9,
    0.9,
)


@pytest.mark.parametrize(("x", "wanted"), [(-9.0, -2.5), (0.4, -2.5), (0.41, 0.5), (0.8, 0.5), (7.0, 2.5)])
def test_a_step_holds_up_to_and_with_its_place(x, wanted):
    assert MODEL.score.value({"explained": x}) == wanted


def test_probability_and_bound_by_range():
    near, far = ({"explained": 0.9, "log_range": np.log(distance)} for distance in (3.0, 5.0))
    assert MODEL.probability(near) == pytest.approx(1.0 / (1.0 + np.exp(-2.5)))
    assert MODEL.bound_factor(near) == pytest.approx(2.0)
    assert MODEL.bound_factor(far) == pytest.approx(6.0)


def test_the_file_keeps_every_number_and_one_model_a_way(tmp_path):
    doubt = Doubt((MODEL,)).with_model(replace(MODEL, refine="icp")).with_model(replace(MODEL, samples=7))
    write_doubt(tmp_path, doubt)
    again = read_doubt(tmp_path)
    assert again == doubt
    assert again.get("argmax", "none").samples == 7
    assert again.get("weighted", "none") is None
    assert read_doubt(tmp_path / "other") == Doubt()


def test_a_malformed_file_is_told(tmp_path):
    write_doubt(tmp_path, Doubt((MODEL,)))
    text = (tmp_path / "doubt.yaml").read_text()
    (tmp_path / "doubt.yaml").write_text(text.replace("[-3.0, 0.0, 2.0]", "[-3.0, 0.0]"))
    with pytest.raises(TrainingError, match=r"doubt\.yaml"):
        read_doubt(tmp_path)


def test_a_feature_that_is_not_there_is_told():
    with pytest.raises(TrainingError, match="no feature is called 'explained'"):
        MODEL.score.value({})


class Guess:
    objects = None

    def estimate(self, image):
        return [PoseEstimate(0, 0, 1, 0.8, np.eye(4), detection=0)]


def test_what_cannot_be_looked_at_is_refused_by_who_refuses_and_else_left_as_it_is():
    from tests.estimators.pose.doubt.test_residuals import seen

    image, _ = seen(0.001, 1)
    (given,) = Doubtful(Guess(), MODEL).estimate(image)
    assert (given.score, given.refused, given.covariance) == (0.8, False, None)
    (refused,) = Doubtful(Guess(), MODEL, refuse=0.5).estimate(image)
    assert (refused.score, refused.refused) == (0.0, True)


def test_risk_above_what_is_allowed_is_refused(surface_mesh):
    from tests.estimators.pose.doubt.test_residuals import T, seen

    class Placed(Guess):
        def estimate(self, image):
            return [PoseEstimate(0, 0, 1, 0.8, T, detection=0)]

    image, _ = seen(0.001, 1)
    (given,) = Doubtful(Placed(), MODEL, {1: surface_mesh}, refuse=0.2).estimate(image)
    assert not given.refused
    assert given.score == pytest.approx(1.0 / (1.0 + np.exp(-2.5)))
    assert given.error_bound > given.predicted_error > 0.0
    assert np.linalg.eigvalsh(given.covariance).min() > 0.0
    (refused,) = Doubtful(Placed(), MODEL, {1: surface_mesh}, refuse=0.05).estimate(image)
    assert (refused.score, refused.refused) == (0.0, True)


def test_what_has_no_doubt_cannot_refuse():
    with pytest.raises(InputError, match=r"rectangle-fit cannot refuse.*leave --refuse out"):
        load_estimator("rectangle-fit", PredictConfig(refuse=0.1))
