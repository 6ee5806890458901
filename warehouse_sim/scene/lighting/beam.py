"""How luminaires of a scene shine: in a cone by a formula, or as their photometric file says."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from warehouse_sim.scene.lighting.photometry import cone_of_beam, flux_per_candela
from warehouse_sim.schema import IntensityDistribution, Light

_WIDEST = np.deg2rad(89.0)
"""Half angle of the widest cone that a distribution is taken to fill where only cones are known."""


@dataclass(frozen=True, eq=False)
class Beam:
    """What spots of one kind have in common."""

    cone_inner: float
    cone_outer: float
    """Half angles (rad) as of ``Light``; of a distribution, 0 and the widest angle with light."""
    flux_per_candela: float
    """Flux (lm) of a spot of 1 cd on its axis, or at most where it has a distribution."""
    distribution: IntensityDistribution | None = None

    @classmethod
    def of(cls, beam_deg: float, distribution: IntensityDistribution | None = None) -> "Beam":
        """Return the beam of half intensity within ``beam_deg`` (full angle, deg), or that of a distribution."""
        if distribution is not None:
            outer = min(distribution.widest, float(_WIDEST))
            return cls(0.0, outer, distribution.flux_per_candela, distribution)
        inner, outer = cone_of_beam(beam_deg)
        return cls(inner, outer, flux_per_candela(inner, outer))

    def spot(
        self,
        position: Float[np.ndarray, " 3"],
        direction: Float[np.ndarray, " 3"],
        length: Float[np.ndarray, " 3"],
        flux: float,
        *,
        color: tuple[float, float, float],
        radius: float,
        fill: bool = False,
    ) -> Light:
        """Return a spot of this beam.

        Args:
            position: World position (m).
            direction: Unit axis in the world.
            length: Unit vector along the luminaire's length, that a distribution turns with; not along the axis.
            flux: What it gives (lm).
            color: Linear RGB of unit luminance-like scale.
            radius: Of the disk that emits (m).
            fill: As of ``Light``.
        """
        light = Light(
            kind="spot",
            position=position,
            direction=direction,
            intensity=flux / self.flux_per_candela,
            color=color,
            cone_inner=self.cone_inner,
            cone_outer=self.cone_outer,
            radius=radius,
            fill=fill,
        )
        return light if self.distribution is None else _turned(light, self.distribution, length)


def as_cone(light: Light) -> Light:
    """Return a light for renderers that draw cones only: of the same flux and half angle, without a distribution."""
    if light.distribution is None:
        return light
    half = float(np.clip(np.degrees(2.0 * light.distribution.half_angle), 10.0, 150.0))
    inner, outer = cone_of_beam(half)
    intensity = light.intensity * light.distribution.flux_per_candela / flux_per_candela(inner, outer)
    return replace(light, intensity=intensity, cone_inner=inner, cone_outer=outer, distribution=None)


def _turned(light: Light, distribution: IntensityDistribution, length: Float[np.ndarray, " 3"]) -> Light:
    axis = np.asarray(light.direction, float)
    along = length - (length @ axis) * axis
    x, y, z = (along / np.linalg.norm(along)).tolist()
    return replace(light, distribution=distribution, along=(x, y, z))
