import torch

from tests.estimators.pose.densefusion.networks.made_inputs import build, made_gt, made_shapes
from warehouse_sim.estimators.pose.densefusion.networks.heads import CoordinateHeads, HeadConfig
from warehouse_sim.estimators.pose.densefusion.networks.interface import Coordinates, GroundTruth, Hypotheses, Proposal
from warehouse_sim.estimators.pose.densefusion.networks.rotations import matrix_from_quat_wxyz
from warehouse_sim.estimators.pose.densefusion.settings import LossConfig


def test_untrained_head_proposes_the_start_rotation() -> None:
    torch.manual_seed(0)
    heads = CoordinateHeads(HeadConfig((8, 4), predicts="coordinates"), 6, 5, classes=2)
    torch.nn.init.zeros_(heads.output.weight)
    quat = torch.tensor([0.5, -0.5, 0.5, 0.5])
    heads.start_rotation(1, quat)
    points = torch.randn(2, 30, 3)
    found = heads(torch.randn(2, 30, 6), torch.randn(2, 5), points, torch.tensor([1, 0])).hypotheses
    expected = torch.stack([matrix_from_quat_wxyz(quat), torch.eye(3)])
    torch.testing.assert_close(matrix_from_quat_wxyz(found.quat_wxyz[:, 0]), expected, atol=1e-5, rtol=0)
    assert "start" in heads.state_dict()


def test_true_coordinates_beat_all_others() -> None:
    torch.manual_seed(0)
    gt, shapes, points = made_gt(), made_shapes(), torch.randn(2, 30, 3)
    object_points = (points - gt.translation[:, None]) @ gt.rotation

    def loss(moved: torch.Tensor) -> float:
        quat = torch.randn(2, 1, 4, generator=torch.Generator().manual_seed(1))
        hypotheses = Hypotheses(quat, torch.zeros(2, 1, 3), torch.zeros(2, 1))
        coordinates = Coordinates(points, moved, torch.full((2, 30), -2.0))
        return float(CoordinateHeads.loss(Proposal(hypotheses, coordinates), gt, shapes, LossConfig()))

    assert loss(object_points) < min(loss(object_points + 0.01 * torch.randn(2, 30, 3)) for _ in range(5))


def test_fitted_pose_is_trained_whatever_its_confidence() -> None:
    network, x = build("object-coordinates", "nano")
    gradients = []
    for logit in (-30.0, 0.0):
        network.zero_grad()
        found, coordinates, _ = network(x)
        with_uncertainty = Proposal(found._replace(logit=torch.full_like(found.logit, logit)), coordinates)
        torch.manual_seed(1)
        gt = GroundTruth(matrix_from_quat_wxyz(torch.randn(2, 4)), torch.zeros(2, 3), x.class_index)
        network.loss(with_uncertainty, gt, made_shapes(), LossConfig()).backward()
        gradients.append(network.heads.output.weight.grad.clone())
        torch.manual_seed(0)
    assert bool(gradients[0].any())
    torch.testing.assert_close(*gradients)
