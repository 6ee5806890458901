"""A run folder with untrained weights, as training leaves one."""

from dataclasses import replace
from pathlib import Path

import torch

from tests.dataset.toy import PALLET
from tests.estimators.pose.densefusion.made_crops import pallet_shape
from warehouse_sim.estimators.pose.densefusion.networks.densefusion import DenseFusion, PoseRun
from warehouse_sim.estimators.pose.densefusion.objects import write_meshes
from warehouse_sim.estimators.pose.densefusion.settings import Preset, Size, TrainConfig, with_preset
from warehouse_sim.estimators.pose.densefusion.training.preparation import crop_of, network_of
from warehouse_sim.estimators.registries import ESTIMATORS
from warehouse_sim.learning.run_folder import Source, write_weights


def made_run(
    run: Path,
    name: str = "densefusion-pointcloud",
    object_name: str = "toy-pallet",
    obj_id: int = 1,
    size: Size = "nano",
    preset: Preset = "plain",
) -> Path:
    """A run folder that knows the toy pallet."""
    run.mkdir()
    train = with_preset(TrainConfig(size=size), preset)
    network = network_of(ESTIMATORS.get(name), train)
    shape = replace(pallet_shape(), obj_id=obj_id, name=object_name, class_name="pallet")
    source = Source("toy", "0" * 64)
    made = {"objects": (shape,), "network": network, "crop": crop_of(network), "train": train}
    PoseRun(estimator=name, version="0", datasets=(source,), **made).write(run)
    torch.manual_seed(0)
    write_weights(run, DenseFusion(network, 1))
    write_meshes(run, {obj_id: PALLET.mesh()})
    return run
