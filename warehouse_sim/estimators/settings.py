"""Settings of prediction; free of torch, so that a command line can show them at once."""

from dataclasses import dataclass, field
from typing import Literal

from warehouse_sim.estimators.icp import IcpConfig
from warehouse_sim.estimators.select import Selection

Refinement = Literal["none", "icp"]


@dataclass(frozen=True)
class PredictConfig:
    """How poses are estimated."""

    detections: Literal["gt"] = "gt"
    """Where a dataset's masks come from; gt takes the true visible ones, as BOP's localisation with given masks."""
    selection: Selection = "argmax"
    """How one pose is chosen from those that the points propose."""
    refine: Refinement = "none"
    """What follows the network: nothing, or point-to-plane ICP against the CAD surface."""
    images_at_once: int = 8
    """Images whose targets pass the network together, >= 1."""
    seed: int = 0
    """Decides which points are drawn, >= 0."""
    device: Literal["auto", "cpu", "cuda"] = "auto"
    """Where the network runs; auto takes a GPU if there is one."""
    threads: int | None = None
    """Processor threads of the network, >= 1; by default one for small networks, which gain little from more and wait
    long for them on a busy machine, and torch's own number for large ones."""
    icp: IcpConfig = field(default_factory=IcpConfig)
    """Settings of the ICP."""
