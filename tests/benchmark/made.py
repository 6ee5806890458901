"""Two small datasets that every suite can run on: paired variants of each kind and a LiDAR; the same with occluders."""

from dataclasses import replace

from warehouse_sim.benchmark.suite import DataConfig, Suite

_PAIRED_VARIANTS = {
    "lights": [{"name": "dim 20 lx", "preset": "dim", "lux": 20}],
    "noise": [{"name": "d435", "rgbd": {"depth": "d435"}, "sample": 0}],
}
FREE = DataConfig(
    "smoke", 5, 1, 2, {"sensors": {"rig": "dissertation"}, "paired_variants": _PAIRED_VARIANTS}, ("kitti", "bop")
)
HIDDEN = DataConfig(
    "smoke",
    5,
    1,
    2,
    {
        "sensors": {"rig": "dissertation"},
        "occlusion": {"visible_fraction": [{"min": 0.4, "max": 0.8}]},
        "paired_variants": {"without_occluders": True, **_PAIRED_VARIANTS},
    },
    ("kitti", "bop"),
)
BASELINES = ("rectangle-fit", "rectangle-fit+lidar")


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
