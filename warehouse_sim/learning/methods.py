"""What can be trained by name: each method fixes the inputs of a network and its widths at each size."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from warehouse_sim.registry import Registry

if TYPE_CHECKING:
    from warehouse_sim.learning.networks.densefusion import DenseFusionConfig

Size = Literal["nano", "small", "full"]


@dataclass(frozen=True)
class Method:
    """One estimator that learns: its name, what it reads, and its network at each size."""

    name: str
    summary: str
    """One line for people."""
    inputs: str
    """What it reads of an observation."""
    network: "Callable[[Size], DenseFusionConfig]"
    """The network's configuration at a size."""


ESTIMATORS = Registry("estimator")
ESTIMATORS.add("densefusion", "warehouse_sim.learning.networks.family:DENSEFUSION")
ESTIMATORS.add("densefusion-pointcloud", "warehouse_sim.learning.networks.family:DENSEFUSION_POINTCLOUD")
