"""Noise and the pixels that share it, measured on depth images with known noise."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from warehouse_sim.errors import InputError, TrainingError
from warehouse_sim.estimators.api import PoseEstimator
from warehouse_sim.estimators.image import Detection, RgbdImage
from warehouse_sim.estimators.load import load_estimator
from warehouse_sim.estimators.pose.icp.surface import CadSurface
from warehouse_sim.estimators.pose.uncertainty.covariance import measure_residuals
from warehouse_sim.estimators.pose.uncertainty.estimator import WithUncertainty
from warehouse_sim.estimators.pose.uncertainty.features import look
from warehouse_sim.estimators.pose.uncertainty.model import (
    Steps,
    StepSum,
    Uncertainty,
    UncertaintyModel,
    read_uncertainty,
    write_uncertainty,
)
from warehouse_sim.estimators.settings import PredictConfig
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import make_transform
from warehouse_sim.schema import PoseEstimate

CAMERA = PinholeCamera(320, 240, 300.0, 300.0, 159.5, 119.5)
T = make_transform(None, np.array([0.0, 0.0, 3.0]))


def seen(noise: float, window_px: int, shift: float = 0.0) -> tuple[RgbdImage, np.ndarray]:
    """The near face of the box, at 2.8 m, with noise that is alike over a window, before a wall at 6 m."""
    field = np.random.default_rng(1).standard_normal((240, 320))
    field = cv2.blur(field, (window_px, window_px)) * window_px
    depth = (2.8 + shift + noise * field).astype(np.float32)
    mask = np.zeros((240, 320), dtype=bool)
    half = 300.0 / 2.8 * np.array([0.5, 0.4])
    mask[int(120 - half[1]) + 2 : int(120 + half[1]) - 2, int(160 - half[0]) + 2 : int(160 + half[0]) - 2] = True
    depth[~mask] = 6.0
    return RgbdImage(CAMERA, depth, (Detection(mask, 1),)), mask


def residuals(surface: CadSurface, noise: float, window_px: int):
    image, mask = seen(noise, window_px)
    rng = np.random.default_rng(0)
    return measure_residuals(T, surface, image, mask, image.readings_in(mask, rng), rng)


@pytest.mark.parametrize("noise", [0.002, 0.01])
def test_noise_along_the_ray_is_measured(surface, noise):
    assert residuals(surface, noise, 1).along_ray == pytest.approx(noise, rel=0.15)


@pytest.mark.parametrize(("window_px", "low", "high"), [(1, 1.0, 2.5), (5, 12.0, 50.0), (11, 60.0, 250.0)])
def test_pixels_that_share_an_error_are_counted(surface, window_px, low, high):
    """A moving average over k x k pixels has k^2 pixels to an error."""
    assert low <= residuals(surface, 0.01, window_px).correlated_px <= high


def test_a_wrong_pose_is_seen(surface):
    image, mask = seen(0.003, 1)
    right, wrong = (
        look(T @ make_transform(None, np.array(shift)), surface, image, mask, 1.0, None, np.random.default_rng(0))
        for shift in ([0.0, 0.0, 0.0], [0.25, 0.0, 0.0])
    )
    assert right.features["verification"] > wrong.features["verification"] + 0.2
    assert right.features["sharpness"] > 0.0
    assert right.features["sharpness"] > wrong.features["sharpness"]
    assert right.features["explained"] > wrong.features["explained"]


def test_the_covariance_grows_with_the_noise_and_where_less_is_seen(surface):
    def spread(noise: float, keep: slice) -> float:
        image, mask = seen(noise, 5)
        part = np.zeros_like(mask)
        part[:, keep] = mask[:, keep]
        return look(T, surface, image, part, 1.0, None, np.random.default_rng(0)).features["log_surface"]

    whole = spread(0.003, slice(None))
    assert spread(0.02, slice(None)) > whole + 0.2
    assert spread(0.003, slice(120)) > whole


def test_an_estimate_without_readings_is_not_looked_at(surface):
    image, mask = seen(0.003, 1)
    nothing = RgbdImage(CAMERA, np.zeros_like(image.depth), image.detections)
    assert look(T, surface, nothing, mask, 1.0, None, np.random.default_rng(0)) is None


# Steps, their file, and what an estimator does with them.


MODEL = UncertaintyModel(
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
    uncertainty = Uncertainty((MODEL,)).with_model(replace(MODEL, refine="icp")).with_model(replace(MODEL, samples=7))
    write_uncertainty(tmp_path, uncertainty)
    again = read_uncertainty(tmp_path)
    assert again == uncertainty
    assert again.get("argmax", "none").samples == 7
    assert again.get("weighted", "none") is None
    assert read_uncertainty(tmp_path / "other") == Uncertainty()


def test_a_malformed_file_is_told(tmp_path):
    write_uncertainty(tmp_path, Uncertainty((MODEL,)))
    text = (tmp_path / "uncertainty.yaml").read_text()
    (tmp_path / "uncertainty.yaml").write_text(text.replace("[-3.0, 0.0, 2.0]", "[-3.0, 0.0]"))
    with pytest.raises(TrainingError, match=r"uncertainty\.yaml"):
        read_uncertainty(tmp_path)


def test_a_feature_that_is_not_there_is_told():
    with pytest.raises(TrainingError, match="no feature is called 'explained'"):
        MODEL.score.value({})


class Guess(PoseEstimator):
    def estimate(self, image):
        return [PoseEstimate(0, 0, 1, 0.8, np.eye(4), detection=0)]


def test_what_cannot_be_looked_at_is_rejected_by_who_rejects_and_else_left_as_it_is():
    from tests.estimators.pose.uncertainty.test_residuals import seen

    image, _ = seen(0.001, 1)
    (given,) = WithUncertainty(Guess(), MODEL).estimate(image)
    assert (given.score, given.rejected, given.covariance) == (0.8, False, None)
    (rejected,) = WithUncertainty(Guess(), MODEL, reject=0.5).estimate(image)
    assert (rejected.score, rejected.rejected) == (0.0, True)


def test_risk_above_what_is_allowed_is_rejected(surface_mesh):
    from tests.estimators.pose.uncertainty.test_residuals import T, seen

    class Placed(Guess):
        def estimate(self, image):
            return [PoseEstimate(0, 0, 1, 0.8, T, detection=0)]

    image, _ = seen(0.001, 1)
    (given,) = WithUncertainty(Placed(), MODEL, {1: surface_mesh}, reject=0.2).estimate(image)
    assert not given.rejected
    assert given.score == pytest.approx(1.0 / (1.0 + np.exp(-2.5)))
    assert given.error_bound > given.predicted_error > 0.0
    assert np.linalg.eigvalsh(given.covariance).min() > 0.0
    (rejected,) = WithUncertainty(Placed(), MODEL, {1: surface_mesh}, reject=0.05).estimate(image)
    assert (rejected.score, rejected.rejected) == (0.0, True)


def test_what_has_no_uncertainty_cannot_reject():
    with pytest.raises(InputError, match=r"rectangle-fit cannot reject.*leave --reject out"):
        load_estimator("rectangle-fit", PredictConfig(reject=0.1))
