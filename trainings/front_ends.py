"""Train the front ends: the recipe of the detectors and segmenters in models/.

python -m trainings.front_ends [--methods detector-depth ...] [--minutes 60] [--batch 8]
    [--generate-only | --cache-only] [--workers 16] [--no-pose-sets]

What is missing is generated first. Every training can be interrupted, and goes on when the command is given again.
"""

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from multiprocessing import get_context
from pathlib import Path

import tyro

from trainings.data import (
    CARTON_SETS,
    FRONT_ENDS,
    FULLY_LABELLED,
    POSE_SETS,
    TARGETS,
    WITH_SWEEPS,
    Data,
    made,
)
from trainings.data import FOLDER as POSE_FOLDER
from trainings.poses import FIRST
from trainings.warehouses import finished
from warehouse_sim.estimators.detectors.settings import DetectorConfig
from warehouse_sim.estimators.images.faces import FACE
from warehouse_sim.estimators.images.settings import ImageAugmentConfig
from warehouse_sim.estimators.lidar.sweep.settings import SweepDetectorConfig
from warehouse_sim.estimators.pose.densefusion.settings import TrainConfig, with_preset
from warehouse_sim.estimators.segmenters.segnet.settings import SegmenterConfig
from warehouse_sim.estimators.train import train, trainable
from warehouse_sim.learning.settings import LoopConfig
from warehouse_sim.learning.trainable import TrainableNetwork
from warehouse_sim.processes import prepare_worker

_AT_ONCE = 4
"""Datasets that are generated side by side: the meshes of a dataset are made by one process."""


@dataclass(frozen=True)
class Plan:
    """How one front end is trained."""

    config: DetectorConfig | SegmenterConfig | SweepDetectorConfig | TrainConfig
    """How."""
    own: tuple[Data, ...] = ()
    """Sets made for front ends."""
    pose: tuple[Data, ...] = ()
    """Sets of the pose estimators beside them."""
    init: str = ""
    """Front end whose weights it begins with, if that is trained."""

    def limited(
        self,
        minutes: float | None,
        steps: int | None,
        batch: int | None,
        workers: int,
        threads: int,
        learning_rate: float | None = None,
    ) -> "Plan":
        """Return the same within some time, for a machine."""
        config = replace(
            self.config,
            max_minutes=minutes,
            max_steps=steps,
            batch=batch or self.config.batch,
            learning_rate=learning_rate or self.config.learning_rate,
            workers=workers,
            threads=threads,
        )
        return replace(self, config=config)

    def folders(self, folder: Path, pose_folder: Path | None, workers: int) -> list[Path]:
        """Return the dataset folders, made if they are missing; None leaves out those of the pose estimators."""
        own = [made(item, folder, workers) for item in self.own]
        return own + ([made(item, pose_folder, workers) for item in self.pose] if pose_folder else [])


_DETECTOR = DetectorConfig(batch=32, learning_rate=2e-3, validations=6, precision="auto")
_PALLETS = replace(_DETECTOR, classes=("pallet",))
_SEGMENTER = SegmenterConfig(batch=32, learning_rate=2e-3, validations=6)
_SWEEPS = SweepDetectorConfig(batch=32, learning_rate=2e-3, validations=6, precision="auto", classes=("pallet",))
_EVERY_POSE_SET = (*POSE_SETS, *CARTON_SETS)
PLANS = {
    "detector-depth": Plan(_PALLETS, FULLY_LABELLED, POSE_SETS),
    # People and trucks of the other sets have no labels, and would be taught as empty floor.
    "detector-rgb": Plan(replace(_DETECTOR, classes=TARGETS), FULLY_LABELLED, init="detector-depth"),
    "detector-lidar": Plan(replace(_PALLETS, depth_source="lidar"), WITH_SWEEPS, init="detector-depth"),
    "segmenter-depth": Plan(_SEGMENTER, FULLY_LABELLED, _EVERY_POSE_SET),
    "keypoints-rgb": Plan(_SEGMENTER, FULLY_LABELLED, _EVERY_POSE_SET),
    "segmenter-rgb": Plan(_SEGMENTER, FULLY_LABELLED, _EVERY_POSE_SET),
    "detector-rgbd": Plan(_PALLETS, FULLY_LABELLED, POSE_SETS),
    "detector-sweep": Plan(_SWEEPS, WITH_SWEEPS, init="detector-depth"),
}
"""By method, those first whose weights chains need most."""
_WIDE = replace(_DETECTOR, input_wh=(640, 384))
"""A warehouse's pallets are small: a D455's image at three quarters of its size."""
_POSES = with_preset(replace(FIRST.config, objects=("pallet",)), "robust")
KINDS = (
    "epal1",
    "epal2",
    "epal3",
    "epal6",
    "epal7",
    "gma_48x40",
    "blue_block_1200x1000",
    "plastic_runners",
    "plastic_nestable",
)
"""The pallets of the catalog, which the segmenter distinguishes."""
_PALLET_MASKS = replace(_SEGMENTER, classes=("pallet",), kinds=KINDS, precision="auto")
_ANY_CAMERA = ImageAugmentConfig(zoom=2.0, camera=0.6)
IN_WAREHOUSES = {
    "detector-depth": Plan(replace(_WIDE, classes=("pallet",))),
    "segmenter-depth": Plan(_PALLET_MASKS),
    "segmenter-rgb": Plan(_PALLET_MASKS),
    "segmenter-rgbd": Plan(_PALLET_MASKS),
    "densefusion-depth": Plan(_POSES),
    "detector-rgb": Plan(replace(_WIDE, classes=(*TARGETS, FACE), augment=_ANY_CAMERA)),
    "densefusion-middle-2": Plan(_POSES),
    "detector-rgbd": Plan(replace(_WIDE, classes=("pallet",))),
}
"""Trained on the parts of ``warehouses`` alone, in any layout."""


def main(
    folder: Path = FRONT_ENDS,
    methods: tuple[str, ...] = (),
    minutes: float | None = 60.0,
    steps: int | None = None,
    batch: int | None = None,
    workers: int = os.cpu_count() or 1,
    threads: int = 1,
    cache: Path | None = None,
    pose_folder: Path = POSE_FOLDER,
    pose_sets: bool = True,
    generate_only: bool = False,
    cache_only: bool = False,
    warehouses: Path | None = None,
    init: str = "",
    learning_rate: float | None = None,
) -> None:
    """Train what is not trained yet; runs that were interrupted go on.

    Args:
        folder: Where data and runs are kept.
        methods: Which front ends; all by default.
        minutes: Most minutes each trains; 11 on a GPU, 60 on a CPU.
        steps: Most optimiser steps; by default the time alone decides.
        batch: Samples a step, by default 32; 8 learns more in an hour of a CPU.
        workers: Processes that generate, threads that decode and compose.
        threads: CPU threads of a network.
        cache: Where images are kept, by default beside the data.
        pose_folder: Where data of the pose estimators are kept.
        pose_sets: Train on those, too.
        generate_only: Make the data and stop.
        cache_only: Read all images into the cache and stop, one process a method.
        warehouses: Train on the finished parts of this folder alone, see ``trainings.warehouses``.
        init: Bundled weights or run folder that training on warehouses begins with.
        learning_rate: Highest one, by default 0.002; training that begins with trained weights wants less.
    """
    kept, pose = cache or folder / "cache", pose_folder if pose_sets else None
    if warehouses is not None:
        for name in methods or tuple(IN_WAREHOUSES):
            plan = IN_WAREHOUSES[name].limited(minutes, steps, batch, workers, threads, learning_rate)
            _train(name, finished(warehouses), folder / "runs" / name, plan.config, kept, init)
        return
    plans = {
        name: PLANS[name].limited(minutes, steps, batch, workers, threads, learning_rate)
        for name in in_order(methods or tuple(PLANS))
    }
    generate_missing(list(plans.values()), folder, pose, workers)
    if generate_only:
        return
    if cache_only:
        _at_once([partial(read_ahead, name, plan, folder, pose, kept) for name, plan in plans.items()], len(plans))
        return
    for name, plan in plans.items():
        first = folder / "runs" / plan.init
        started = str(first) if plan.init and (first / "result.json").is_file() else ""
        _train(name, plan.folders(folder, pose, workers), folder / "runs" / name, plan.config, kept, started)


def _train(name: str, data: Sequence[Path], run: Path, config: LoopConfig, cache: Path, init: str) -> None:
    """Train unless that is done, or go on with it."""
    if not (run / "result.json").is_file():
        resume = run.exists()
        train(name, data, run, config, resume=resume, init=None if resume else init or None, cache=cache)
        print(f"{name}: {(run / 'result.json').read_text()}")


def in_order(methods: Sequence[str]) -> list[str]:
    """Return the methods, those first that chains need most.

    Raises:
        SystemExit: A name is none of ``PLANS``.
    """
    if unknown := [name for name in methods if name not in PLANS]:
        raise SystemExit(f"{unknown[0]} is no front end; there are: {', '.join(PLANS)}")
    return [name for name in PLANS if name in methods]


def generate_missing(plans: Sequence[Plan], folder: Path, pose_folder: Path | None, workers: int) -> None:
    """Make the datasets that are missing, several side by side."""
    wanted = {item: folder for plan in plans for item in plan.own}
    if pose_folder:
        wanted |= {item: pose_folder for plan in plans for item in plan.pose}
    missing = [
        (item, place)
        for item, place in wanted.items()
        if not (place / "data" / item.folder_name / "manifest.json").is_file()
    ]
    fraction = max(1, workers // max(1, min(_AT_ONCE, len(missing))))
    _at_once([partial(made, item, place, fraction) for item, place in missing], min(_AT_ONCE, workers))


def read_ahead(name: str, plan: Plan, folder: Path, pose_folder: Path | None, cache: Path) -> None:
    """Read the images that a method is trained on into the cache."""
    method = trainable(name)
    assert isinstance(method, TrainableNetwork)  # of this package
    method.make_job(plan.folders(folder, pose_folder, 1), folder / "runs" / name, plan.config, cache).start()
    print(f"{name}: images are read")


def _at_once(works: Sequence[Callable[[], object]], processes: int) -> None:
    if not works:
        return
    with ProcessPoolExecutor(max(1, processes), get_context("spawn"), prepare_worker) as pool:
        for future in [pool.submit(work) for work in works]:
            future.result()


if __name__ == "__main__":
    tyro.cli(main)
