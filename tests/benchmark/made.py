"""One small dataset that every suite can be asked on: twins of each kind, a LiDAR, requested occlusion."""

from dataclasses import replace

from warehouse_sim.benchmark.suite import DataConfig, Suite

SETTINGS = {
    "sensors": {"rig": "dissertation"},
    "occlusion": {"visible_fraction": [{"min": 0.4, "max": 0.8}]},
    "twins": {
        "without_occluders": True,
        "lights": [{"name": "dim 20 lx", "preset": "dim", "lux": 20}],
        "noise": [{"name": "d435", "rgbd": {"depth": "d435"}, "draw": 0}],
    },
}
SMOKE = DataConfig("smoke", 5, 1, 2, SETTINGS, ("kitti", "bop"))
TRIVIAL = ("rectangle-fit", "plane-fit", "icp-multistart", "front-fit")


def shrunk(suite: Suite) -> Suite:
    """Return a suite that asks the same of one scene of the smoke recipe, and trains nothing."""
    data = {name: SMOKE for name, item in suite.data.items() if not item.trained_on}
    against = {"without occluders": "without occluders"}
    compare = tuple(
        replace(item, against=against.get(item.against, "base")) if item.variants else item for item in suite.compare
    )
    return replace(suite, data=data, trainings={}, compare=compare)
