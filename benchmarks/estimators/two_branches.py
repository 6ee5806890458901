"""Middle fusion without its attention: what is left of its gain comes from the second image branch."""

from dataclasses import replace

from warehouse_sim.estimators.pose.densefusion.methods import TrainableMethod
from warehouse_sim.estimators.pose.densefusion.networks.densefusion import DenseFusionConfig
from warehouse_sim.estimators.pose.densefusion.settings import Size
from warehouse_sim.estimators.registries import ESTIMATORS

NAME = "two-branches"


def _network(size: Size, paper: bool = False) -> DenseFusionConfig:
    return replace(ESTIMATORS.get("densefusion-middle-1").network(size, paper), fusion=None)


TWO_BRANCHES = TrainableMethod(NAME, "colour and depth after a branch each", "RGB crop + depth crop + cloud", _network)


def register() -> None:
    """Make it known under its name to this process."""
    if NAME not in ESTIMATORS.names():
        ESTIMATORS.add(NAME, f"{__name__}:TWO_BRANCHES")
