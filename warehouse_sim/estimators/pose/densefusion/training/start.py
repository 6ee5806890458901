"""What a training begins with: the mean pose of its data, or the weights of another run."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import torch
from jaxtyping import Float

from warehouse_sim.errors import TrainingError
from warehouse_sim.estimators.pose.densefusion.crops.crop_set import CropSet
from warehouse_sim.estimators.pose.densefusion.networks.densefusion import DenseFusion, DenseFusionConfig, PoseRun
from warehouse_sim.estimators.pose.densefusion.objects import ObjectShape
from warehouse_sim.estimators.pose.densefusion.settings import TrainConfig
from warehouse_sim.geometry.pose import matrix_from_quat_wxyz, quat_wxyz_from_matrix
from warehouse_sim.learning.compute import shapes_only
from warehouse_sim.learning.job import starting_weights
from warehouse_sim.learning.run_folder import WEIGHTS, StartingWeights
from warehouse_sim.resources import model_dir

_ROUNDS = 5


def start_at_mean_rotation(network: DenseFusion, crops: CropSet, shapes: tuple[ObjectShape, ...]) -> None:
    """Make ``network`` propose about the mean rotation of each class of which there are crops.

    From an arbitrary start the two looks of a half-turn symmetry are about equally far, samples choose different
    ones, and the network first has to agree with itself.
    """
    for number, shape in enumerate(shapes):
        rotations = crops.T_camera_object[crops.class_index == number, :3, :3].cpu().numpy()
        if len(rotations) == 0:
            continue
        symmetries = np.reshape(shape.symmetries, (-1, 4, 4))[:, :3, :3]
        quat = torch.from_numpy(mean_quat_wxyz(rotations, symmetries))
        network.heads.start_rotation(number, quat)


def mean_quat_wxyz(
    rotations: Float[np.ndarray, "k 3 3"], symmetries: Float[np.ndarray, "g 3 3"]
) -> Float[np.ndarray, " 4"]:
    """Return the mean of ``rotations``, each replaced by the symmetric equivalent nearest to that mean.

    Args:
        rotations: At least one.
        symmetries: Rotations of the object's symmetry group.
    """
    equivalents = rotations[:, None] @ symmetries
    mean = rotations[0]
    for _ in range(_ROUNDS):
        nearest = np.einsum("kgij,ij->kg", equivalents, mean).argmax(axis=1)
        aligned = equivalents[np.arange(len(rotations)), nearest]
        # Markley's mean: the eigenvector is linear in the rotation matrices.
        quat = quat_wxyz_from_matrix(aligned.mean(axis=0))
        mean = matrix_from_quat_wxyz(quat)
    return quat


_TAKEN_OVER = ("size", "paper", "surroundings", "upright", "augment", "loss")
"""Settings of a run that weights were made for: inputs, and what was disturbed and minimised."""


def start_from(
    name_or_run: str | Path, network: DenseFusion, shapes: Sequence[ObjectShape], all_known: bool = False
) -> StartingWeights:
    """Copy the weights of a bundled estimator or a run into ``network``; objects are matched by name.

    What a network keeps for each object is copied where both know the object. Other objects keep what ``network``
    holds for them.

    Args:
        name_or_run: Bundled name or run folder.
        network: Where to.
        shapes: The objects that it knows, in the order of its classes.
        all_known: Whether the run must know them all, since nothing will train what it lacks.

    Raises:
        UnknownNameError: Neither a bundled name nor a folder.
        TrainingError: The run is incomplete, its network is another one, or it does not know an object that it must.
    """
    folder = model_dir(name_or_run)
    old = PoseRun.read(folder)
    if old.network != network.config:
        raise TrainingError(_misfit(name_or_run, old, network.config))
    source = old.load_network(folder).state_dict()
    known = {shape.name: number for number, shape in enumerate(old.objects)}
    if all_known and (others := [shape.name for shape in shapes if shape.name not in known]):
        raise TrainingError(
            f"{name_or_run} does not know {', '.join(others)}, and a phase that trains the refiner alone cannot teach "
            f"them; train without them: --objects {' '.join(known)}"
        )
    pairs = [(number, known[shape.name]) for number, shape in enumerate(shapes) if shape.name in known]
    per_object = per_object_tensors(network.config)
    with torch.no_grad():
        for name, target in network.state_dict().items():
            if name not in per_object:
                target.copy_(source[name])
                continue
            for here, there in pairs:
                target[here].copy_(source[name][there])
    return starting_weights(name_or_run, folder / WEIGHTS)


def settings_from(name_or_run: str | Path, config: TrainConfig) -> TrainConfig:
    """Return settings for going on with weights: those left at their defaults are theirs, where inputs hang on them.

    Args:
        name_or_run: Bundled name or run folder.
        config: What was requested.

    Raises:
        UnknownNameError: Neither a bundled name nor a folder.
        TrainingError: The run is incomplete.
    """
    old, default = PoseRun.read(model_dir(name_or_run)).train, TrainConfig()
    taken = {name: getattr(old, name) for name in _TAKEN_OVER if getattr(config, name) == getattr(default, name)}
    return replace(config, **taken)


def per_object_tensors(config: DenseFusionConfig) -> set[str]:
    """Return the names of the weights with one row an object: those that grow with the number of objects."""
    with shapes_only():
        one, two = (DenseFusion(config, classes).state_dict() for classes in (1, 2))
    return {name for name in one if one[name].shape != two[name].shape}


def _misfit(name_or_run: str | Path, old: PoseRun, network: DenseFusionConfig) -> str:
    parts = [name for name in ("points", "heads", "refiner", "images", "fusion", "inliers", "upright")
             if getattr(old.network, name) != getattr(network, name)]  # fmt: skip
    kinds = ("paper", "surroundings", "upright")
    more = "".join(f" --{name}" for name in kinds if getattr(old.train, name))
    kinds_text = "".join(f", {name}" for name in kinds if getattr(old.train, name))
    return (
        f"{name_or_run} holds weights of {old.estimator}, size {old.train.size}{kinds_text}, which do not fit "
        f"(other {', '.join(parts)}); train {old.estimator} with --size {old.train.size}{more}, or without --init"
    )
