import math

import numpy as np
import pytest
import torch

from tests.learning.made_crops import DIAMETER, MESH, pallet_shape, pose
from warehouse_sim.geometry.mesh import sample_surface
from warehouse_sim.geometry.pose import make_transform, rotation_x, rotation_z, transform_points
from warehouse_sim.learning.losses import confidence_loss, hypotheses_distance, refined_distance
from warehouse_sim.learning.networks.heads import Hypotheses
from warehouse_sim.learning.objects import shape_tensors

SHAPES = shape_tensors([pallet_shape()])
SCALE = DIAMETER / 2


def distance(T_predicted: np.ndarray, T_true: np.ndarray) -> float:
    """Distance of two poses in metres."""
    tensors = []
    for T in (T_predicted, T_true):
        tensors += [torch.tensor(T[None, :3, :3]).float(), torch.tensor(T[None, :3, 3] / SCALE).float()]
    return float(refined_distance(*tensors, torch.zeros(1, dtype=torch.long), SHAPES)[0]) * SCALE


@pytest.mark.parametrize("shift", [(0.1, 0.0, 0.0), (0.0, -0.03, 0.04)])
def test_a_shift_costs_its_length(shift: tuple[float, ...]) -> None:
    T = make_transform(rotation_z(0.3), np.array([0.2, 0.1, 0.4]))
    moved = T.copy()
    moved[:3, 3] += shift
    assert distance(moved, T) == pytest.approx(np.linalg.norm(shift), rel=1e-4)


def test_a_declared_half_turn_costs_nothing_and_another_turn_does() -> None:
    T = make_transform(rotation_x(0.4), np.array([0.2, 0.1, 0.4]))
    least = 1e-4 * SCALE  # what keeps the square root differentiable
    assert distance(T @ make_transform(rotation_z(np.pi)), T) == pytest.approx(least, rel=0.05)
    assert distance(T @ make_transform(rotation_z(np.pi / 2)), T) > 0.4
    assert distance(T @ make_transform(rotation_x(np.pi)), T) > 0.1


def test_distance_is_the_rms_distance_of_the_surface() -> None:
    rng = np.random.default_rng(0)
    points, _ = sample_surface(MESH, 100_000, np.random.default_rng(1))
    for _ in range(5):
        T_true = pose(rng)
        T = T_true @ make_transform(rotation_z(rng.normal(0, 0.2)) @ rotation_x(0.1), rng.normal(0, 0.05, 3))
        moved = transform_points(T, points) - transform_points(T_true, points)
        assert distance(T, T_true) == pytest.approx(np.sqrt((moved**2).sum(axis=1).mean()), rel=1e-4)


def test_quaternions_may_have_any_length_and_sign() -> None:
    quat = torch.tensor([[[0.5, 0.5, 0.5, 0.5], [-3.0, -3.0, -3.0, -3.0]]])
    hypotheses = Hypotheses(quat, torch.zeros(1, 2, 3), torch.zeros(1, 2))
    turn = torch.tensor([[[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]])
    found = hypotheses_distance(hypotheses, turn, torch.zeros(1, 3), torch.zeros(1, dtype=torch.long), SHAPES)
    assert found.max() < 5e-4


def test_loss_has_its_known_value() -> None:
    # c = 0.5: 0.2 * 0.5 + 0.08 * ln 2
    loss = confidence_loss(torch.full((2, 3), 0.2), torch.zeros(2, 3), 0.08)
    assert float(loss) == pytest.approx(0.1 + 0.08 * math.log(2), rel=1e-6)


def test_best_confidence_is_weight_over_distance() -> None:
    logit = torch.zeros(1, 1, requires_grad=True)
    optimiser = torch.optim.Adam([logit], lr=0.05)
    for _ in range(400):
        optimiser.zero_grad()
        confidence_loss(torch.tensor([[0.32]]), logit, 0.08).backward()
        optimiser.step()
    assert float(torch.sigmoid(logit.detach())) == pytest.approx(0.25, abs=2e-3)


def test_hopeless_confidence_stays_finite() -> None:
    logit = torch.tensor([[-500.0]], requires_grad=True)
    loss = confidence_loss(torch.tensor([[1.0]]), logit, 0.08)
    loss.backward()
    assert bool(torch.isfinite(loss))
    assert float(logit.grad) == pytest.approx(-0.08)
