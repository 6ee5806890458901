from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from tests.estimators.pose.densefusion.made_run import made_run
from tests.estimators.toy_stream import observed
from warehouse_sim.errors import InputError, UnknownNameError
from warehouse_sim.estimators.image import Detection, RgbdImage
from warehouse_sim.estimators.load import load_estimator
from warehouse_sim.estimators.pose.densefusion.calibration import Calibration, ErrorCurve, write_calibration
from warehouse_sim.estimators.pose.densefusion.networks.densefusion import DenseFusion, PoseRun
from warehouse_sim.estimators.settings import PredictConfig
from warehouse_sim.learning.run_folder import write_weights
from warehouse_sim.schema import Observation, PoseEstimate

PLAIN = PredictConfig(selection="argmax", refine="none")


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return made_run(tmp_path_factory.mktemp("estimator") / "run")


def seen(scene_index: int = 0) -> Observation:
    return observed(scene_index)[0]


def assert_same_poses(estimates: list[PoseEstimate], others: list[PoseEstimate]) -> None:
    assert len(estimates) == len(others) > 0
    for a, b in zip(estimates, others, strict=True):
        np.testing.assert_allclose(a.T_camera_object, b.T_camera_object, atol=1e-5)
        assert a.score == pytest.approx(b.score, abs=1e-6)


@pytest.mark.parametrize("refine", ["none", "icp"])
def test_several_images_at_once_give_what_each_gives_alone(run: Path, refine: str) -> None:
    estimator = load_estimator(run, PredictConfig(refine=refine, selection="consensus"))
    images = [RgbdImage.from_observation(seen(index)) for index in range(3)]
    alone = [estimate for image in images for estimate in estimator.estimate(image)]
    assert len(alone) > 5
    assert_same_poses(estimator.estimate_all(images), alone)


def test_an_observation_and_its_arrays_give_the_same(tmp_path: Path) -> None:
    estimator = load_estimator(made_run(tmp_path / "run", "densefusion"))
    observation = seen()
    labels = [label for label in observation.annotations if label.pixels_visible > 0]
    detections = [
        Detection(observation.buffers.instance_mask == label.instance_id, "toy-pallet", number=label.instance_id)
        for label in labels
    ]
    image = RgbdImage.from_arrays(
        np.where(observation.rgbd.depth > 0, observation.rgbd.depth, np.nan),
        observation.camera.K,
        detections,
        observation.rgbd.rgb,
    )
    expected = estimator.estimate(observation)
    assert_same_poses(expected, estimator.estimate(image))
    assert [item.detection for item in expected] == [label.instance_id for label in labels if label.pixels_valid >= 32]


def test_objects_that_the_estimator_does_not_know_are_left_out_of_an_observation(run: Path) -> None:
    observation = seen()
    first, *others = observation.annotations
    strange = replace(observation, annotations=(replace(first, obj_id=99), *others))
    estimator = load_estimator(run, PLAIN)
    assert len(estimator.estimate(strange)) == len(estimator.estimate(observation)) - 1


def test_too_few_readings_give_no_estimate_and_no_detection_gives_none(run: Path) -> None:
    image = RgbdImage.from_observation(seen())
    few = np.zeros(image.depth.shape, dtype=bool)
    few[50, :20] = True
    estimator = load_estimator(run, PLAIN)
    found = estimator.estimate(replace(image, detections=(Detection(few, 1), *image.detections)))
    assert [item.detection for item in found] == [item.detection for item in estimator.estimate(image)]
    assert estimator.estimate(replace(image, detections=())) == []


def test_wrong_input_is_named(run: Path, tmp_path: Path) -> None:
    depth, mask = np.ones((6, 8), dtype=np.float32), np.ones((6, 8), dtype=bool)
    K = np.array([[5.0, 0, 4], [0, 5.0, 3], [0, 0, 1]])
    cases = [
        (lambda: RgbdImage.from_arrays(depth, K, [Detection(mask[:5], 1)]), r"mask 0 has the shape \(5, 8\)"),
        (lambda: RgbdImage.from_arrays(depth, K, [], np.zeros((6, 8))), "rgb"),
        (lambda: RgbdImage.from_arrays(depth, K, [], np.zeros((6, 8, 3))), "rgb must be uint8"),
        (lambda: RgbdImage.from_arrays(depth * 1500, K, []), "look like millimetres"),
        (lambda: RgbdImage.from_arrays(depth, np.eye(4), []), "K 3x3"),
        (lambda: RgbdImage.from_arrays(depth, K * [[-1], [1], [1]], []), "focal lengths"),
    ]
    for make, message in cases:
        with pytest.raises(InputError, match=message):
            make()
    unknown = RgbdImage.from_arrays(depth, K, [Detection(mask, "epal9")])
    with pytest.raises(InputError, match=r"'epal9'; it knows: toy-pallet \(1\)"):
        load_estimator(run).estimate(unknown)
    with pytest.raises(InputError, match="densefusion reads colour"):
        load_estimator(made_run(tmp_path / "run", "densefusion")).estimate(unknown)
    with pytest.raises(UnknownNameError, match="densefuson"):
        load_estimator("densefuson")


def test_predicted_errors_fall_with_confidence_and_scale_with_the_object(tmp_path: Path) -> None:
    run = made_run(tmp_path / "run")
    curve = ErrorCurve("argmax", "none", (0.0, 1.0), (0.2, 0.0), 2.5, 100, 0.5, 0.9)
    write_calibration(run, Calibration((curve,)))
    estimator = load_estimator(run, PLAIN)
    for item in estimator.estimate(seen()):
        expected = 0.2 * (1.0 - item.score) * estimator.objects[0].diameter
        assert item.predicted_error == pytest.approx(expected)
        assert item.error_bound == pytest.approx(2.5 * expected)
    weighted = load_estimator(run, replace(PLAIN, selection="weighted"))
    assert all(item.predicted_error is None for item in weighted.estimate(seen()))


def test_a_detections_score_lowers_that_of_its_pose_but_not_its_predicted_error(run: Path) -> None:
    image = RgbdImage.from_observation(seen())
    unsure = replace(image, detections=tuple(replace(item, score=0.5) for item in image.detections))
    estimator = load_estimator(run, PLAIN)
    for a, b in zip(estimator.estimate(unsure), estimator.estimate(image), strict=True):
        assert a.score == pytest.approx(b.score / 2)


def test_a_small_network_takes_one_thread_and_gives_the_others_back(run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before, taken = torch.get_num_threads(), []
    embed = DenseFusion.embed
    monkeypatch.setattr(
        DenseFusion, "embed", lambda self, *given: (taken.append(torch.get_num_threads()), embed(self, *given))[1]
    )
    for threads in (None, 2):
        load_estimator(run, PredictConfig(threads=threads)).estimate(seen())
    assert taken == [1, 2]
    assert torch.get_num_threads() == before


@pytest.mark.parametrize("name", ["densefusion-pointcloud", "densefusion-middle-1", "object-coordinates"])
def test_every_kind_of_network_corrects_as_often_as_requested(tmp_path: Path, name: str) -> None:
    run = made_run(tmp_path / "run", name)
    config = PoseRun.read(run)
    network = config.load_network(run)
    with torch.no_grad():
        # The refiner begins with zeros.
        for value in network.refiner.outputs.parameters():
            value.normal_(0.0, 0.05)
    write_weights(run, network)

    def poses(count: int | None) -> list[PoseEstimate]:
        return load_estimator(run, replace(PLAIN, refiner_iterations=count)).estimate(seen())

    never, once, twice, usual = (poses(count) for count in (0, 1, 2, None))
    assert config.train.refiner_iterations == 2
    assert_same_poses(usual, twice)
    for a, b, c in zip(never, once, twice, strict=True):
        # An untrained network shows no proposal twice: what differs is the correction, which goes on from the last.
        assert np.abs(b.T_camera_object - a.T_camera_object).max() > 1e-3
        assert np.abs(c.T_camera_object - b.T_camera_object).max() > 1e-3
    write_calibration(run, Calibration(refiner_iterations=0))
    assert_same_poses(poses(None), never)


@pytest.mark.parametrize("left_out", [True, False])
def test_corrections_of_an_untrained_refiner_are_rejected(tmp_path: Path, left_out: bool) -> None:
    run = made_run(tmp_path / "run")
    config = PoseRun.read(run)
    never = load_estimator(run, replace(PLAIN, refiner_iterations=0)).estimate(seen())
    config = replace(config, train=replace(config.train, refiner_iterations=0))
    if left_out:
        weights = config.load_network(run)
        config = replace(config, network=replace(config.network, refiner=None))
        network = config.make_network()
        network.load_state_dict({name: weights.state_dict()[name] for name in network.state_dict()})
        write_weights(run, network)
    config.write(run)
    with pytest.raises(InputError, match=r"no trained refiner.*--phase refiner --init .*run$"):
        load_estimator(run, replace(PLAIN, refiner_iterations=2))
    for count in (None, 0):
        assert_same_poses(load_estimator(run, replace(PLAIN, refiner_iterations=count)).estimate(seen()), never)


def test_errors_are_predicted_for_the_corrections_that_they_were_fitted_with(tmp_path: Path) -> None:
    run = made_run(tmp_path / "run")
    curve = ErrorCurve("argmax", "none", (0.0, 1.0), (0.2, 0.0), 2.5, 100, 0.5, 0.9)
    for fitted, requested, known in ((None, 2, True), (None, 0, False), (0, 0, True), (0, 2, False), (0, None, True)):
        write_calibration(run, Calibration((curve,), fitted))
        estimator = load_estimator(run, replace(PLAIN, refiner_iterations=requested))
        assert all((item.predicted_error is not None) == known for item in estimator.estimate(seen()))
