"""A run folder with untrained weights, as training leaves one."""

from dataclasses import replace
from pathlib import Path

import torch

from tests.dataset.toy import PALLET
from tests.estimators.pose.densefusion.made_crops import pallet_shape
from warehouse_sim.estimators import ESTIMATORS
from warehouse_sim.estimators.pose.densefusion.crops import CropConfig
from warehouse_sim.estimators.pose.densefusion.networks.densefusion import DenseFusion
from warehouse_sim.estimators.pose.densefusion.object_meshes import write_meshes
from warehouse_sim.estimators.pose.densefusion.run_config import RunConfig, write_config
from warehouse_sim.estimators.pose.densefusion.settings import Size, TrainConfig
from warehouse_sim.learning.run_folder import DatasetSource, write_weights


def made_run(
    run: Path,
    name: str = "densefusion-pointcloud",
    object_name: str = "toy-pallet",
    obj_id: int = 1,
    size: Size = "nano",
) -> Path:
    """A run folder that knows the toy pallet."""
    run.mkdir()
    network = ESTIMATORS.get(name).network(size)
    shape = replace(pallet_shape(), obj_id=obj_id, name=object_name, class_name="pallet")
    crop = CropConfig(side_px=network.side_px, rgb=network.reads_rgb, depth=network.reads_depth)
    write_config(run, RunConfig(name, "0", (DatasetSource("toy", "0" * 64),), (shape,), network, crop, TrainConfig()))
    torch.manual_seed(0)
    write_weights(run, DenseFusion(network, 1))
    write_meshes(run, {obj_id: PALLET.mesh()})
    return run
