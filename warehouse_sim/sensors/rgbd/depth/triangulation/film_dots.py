"""Dots of a projector where film is before a surface: some lie on the film, some behind it, and both are seen."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float32

from warehouse_sim.sensors.film import FilmImage

Image = Float32[np.ndarray, "h w"]
_GLINT_PX = 0.6
"""Standard deviation of disparity (px of the sensor) where all light is mirrored by wrinkles, whose highlights lie
elsewhere for each eye; no source: a prior."""


@dataclass(frozen=True, eq=False)
class FilmedDots:
    """What can be matched of two patterns, one over the other."""

    dots: Image
    """Light of the stronger pattern."""
    on_film: Bool[np.ndarray, "h w"]
    """Where that lies on the film."""
    rival: Image
    """Light of the weaker pattern as a fraction of the stronger one's, where the two lie at least 1 px apart."""
    glint: Image
    """Fraction of the light that wrinkles mirror."""

    @classmethod
    def of(cls, dots: Image, depth: Image, film: FilmImage, ragged: Image, lux: float, unit: float) -> "FilmedDots":
        """Return what is seen of the dots.

        Args:
            dots: Light of those on what is solid, without film.
            depth: Of what is solid (m).
            film: Before it.
            ragged: Factor on the film's light where the patterns compete: borders of patches are not straight.
            lux: Light of a dot on white plaster that faces the projector from 1 m, in units of ``dots``.
            unit: Focal length times baseline (px m).
        """
        # Light that is turned aside on the way shows no dots.
        behind = dots * np.square(film.passed * film.clear)
        front = np.float32(lux) * film.light / np.square(film.depth)
        on_film = front * ragged > behind
        stronger = np.where(on_film, front, behind)
        apart = np.where(front > 0, np.float32(unit) * (1 / film.depth - 1 / np.maximum(depth, np.float32(0.01))), 0)
        both = np.maximum(front + behind, np.float32(1e-9))
        return cls(
            dots=stronger,
            on_film=on_film,
            rival=(both - stronger) / np.maximum(stronger, np.float32(1e-9)) * np.minimum(np.abs(apart), 1),
            glint=np.float32(lux) * film.glossy / np.square(film.depth) / both,
        )

    def variance(self, blurred_px: float) -> Image:
        """Return what film adds to the variance of disparity (px^2 of the sensor).

        Args:
            blurred_px: Standard deviation where a pattern is as strong as the noise, here that of its rival.
        """
        rival = np.float32(blurred_px**2) * np.square(np.minimum(self.rival, 2))
        return np.asarray(rival + np.float32(_GLINT_PX**2) * np.square(self.glint), np.float32)
