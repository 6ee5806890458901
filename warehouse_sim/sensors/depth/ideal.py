"""The truth, within a range."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from warehouse_sim.schema import RenderBuffers
from warehouse_sim.sensors.depth.model import Depth, DepthModel
from warehouse_sim.sensors.shot import Shot


@dataclass(frozen=True)
class IdealDepth(DepthModel):
    """A camera without errors."""

    kind: ClassVar[str] = "ideal"

    def measure(self, buffers: RenderBuffers, shot: Shot, rng: np.random.Generator) -> Depth:
        """Return the clean depth (m)."""
        return buffers.depth
