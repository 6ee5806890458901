"""The ground truth, within a range."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from warehouse_sim.schema import RenderBuffers
from warehouse_sim.sensors.capture import Capture
from warehouse_sim.sensors.rgbd.depth.model import Depth, DepthModel


@dataclass(frozen=True)
class IdealDepth(DepthModel):
    """A camera without errors."""

    kind: ClassVar[str] = "ideal"

    def measure(self, buffers: RenderBuffers, capture: Capture, rng: np.random.Generator) -> Depth:
        """Return the clean depth (m)."""
        return buffers.depth
