"""From dataset folders to what a training begins with: crops, configuration, and the mean pose or weights of a run."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from pathlib import Path

import numpy as np
import torch
from jaxtyping import Float

from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.errors import TrainingError
from warehouse_sim.estimators.pose.densefusion.crops.crop_set import CropSet, load_crops, table_of
from warehouse_sim.estimators.pose.densefusion.methods import Method
from warehouse_sim.estimators.pose.densefusion.networks.densefusion import DenseFusion, DenseFusionConfig, PoseRun
from warehouse_sim.estimators.pose.densefusion.objects import ObjectShape, measure_shape
from warehouse_sim.estimators.pose.densefusion.settings import CropConfig, TrainConfig
from warehouse_sim.estimators.pose.densefusion.training.streamed_crops import StreamedCrops
from warehouse_sim.geometry.pose import matrix_from_quat_wxyz, quat_wxyz_from_matrix
from warehouse_sim.learning.compute import shapes_only
from warehouse_sim.learning.job import starting_weights
from warehouse_sim.learning.run_folder import WEIGHTS, Source, dataset_sources, package_version
from warehouse_sim.learning.samples.array_store import Arrays
from warehouse_sim.learning.samples.split import reports_reading, require_other_scenes
from warehouse_sim.learning.settings import Progress
from warehouse_sim.learning.trainable import OpenStream
from warehouse_sim.resources import model_dir

_RIM_PX = 6
"""About twice what an outline is off."""
_SURFACE_POINTS = 128
"""Surface points of an object in losses over them."""


@dataclass(frozen=True, eq=False)
class Prepared:
    """What a training runs on."""

    crops: dict[str, CropSet]
    """By split, "train" and "val"; of a stream "val" alone."""
    classes: tuple[str, ...]
    """Class name of each of the run's objects."""
    config: PoseRun
    """The resolved configuration."""
    streamed: StreamedCrops | None = None
    """What is trained on in place of "train", where it is made meanwhile."""

    @property
    def first_crops(self) -> CropSet:
        """What training sees before its first step."""
        return self.crops["train"] if self.streamed is None else self.streamed.window(0)


def prepare(
    method: Method,
    data: Sequence[Path],
    config: TrainConfig,
    cache: Path | None,
    progress: Progress | None,
    open_stream: OpenStream | None = None,
) -> Prepared:
    """Cut all targets of train and val out of the images of the datasets and measure the objects that occur.

    Where ``config`` names a stream, that takes the place of train, and all objects of the datasets are known.

    Args:
        method: What is trained.
        data: Dataset folders; their objects must agree where they share a number.
        config: Settings.
        cache: Folder to keep crops in; None keeps them in memory.
        progress: Called with what is read.
        open_stream: Opens the stream that ``config`` names.

    Raises:
        DatasetError: A folder is no dataset with BOP files.
        TrainingError: A split is empty, the stream would show scenes of the data, val holds objects that train lacks,
            or the datasets do not fit together.
    """
    if not data:
        raise TrainingError("there is nothing to train on: name at least one dataset folder")
    readers = [DatasetReader(folder) for folder in data]
    objects = common_objects(readers)
    wanted = _wanted_objects(objects, config.objects)
    network = network_of(method, config)
    crop = crop_of(network)
    streams = bool(config.stream.recipe)
    if streams:
        require_other_scenes(readers, config.stream)
    found: dict[str, list[Arrays]] = {}
    for split in ("val",) if streams else ("train", "val"):
        reads = [
            load_crops(reader, split, crop, config.workers, cache, reports_reading(progress, split, reader))
            for reader in readers
        ]
        found[split] = [arrays for arrays in reads if arrays is not None]
    known = _known_objects(found, wanted, crop, data, streams)
    rng = np.random.default_rng(config.seed)
    surface = _SURFACE_POINTS if config.loss.reads_surface else 0
    sees_print = network.reads_rgb and config.loss.symmetry != "shape"
    shapes = tuple(measure_shape(objects[obj_id], rng, sees_print, surface) for obj_id in known)
    classes = tuple(objects[obj_id].class_name for obj_id in known)
    return Prepared(
        streamed=StreamedCrops(open_stream, config, crop, shapes, classes) if streams else None,
        crops={split: _crop_set(parts, shapes) for split, parts in found.items()},
        classes=classes,
        config=PoseRun(
            estimator=method.name,
            version=package_version(),
            datasets=dataset_sources(readers),
            objects=shapes,
            network=network,
            crop=crop,
            train=config,
        ),
    )


def network_of(method: Method, config: TrainConfig) -> DenseFusionConfig:
    """Return the network of a method with the inputs that the settings require.

    Raises:
        TrainingError: The original's quirks are requested, and inputs that it does not have.
    """
    if config.paper and (config.surroundings or config.upright):
        raise TrainingError("the original has neither surroundings nor gravity; leave out --paper or those")
    network = method.network(config.size, config.paper)
    refiner = network.refiner if config.refiner_iterations else None
    return replace(network, refiner=refiner, inliers=config.surroundings, upright=config.upright)


def crop_of(network: DenseFusionConfig) -> CropConfig:
    """Return how targets are cut out for a network."""
    crop = CropConfig(network.side_px, network.reads_rgb, network.reads_depth)
    if not network.inliers:
        return crop
    return replace(crop, surround_px=_RIM_PX, stored_points=2 * crop.stored_points)


def common_objects(readers: Sequence[DatasetReader]) -> dict[int, ObjectInfo]:
    """Return the objects of all datasets by number.

    Raises:
        TrainingError: One number stands for two geometries.
    """
    objects: dict[int, ObjectInfo] = {}
    for reader in readers:
        for obj_id, info in reader.objects.items():
            other = objects.setdefault(obj_id, info)
            # The mean box of a class without CAD differs from dataset to dataset.
            same_size = abs(info.diameter - other.diameter) <= 1e-4 or not (info.has_cad or other.has_cad)
            if info.name != other.name or not same_size:
                raise TrainingError(
                    f"object {obj_id} is {info.name} ({info.diameter:.3f} m across) in {reader.root} but {other.name} "
                    f"({other.diameter:.3f} m) in {other.root}; train on datasets that number their objects alike"
                )
    return objects


def _wanted_objects(objects: dict[int, ObjectInfo], patterns: Sequence[str]) -> set[int]:
    """Return the numbers of the objects whose name or class matches a pattern; all without patterns."""
    for pattern in patterns:
        if not any(_matches(info, pattern) for info in objects.values()):
            names = ", ".join(sorted({info.name for info in objects.values()}))
            raise TrainingError(f"no object or class of the datasets is called {pattern!r}; objects: {names}")
    return {i for i, info in objects.items() if not patterns or any(_matches(info, pattern) for pattern in patterns)}


def _matches(info: ObjectInfo, pattern: str) -> bool:
    return fnmatchcase(info.name, pattern) or info.class_name == pattern


def _known_objects(
    found: dict[str, list[Arrays]], wanted: set[int], crop: CropConfig, data: Sequence[Path], streams: bool
) -> list[int]:
    """Return the numbers of the objects that training sees."""
    folders = ", ".join(map(str, data))
    seen = {
        split: {int(obj_id) for arrays in parts for obj_id in np.unique(arrays["obj_id"])} & wanted
        for split, parts in found.items()
    }
    for split, obj_ids in seen.items():
        if not obj_ids:
            raise TrainingError(
                f"{folders}: the split {split!r} has no target with visible fraction >= {crop.min_visible_fraction} "
                f"and {crop.min_points} depth readings; generate more scenes"
            )
    if streams:
        return sorted(wanted)
    if unknown := sorted(seen["val"] - seen["train"]):
        raise TrainingError(f"{folders}: objects {unknown} of val do not occur in train; generate more scenes")
    return sorted(seen["train"])


def _crop_set(parts: Sequence[Arrays], shapes: Sequence[ObjectShape]) -> CropSet:
    tables = [table_of(arrays, shapes) for arrays in parts]
    classes = torch.cat([table.class_index for table in tables])
    return CropSet(tables, None if (classes >= 0).all() else (classes >= 0).nonzero()[:, 0])


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
) -> Source:
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
    # A refiner that only one of them has begins afresh, or is left out.
    both_refine = old.network.refiner and network.config.refiner
    if replace(old.network, refiner=both_refine and old.network.refiner) != replace(
        network.config, refiner=both_refine and network.config.refiner
    ):
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
            if name not in source:
                continue
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
