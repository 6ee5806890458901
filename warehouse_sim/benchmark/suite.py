"""A suite as its YAML file says it: data, conditions, estimators, and what is made of the scores."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any, Literal

from warehouse_sim.benchmark.groups import GROUPINGS, EdgeConfig, split_name
from warehouse_sim.config import load_yaml
from warehouse_sim.errors import ConfigError, UnknownNameError
from warehouse_sim.ranges import Range, Seed, ranged
from warehouse_sim.resources import data_folder, suite_names

Scenes = Annotated[int, Range(1, 1_000_000)]
Views = Annotated[int, Range(1, 1_000_000)]
ThirdParty = Literal["linemod", "kitti", "recorded"]


@dataclass(frozen=True)
@ranged
class DataConfig:
    """A dataset that a suite makes; all of it is scored, unless it is trained on."""

    recipe: str
    """Shipped recipe, or the path of a file."""
    seed: Seed
    """Seed of the dataset; nothing that is bundled was trained on it."""
    scenes: Scenes
    """Number of scenes, 1-1,000,000."""
    observations: Views
    """Observations of each scene, paired variants not counted, 1-1,000,000."""
    settings: dict[str, Any] = field(default_factory=dict)
    """What replaces settings of the recipe, as a file that extends it would."""
    formats: tuple[str, ...] = ("bop",)
    """Formats that are written; sweeps of a LiDAR are in kitti."""
    backend: str = "raster"
    """Render backend."""
    backend_options: dict[str, Any] = field(default_factory=dict)
    """Options of the backend that are not its defaults."""
    trained_on: bool = False
    """Whether it is for training: nine tenths to learn from, one to calibrate on, nothing is scored."""


@dataclass(frozen=True)
@ranged
class ConditionConfig:
    """What estimators are evaluated, and how."""

    data: str
    """Name of the data."""
    disturb: str = "exact"
    """What is done to detections or calibration before an estimator sees them, one of ``DISTURBANCES``."""
    predict: dict[str, Any] = field(default_factory=dict)
    """Settings of prediction that replace those of each estimator: detections, depth, gravity, calibration."""
    estimators: tuple[str, ...] = ()
    """Estimators to run; by default all of the suite."""
    seconds_an_object: Annotated[float, Range(0.001, 86_400, "s")] | None = None
    """Where given, 0.001-86,400 s: only the fixed subset is predicted, one by one; what takes longer is missed."""

    def __post_init__(self) -> None:
        if self.seconds_an_object is not None and self.disturb != "exact":
            raise ValueError("disturb must be exact where the fixed subset is predicted")


@dataclass(frozen=True)
@ranged
class LeastConfig:
    """What each dataset must have before it is sealed."""

    dockable: Annotated[int, Range(0, 1_000_000)] = 0
    """Pallets that docking is evaluated of, 0-1,000,000."""
    ground_truths: Annotated[int, Range(0, 1_000_000)] = 0
    """Ground truths that count, 0-1,000,000."""


@dataclass(frozen=True)
class CompareConfig:
    """A paired effect: the same ground truths, evaluated twice with one thing changed, or with two estimators."""

    factor: str
    """What differs, as tables call it."""
    variants: bool = False
    """Whether the paired variants of a dataset are compared, by the names of the variants; else conditions are."""
    against: str = "base"
    """The variant or condition that all others are compared with."""
    among: tuple[str, ...] = ()
    """Conditions that are compared; by default all but ``against``."""
    between: tuple[tuple[str, str], ...] = ()
    """Pairs of estimators, each compared with the second on what both were evaluated; of trainings of several lengths
    the name stands for the longest. Where there are such, neither paired variants nor conditions are compared."""
    by: str = "all"
    """Grouping of the pairs, by what the changed one is; a paired row for each group."""
    changed_only: bool = False
    """Whether only pairs count whose visible fraction differs, as in paired variants without their occluders."""


@dataclass(frozen=True)
@ranged
class TrainingConfig:
    """Networks that a suite trains itself; each is an estimator ``NAME@STEPS`` with one training a seed."""

    estimator: str
    """Registered estimator that must be trained."""
    data: tuple[str, ...]
    """Names of the data that it is trained on, all of them ``trained_on``."""
    steps: tuple[Annotated[int, Range(1, 1_000_000_000)], ...]
    """Optimiser steps, 1-1,000,000,000: one training of each length."""
    seeds: tuple[Seed, ...] = (0,)
    """One training each."""
    settings: dict[str, Any] = field(default_factory=dict)
    """Settings of training."""


@dataclass(frozen=True)
@ranged
class SizeConfig:
    """Another size of a dataset."""

    scenes: Scenes | None = None
    """Number of scenes, 1-1,000,000; None leaves it."""
    observations: Views | None = None
    """Observations of each scene, 1-1,000,000; None leaves it."""
    settings: dict[str, Any] | None = None
    """What replaces settings of the recipe in place of the suite's own; None leaves them."""


@dataclass(frozen=True)
@ranged
class ApproachConfig:
    """Which approaches a simulated truck drives with an estimator in the loop."""

    recipes: tuple[str, ...] = ()
    """Where scenes come from; none drives nothing."""
    seed: Seed = 0
    """Of the scenes."""
    episodes: Annotated[int, Range(1, 1_000_000)] = 10
    """Starts of each recipe, 1-1,000,000."""
    levels: tuple[str, ...] = ("base",)
    """Conditions of docs/closed_loop.md."""
    estimators: tuple[str, ...] = ()
    """Which estimators of the suite drive; by default all that read images. The ground truth always drives."""


@dataclass(frozen=True)
@ranged
class NegativesConfig:
    """In which halls estimators are shown what must not be taken."""

    recipes: tuple[str, ...] = ()
    """Where halls come from; none shows nothing."""
    seed: Seed = 0
    """Of the halls."""
    scenes: Scenes = 10
    """Halls of each recipe, 1-1,000,000."""
    places: Annotated[int, Range(1, 1000)] = 2
    """Cameras in each, 1-1,000; before each stand a pallet and five negatives in turn."""


@dataclass(frozen=True)
@ranged
class QuickConfig:
    """What ``--quick`` changes: sizes, never how a number is made."""

    estimators: tuple[str, ...] | None = None
    """Estimators to run; None for all of the suite."""
    data: dict[str, SizeConfig] = field(default_factory=dict)
    """Sizes of the data."""
    conditions: tuple[str, ...] | None = None
    """Those that are evaluated; None for all."""
    steps: tuple[Annotated[int, Range(1, 1_000_000_000)], ...] | None = None
    """Lengths of the trainings, 1-1,000,000,000; None for those of the suite."""
    seeds: tuple[Seed, ...] | None = None
    """Seeds of the trainings; None for those of the suite."""
    trainings: tuple[str, ...] | None = None
    """Those that are made; None for all."""
    simulated_poses: Annotated[int, Range(1, 1_000_000)] | None = None
    """Poses of each answer, 1-1,000,000; None for those of the suite."""
    approach: ApproachConfig | None = None
    """Approaches; None for those of the suite."""
    negatives: NegativesConfig | None = None
    """Negatives; None for those of the suite."""


@dataclass(frozen=True)
@ranged
class Suite:
    """One question of the benchmark."""

    version: Annotated[int, Range(1, 1000)]
    """Counts up when recipe, seeds, conditions or metrics change, 1-1,000: do not compare numbers of two versions."""
    question: str
    """Its question, in one sentence."""
    dissertation: str = ""
    """Tables and figures of the dissertation with the same question; empty without one."""
    data: dict[str, DataConfig] = field(default_factory=dict)
    """Datasets to generate, by name."""
    estimators: tuple[str, ...] = ()
    """Estimators by default: ``oracle`` and ``shuffled`` bound every metric, then a baseline."""
    conditions: dict[str, ConditionConfig] = field(default_factory=dict)
    """What is evaluated, by name; by default each dataset as it is."""
    metrics: tuple[str, ...] = ("add_2pct", "add_5pct", "add_10pct", "pose_5cm_5deg", "dock_0mm", "dock_20mm")
    """Columns of the tables."""
    by: tuple[str, ...] = ("all",)
    """Groupings of the ground truths; two joined by `` x `` make a group of each pair."""
    edges: EdgeConfig = field(default_factory=EdgeConfig)
    """Where the bins of groupings begin and end."""
    compare: tuple[CompareConfig, ...] = ()
    """Paired effects."""
    least: LeastConfig = field(default_factory=LeastConfig)
    """What each dataset must have before it is sealed."""
    worst_first: bool = False
    """Whether the headline is the condition in which each estimator docks least."""
    curves: bool = False
    """Whether accuracy over threshold and quantiles of the error are given."""
    detectors: tuple[str, ...] = ()
    """Detectors whose boxes and masks are scored: ``gt``, names, run folders, files of results."""
    trainings: dict[str, TrainingConfig] = field(default_factory=dict)
    """Networks that are trained first."""
    simulate: bool = False
    """Whether a simulated truck drives to the poses."""
    simulated_poses: Annotated[int, Range(1, 1_000_000)] = 100
    """To how many poses of each answer, 1-1,000,000."""
    approach: ApproachConfig = field(default_factory=ApproachConfig)
    """Approaches with an estimator in the loop."""
    negatives: NegativesConfig = field(default_factory=NegativesConfig)
    """What must not be taken."""
    takes: tuple[ThirdParty, ...] = ()
    """Kinds of folders that --data takes in place of the suite's own data."""
    quick: QuickConfig = field(default_factory=QuickConfig)
    """What ``--quick`` changes."""
    name: str = ""
    """Filled in from the file's name."""

    def __post_init__(self) -> None:
        for grouping in (*self.by, *(item.by for item in self.compare)):
            for name in split_name(grouping):
                if name not in GROUPINGS:
                    raise ConfigError(f"by: {name!r} is no grouping; known: {', '.join(sorted(GROUPINGS))}")

    @property
    def title(self) -> str:
        """Name and version, such as ``industrial-v1``."""
        return f"{self.name}-v{self.version}"

    @property
    def evaluated(self) -> Mapping[str, ConditionConfig]:
        """What is evaluated, by name."""
        whole = {name: ConditionConfig(name) for name, item in self.data.items() if not item.trained_on}
        return self.conditions or whole


def load_suite(name_or_path: str) -> Suite:
    """Read a suite by shipped name ("industrial") or path.

    Raises:
        UnknownNameError: Neither a shipped name nor a file.
        ConfigError: The file holds something that a suite does not take, or names data that it lacks.
    """
    path = Path(name_or_path)
    if path.suffix not in (".yaml", ".yml"):
        if name_or_path not in suite_names():
            raise UnknownNameError("suite (a shipped name or the path of a .yaml file)", name_or_path, suite_names())
        path = data_folder("benchmarks") / "suites" / f"{name_or_path}.yaml"
    suite = load_yaml(Suite, path)
    _require_data(suite, path)
    return suite if suite.name else replace(suite, name=path.stem)


def _require_data(suite: Suite, path: Path) -> None:
    for name, condition in suite.conditions.items():
        if condition.data not in suite.data:
            raise ConfigError(f"{path}: conditions: {name}: there is no data {condition.data!r}")
    for name, training in suite.trainings.items():
        unknown = [item for item in training.data if item not in suite.data or not suite.data[item].trained_on]
        if unknown:
            raise ConfigError(f"{path}: trainings: {name}: {unknown[0]!r} is no data that are trained_on")


def quickened(suite: Suite) -> Suite:
    """Return a suite at the sizes of ``--quick``.

    Raises:
        ConfigError: ``quick`` names data, conditions or trainings that the suite lacks.
    """
    quick = suite.quick
    known = {"data": suite.data, "conditions": suite.evaluated, "trainings": suite.trainings}
    given = {"data": quick.data, "conditions": quick.conditions or (), "trainings": quick.trainings or ()}
    for key, names in given.items():
        if strange := [name for name in names if name not in known[key]]:
            raise ConfigError(f"{suite.name}: quick: {key}: there is no {strange[0]!r}")
    trainings = {
        name: replace(item, steps=quick.steps or item.steps, seeds=quick.seeds or item.seeds)
        for name, item in suite.trainings.items()
        if quick.trainings is None or name in quick.trainings
    }
    conditions = {
        name: item for name, item in suite.evaluated.items() if quick.conditions is None or name in quick.conditions
    }
    used = {item.data for item in conditions.values()} | {name for item in trainings.values() for name in item.data}
    data = {name: _resized(item, quick.data.get(name)) for name, item in suite.data.items() if name in used}
    return replace(
        suite,
        estimators=suite.estimators if quick.estimators is None else quick.estimators,
        data=data,
        conditions=conditions,
        trainings=trainings,
        simulated_poses=quick.simulated_poses or suite.simulated_poses,
        approach=quick.approach or suite.approach,
        negatives=quick.negatives or suite.negatives,
    )


def _resized(data: DataConfig, size: SizeConfig | None) -> DataConfig:
    if size is None:
        return data
    return replace(
        data,
        scenes=size.scenes or data.scenes,
        observations=size.observations or data.observations,
        settings=data.settings if size.settings is None else size.settings,
    )
