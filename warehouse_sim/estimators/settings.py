"""Settings of prediction; free of torch, so that a command line can show them at once."""

from dataclasses import dataclass, field
from typing import Literal

from warehouse_sim.estimators.icp import IcpConfig
from warehouse_sim.estimators.select import Selection


@dataclass(frozen=True)
class PredictConfig:
    """How poses are estimated."""

    detections: Literal["gt"] = "gt"
    """Where the masks come from; gt takes the true visible masks, as BOP's localisation with given masks."""
    selection: Selection = "argmax"
    """How one pose is chosen from those that the points propose."""
    refine: Literal["none", "icp"] = "none"
    """What follows the network: nothing, or point-to-plane ICP against the CAD surface."""
    images_at_once: int = 8
    """Images whose targets pass the network together, >= 1."""
    seed: int = 0
    """Decides which points are drawn, >= 0."""
    icp: IcpConfig = field(default_factory=IcpConfig)
    """Settings of the ICP."""
