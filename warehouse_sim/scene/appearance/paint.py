"""Settings of one kind of surface: what is painted again, in which colours, how glossy, old and dirty it is."""

from dataclasses import dataclass, field
from typing import Annotated

from warehouse_sim.ranges import Fraction, Range, ranged
from warehouse_sim.scene.distribution import Distribution


@dataclass(frozen=True)
@ranged
class PaintConfig:
    """How one kind of surface varies; as it stands here, it does not."""

    fraction: Fraction = 0.0
    """Fraction of the things that have another colour than the catalog's, 0-1: one that is common for such things."""
    any_hue: Fraction = 0.0
    """Fraction of those that have any colour at all instead of a common one, 0-1."""
    value: Annotated[Distribution, Range(0.1, 4)] = field(default=Distribution.constant(1.0))
    """Factor on the albedo, 0.1-4; no channel passes 0.9."""
    hue_deg: Annotated[Distribution, Range(-180, 180, "deg")] = field(default=Distribution.constant(0.0))
    """Turn of the hue (deg), -180 to 180."""
    roughness: Annotated[Distribution, Range(0.1, 4)] = field(default=Distribution.constant(1.0))
    """Factor on the roughness, 0.1-4; no roughness passes 1."""
    dirt: Annotated[Distribution, Range(0, 1)] = field(default=Distribution.constant(0.0))
    """How much dust and grime lies on it, 0-1; from 0.35 on the texture is a stained and scratched one."""
    swap: Fraction = 0.0
    """Fraction of the things that have the texture of some other material, 0-1."""
