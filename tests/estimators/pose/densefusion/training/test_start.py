from dataclasses import replace

import numpy as np
import pytest
import torch

from tests.estimators.pose.densefusion.made_crops import made_set, pallet_shape
from warehouse_sim.estimators import ESTIMATORS
from warehouse_sim.estimators.pose.densefusion.crops.batch import draw_batch
from warehouse_sim.estimators.pose.densefusion.networks.densefusion import DenseFusion
from warehouse_sim.estimators.pose.densefusion.rotations import matrix_from_quat_wxyz as matrices
from warehouse_sim.estimators.pose.densefusion.training.start import mean_quat_wxyz, start_at_mean_rotation
from warehouse_sim.geometry.pose import matrix_from_quat_wxyz, rotation_angle, rotation_x, rotation_z
from warehouse_sim.geometry.symmetry import SymmetryGroup

C2 = SymmetryGroup.turns("z", 2).transforms[:, :3, :3]


def test_mean_does_not_care_which_equivalent_was_given() -> None:
    base = rotation_x(0.5)
    angles = np.array([-0.2, -0.1, 0.0, 0.1, 0.2])
    rotations = np.stack([base @ rotation_z(a + np.pi * (k % 2)) for k, a in enumerate(angles)])
    mean = matrix_from_quat_wxyz(mean_quat_wxyz(rotations, C2))
    assert min(rotation_angle(mean @ S, base) for S in C2) < 1e-9


@pytest.mark.parametrize("name", ["densefusion-pointcloud", "object-coordinates"])
def test_an_untrained_network_proposes_about_the_mean(name: str) -> None:
    torch.manual_seed(0)
    config = ESTIMATORS.get(name).network("nano")
    crops = made_set(12, config.side_px)
    # The second class has no crops and is left alone.
    network = DenseFusion(config, 2).eval()
    start_at_mean_rotation(network, crops, (pallet_shape(), replace(pallet_shape(), obj_id=2)))
    batch = draw_batch(crops, torch.arange(12), 64, torch.Generator().manual_seed(0))
    with torch.inference_mode():
        found = matrices(network(batch.inputs).hypotheses.quat_wxyz).double().numpy()
    true = crops.T_camera_object[:, :3, :3].numpy()
    off = np.min([rotation_angle(found, (true @ S)[:, None]) for S in C2], axis=0)
    assert np.degrees(np.median(off)) < 35.0
