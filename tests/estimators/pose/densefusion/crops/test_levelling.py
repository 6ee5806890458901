import numpy as np
import torch

from warehouse_sim.estimators.gravity import upright_frame
from warehouse_sim.estimators.pose.densefusion.crops.levelling import is_known, level_turns

CAMERA_IN_UPRIGHT = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
"""Right, down and ahead of a level camera in the upright frame: x ahead, y left, z up."""


def test_turns_are_those_of_the_upright_frame() -> None:
    rng = np.random.default_rng(0)
    for down in rng.normal(size=(20, 3)):
        down /= np.linalg.norm(down)
        R = level_turns(torch.tensor(down)[None].float())[0]
        expected = (upright_frame(down) @ CAMERA_IN_UPRIGHT).T
        torch.testing.assert_close(R, torch.tensor(expected).float(), atol=1e-5, rtol=0)
        torch.testing.assert_close(R @ torch.tensor(down).float(), torch.tensor([0.0, 1.0, 0.0]), atol=1e-6, rtol=0)


def test_a_level_camera_and_one_of_which_nothing_is_known_are_not_turned() -> None:
    down = torch.tensor([[0.0, 1.0, 0.0], [torch.nan] * 3])
    torch.testing.assert_close(level_turns(down), torch.eye(3).expand(2, 3, 3))
    assert is_known(down).tolist() == [True, False]


def test_a_camera_that_looks_straight_down_has_its_upper_border_ahead() -> None:
    (R,) = level_turns(torch.tensor([[0.0, 0.0, 1.0]]))
    torch.testing.assert_close(R @ torch.tensor([0.0, -1.0, 0.0]), torch.tensor([0.0, 0.0, 1.0]))
