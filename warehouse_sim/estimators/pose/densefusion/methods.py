"""What a method of the family is: it fixes the inputs of a network and its widths at each size."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol, get_args

from warehouse_sim.estimators.pose.densefusion.settings import Size

if TYPE_CHECKING:
    from warehouse_sim.estimators.pose.densefusion.networks.densefusion import DenseFusionConfig


class NetworkAtSize(Protocol):
    """Gives a method's network at a size."""

    def __call__(self, size: Size, paper: bool = False) -> "DenseFusionConfig":
        """Return the network's configuration; ``paper`` keeps the original's quirks."""


@dataclass(frozen=True)
class Method:
    """A name, what it reads, and its network at each size."""

    name: str
    summary: str
    """One line for people."""
    inputs: str
    """What it reads of an observation."""
    network: NetworkAtSize
    """The network's configuration at a size."""

    def parameters(self, classes: int = 1) -> dict[str, int]:
        """Return the number of weights by size."""
        from warehouse_sim.estimators.pose.densefusion.networks.densefusion import DenseFusion
        from warehouse_sim.learning.shapes import shapes_only

        with shapes_only():
            networks = {size: DenseFusion(self.network(size), classes) for size in get_args(Size)}
        return {size: sum(item.numel() for item in network.parameters()) for size, network in networks.items()}
