from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from tests.dataset.toy import CAMERA
from tests.estimators.pose.densefusion.made_crops import made_crop, pallet_shape
from tests.estimators.pose.densefusion.made_run import made_run
from warehouse_sim.errors import TrainingError, UnknownNameError
from warehouse_sim.estimators.image import Detection, RgbdImage
from warehouse_sim.estimators.load import load_estimator
from warehouse_sim.estimators.pose.densefusion.estimator import Estimator, Runner
from warehouse_sim.estimators.pose.densefusion.networks.densefusion import DenseFusion, PoseRun
from warehouse_sim.estimators.pose.densefusion.networks.interface import Inliers
from warehouse_sim.estimators.pose.densefusion.settings import CropConfig, TrainConfig
from warehouse_sim.estimators.pose.fitting.hypotheses import own_of
from warehouse_sim.estimators.registries import ESTIMATORS, trained_names
from warehouse_sim.geometry.pose import make_transform, matrix_from_quat_wxyz, rotation_z
from warehouse_sim.learning.run_folder import Source, read_kind, write_weights


def made_config(name: str) -> PoseRun:
    network = ESTIMATORS.get(name).network("nano")
    datasets = (Source("data", "0" * 64), Source("more", "1" * 64))
    crop = CropConfig(side_px=48, depth=True)
    return PoseRun(
        estimator=name,
        version="1.2.3",
        datasets=datasets,
        objects=(pallet_shape(),),
        network=network,
        crop=crop,
        train=TrainConfig(),
        started_from=Source("other", "2" * 64),
    )


@pytest.mark.parametrize("name", trained_names())
def test_round_trip(tmp_path, name: str) -> None:
    config = made_config(name)
    config.write(tmp_path)
    assert PoseRun.read(tmp_path) == config
    torch.manual_seed(1)
    network = DenseFusion(config.network, 1)
    write_weights(tmp_path, network)
    loaded = config.load_network(tmp_path)
    assert not loaded.training
    for key, value in network.state_dict().items():
        assert torch.equal(loaded.state_dict()[key], value), key


def test_errors_name_the_folder_and_the_remedy(tmp_path) -> None:
    with pytest.raises(TrainingError, match=r"is not a run folder: it has no config\.yaml"):
        PoseRun.read(tmp_path)
    config = made_config("densefusion-pointcloud")
    config.write(tmp_path)
    with pytest.raises(TrainingError, match=r"has no weights\.safetensors; finish the training"):
        config.load_network(tmp_path)
    write_weights(tmp_path, DenseFusion(config.network, 2))
    with pytest.raises(TrainingError, match=r"weights\.safetensors does not fit config\.yaml"):
        config.load_network(tmp_path)
    (tmp_path / "config.yaml").write_text("estimatr: x\n")
    with pytest.raises(TrainingError, match="did you mean 'estimator'"):
        PoseRun.read(tmp_path)


def test_a_run_of_no_named_estimator_is_rejected(tmp_path) -> None:
    made_config("densefusion-pointcloud").write(tmp_path)
    text = (tmp_path / "config.yaml").read_text()
    (tmp_path / "config.yaml").write_text(text.replace("estimator: densefusion-pointcloud", "estimator: ''"))
    with pytest.raises(TrainingError, match="estimator names none"):
        PoseRun.read(tmp_path)


def test_a_run_of_before_kinds_were_written_opens_and_one_of_another_family_is_rejected(tmp_path) -> None:
    config = made_config("densefusion-pointcloud")
    config.write(tmp_path)
    text = (tmp_path / "config.yaml").read_text()
    assert text.count("kind: densefusion\n") == 1
    (tmp_path / "config.yaml").write_text(text.replace("kind: densefusion\n", ""))
    assert read_kind(tmp_path) == "densefusion"
    assert PoseRun.read(tmp_path) == config
    (tmp_path / "config.yaml").write_text(text.replace("kind: densefusion\n", "kind: rectangle\n"))
    with pytest.raises(TrainingError, match="is a run of the kind rectangle, not densefusion"):
        PoseRun.read(tmp_path)
    with pytest.raises(UnknownNameError, match="kind of run folder 'rectangle'"):
        load_estimator(tmp_path)


DOWN = np.array([0.0, 1.0, 0.0])


def test_poses_come_back_in_the_axes_of_a_rolled_camera(tmp_path: Path) -> None:
    run = made_run(tmp_path / "run", preset="robust")
    config = PoseRun.read(run)
    # Without surroundings both cameras see the very same points.
    plain = replace(config.network, inliers=False)
    replace(config, network=plain, crop=type(config.crop)()).write(run)
    torch.manual_seed(0)
    network = DenseFusion(plain, 1)
    with torch.no_grad():
        # The refiner begins with zeros.
        for value in network.refiner.outputs.parameters():
            value.normal_(0.0, 0.05)
    write_weights(run, network)
    runner, R = Runner(run), rotation_z(np.pi / 2)
    level = replace(made_crop(np.random.default_rng(0)), down=DOWN)
    rolled = replace(level, points=(level.points @ R.T).astype(np.float32), down=R @ DOWN)
    unknown = replace(rolled, down=None)
    a, b, c = (runner.propose([crop]) for crop in (level, rolled, unknown))
    # Medians along other axes are those of neighbouring points.
    np.testing.assert_allclose(a.candidates.translation @ R.T, b.candidates.translation, atol=5e-3)
    turned = R @ matrix_from_quat_wxyz(a.candidates.quat_wxyz)
    np.testing.assert_allclose(turned, matrix_from_quat_wxyz(b.candidates.quat_wxyz), atol=5e-3)
    assert np.abs(matrix_from_quat_wxyz(c.candidates.quat_wxyz) - turned).max() > 0.1
    T = make_transform(np.eye(3), level.points.mean(axis=0).astype(float))[None]
    corrected = runner.refine(T, [level], a)
    again = runner.refine(make_transform(R, R @ T[0, :3, 3])[None], [rolled], b)
    np.testing.assert_allclose(make_transform(R, np.zeros(3)) @ corrected, again, atol=5e-3)


def test_masks_and_boxes_are_estimated_alike_with_and_without_gravity(tmp_path: Path) -> None:
    estimator = Estimator(made_run(tmp_path / "run", "densefusion-depth", preset="robust"))
    v, u = np.mgrid[: CAMERA.height, : CAMERA.width]
    mask = (u >= 40) & (u < 100) & (v >= 30) & (v < 60)
    depth = np.where(mask, 2.5 + 0.001 * u, 9.0).astype(np.float32)
    box = 40.0, 30.0, 99.0, 59.0
    found = []
    for detection in (Detection(mask, "toy-pallet"), Detection(model="toy-pallet", box_xyxy=box)):
        for gravity in (None, DOWN):
            image = RgbdImage(CAMERA, depth, (detection,), gravity=gravity)
            (estimate,) = estimator.estimate(image)
            assert np.isfinite(estimate.T_camera_object).all()
            found.append(estimate.T_camera_object)
    # A box that holds nothing but the mask is the same input.
    np.testing.assert_allclose(found[0], found[2])
    np.testing.assert_allclose(found[1], found[3])


def test_own_points_are_those_of_the_mask_that_the_network_trusts(tmp_path: Path) -> None:
    """What follows the network must not fit the wall beside the object, which crops hold, and boxes too."""
    run = made_run(tmp_path / "run", "densefusion-depth", preset="robust")
    estimator, runner = Estimator(run), Runner(run)
    v, u = np.mgrid[: CAMERA.height, : CAMERA.width]
    left = (u >= 40) & (u < 70) & (v >= 30) & (v < 60)
    depth = np.where(left, 2.5, 2.8).astype(np.float32)
    tilted = np.array([0.0, np.cos(0.2), np.sin(0.2)])
    box = Detection(model="toy-pallet", box_xyxy=(40.0, 30.0, 99.0, 59.0))
    crops = estimator.cut(RgbdImage(CAMERA, depth, (box,), gravity=tilted))
    found = runner.propose(crops)
    assert found.batch.turn is not None
    metres = found.batch.inputs.points[0] @ found.batch.turn[0] * found.batch.scale[0] + found.batch.centre[0]
    logit = torch.where(metres[None, :, 2] < 2.65, 3.0, -3.0)
    trusting = replace(found, proposal=found.proposal._replace(inliers=Inliers(logit, found.candidates.confidence)))
    (crop,) = crops
    own = crop.masked_points[own_of(trusting, 0, crop.masked_points)]
    assert (crop.points[:, 2] > 2.65).any()
    np.testing.assert_allclose(own[:, 2], 2.5, atol=1e-3)
    assert len(own) == ((crop.points[:, 2] < 2.65) & (crop.around.signed_px > 0)).sum()
    # Where nearly nothing is trusted, the mask is.
    with_model = replace(found, proposal=found.proposal._replace(inliers=Inliers(-logit.abs(), logit)))
    assert own_of(with_model, 0, crop.masked_points).sum() == (crop.around.signed_px > 0).sum()
