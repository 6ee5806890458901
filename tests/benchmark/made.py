"""Two small datasets that every suite can run on: paired variants of each kind and a LiDAR; the same with occluders."""

import shutil
from dataclasses import replace
from itertools import islice
from pathlib import Path

from tests.shared import Shared
from warehouse_sim.benchmark.sets import made
from warehouse_sim.benchmark.suite import ApproachConfig, DataConfig, Suite

_PAIRED_VARIANTS = {
    "lights": [{"name": "dim 20 lx", "preset": "dim", "lux": 20}],
    "noise": [{"name": "d435", "rgbd": {"depth": "d435"}, "sample": 0}],
}
_SENSORS = {"rig": "dissertation", "camera": {"width": 612, "height": 185, "focal_px": 360.8}}
FREE = DataConfig("smoke", 5, 1, 2, {"sensors": _SENSORS, "paired_variants": _PAIRED_VARIANTS}, ("kitti", "bop"))
HIDDEN = DataConfig(
    "smoke",
    5,
    1,
    2,
    {
        "sensors": _SENSORS,
        "occlusion": {"visible_fraction": [{"min": 0.4, "max": 0.8}]},
        "paired_variants": {"without_occluders": True, **_PAIRED_VARIANTS},
    },
    ("kitti", "bop"),
)


def shrunk(suite: Suite) -> Suite:
    """Return a suite that asks the same of one scene of the smoke recipe, and trains nothing.

    All datasets become one, so that conditions on several are paired with themselves.
    """
    against = {item.against for item in suite.compare}
    data = {"industrial": HIDDEN} if "without occluders" in against else {"smoke": FREE}
    (name,) = data
    conditions = {label: replace(item, data=name) for label, item in suite.evaluated.items()}
    driven = replace(suite.approach, recipes=("smoke",) if suite.approach.recipes else (), seed=3, episodes=1)
    return replace(suite, data=data, conditions=conditions, trainings={}, simulated_poses=3, approach=driven)


def only_scored(suite: Suite) -> Suite:
    """Return a suite that is shrunk and scores poses alone: nothing finds objects, and no truck drives."""
    return replace(shrunk(suite), detectors=(), simulate=False, approach=ApproachConfig())


def of_two_conditions(suite: Suite) -> Suite:
    """Return a suite that evaluates and compares no more than the first two conditions."""
    return replace(suite, conditions=dict(islice(suite.evaluated.items(), 2)), compare=())


def bench_folder(shared: Shared, out: Path) -> Path:
    """Return ``out``, a folder of the benchmark that has the datasets of suites that are shrunk, and nothing else."""

    def make(folder: Path) -> None:
        for name, data in (("industrial", HIDDEN), ("smoke", FREE)):
            made(name, data, folder, workers=1)

    shutil.copytree(shared.made("bench", make) / "data", out / "data")
    return out
