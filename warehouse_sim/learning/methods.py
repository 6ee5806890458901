"""What can be trained by name: each method fixes the inputs of a network and its widths at each size."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from warehouse_sim.learning.settings import Size
from warehouse_sim.registry import Registry

if TYPE_CHECKING:
    from warehouse_sim.learning.networks.densefusion import DenseFusionConfig


class NetworkAtSize(Protocol):
    """Gives a method's network at a size."""

    def __call__(self, size: Size, faithful: bool = False) -> "DenseFusionConfig":
        """Return the network's configuration; ``faithful`` keeps the original's quirks."""


@dataclass(frozen=True)
class Method:
    """One estimator that learns: its name, what it reads, and its network at each size."""

    name: str
    summary: str
    """One line for people."""
    inputs: str
    """What it reads of an observation."""
    network: NetworkAtSize
    """The network's configuration at a size."""


ESTIMATORS = Registry("estimator")
for _name in (
    "densefusion",
    "densefusion-early",
    "densefusion-middle-1",
    "densefusion-middle-2",
    "densefusion-depth",
    "densefusion-pointcloud",
    "object-coordinates",
):
    ESTIMATORS.add(_name, f"warehouse_sim.learning.networks.family:{_name.upper().replace('-', '_')}")
