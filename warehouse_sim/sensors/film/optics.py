"""What layers of stretch film do to light: what they mirror, let pass, blur and send back.

Film of polyethylene has a refractive index of about 1.5, so that Fresnel's formulas give 4 % of reflection a surface
seen straight on and 7.7 % a layer: 90.5 % of the light goes straight on behind one layer of 2 % haze, as clear film is
sold. What goes through ``m`` surfaces is that of a pile of plates (Stokes 1862, "On the intensity of the light
reflected from or transmitted through a pile of plates"). Haze and its backward share have no source: priors.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Float32, Int

from warehouse_sim.schema import Material

_INDEX = 1.5
_LAYER = 0.13
"""Opacity of one layer as the catalog paints it."""
_MOST_LAYERS = 5.0
"""Of clear film; what is denser is dyed."""
_HAZE = 0.02
"""Fraction of the light that one layer turns aside by more than 2.5 degrees (ASTM D1003); no source: a prior."""
_BACKWARD = 0.25
"""Fraction of the haze that goes back; no source: a prior."""
_STEPS = 256
"""Of the cosine in tables."""
_SMALLEST_ALPHA = 0.0025


@dataclass(frozen=True, eq=False)
class FilmOptics:
    """Tables of some films; rows by film, columns by the cosine of incidence from 0 to 1."""

    passed: Float32[np.ndarray, "k steps"]
    """Fraction of the light that gets through, once."""
    clear: Float32[np.ndarray, "k steps"]
    """Fraction of it that is not turned aside."""
    diffuse: Float32[np.ndarray, "k steps"]
    """Light scattered back to an emitter beside the lens, white plaster that faces it = 1."""
    mirrored: Float32[np.ndarray, " k"]
    """Fraction of the light that film seen straight on mirrors."""
    alpha2: Float32[np.ndarray, " k"]
    """Square of the GGX width of the mirror's lobe between wrinkles."""

    @classmethod
    def of(cls, films: tuple[Material, ...]) -> "FilmOptics":
        """Return the tables of films, whose opacity tells their layers, and where that is not enough the dye."""
        cosine = np.linspace(0.0, 1.0, _STEPS)
        # Light slants less inside of the film.
        inside = np.sqrt(1.0 - (1.0 - cosine**2) / _INDEX**2)
        passed, clear, diffuse, mirrored = [], [], [], []
        for film in films:
            layers, dyed = layers_and_dye(film.opacity)
            thrown = pile_reflectance(cosine, layers)
            straight = (1.0 - dyed) ** (1.0 / inside)
            passed.append((1.0 - thrown) * straight)
            clear.append((1.0 - _HAZE) ** (layers / inside))
            back = _BACKWARD * (1.0 - (1.0 - _HAZE) ** layers) + film.remission * dyed
            diffuse.append(back * cosine)
            mirrored.append(thrown[-1])
        alpha = np.maximum([film.roughness**2 for film in films], _SMALLEST_ALPHA)
        images = (np.array(item, np.float32) for item in (passed, clear, diffuse, mirrored, alpha**2))
        return cls(*images)

    def at(
        self, film: Int[np.ndarray, " n"], cosine: Float32[np.ndarray, " n"]
    ) -> tuple[Float32[np.ndarray, " n"], Float32[np.ndarray, " n"], Float32[np.ndarray, " n"]]:
        """Return ``passed``, ``clear`` and ``diffuse`` of films at cosines of incidence."""
        place = film * _STEPS + np.minimum(cosine * np.float32(_STEPS - 1) + np.float32(0.5), _STEPS - 1).astype(int)
        return self.passed.ravel()[place], self.clear.ravel()[place], self.diffuse.ravel()[place]

    def highlight(self, film: Int[np.ndarray, " n"], cosine: Float32[np.ndarray, " n"]) -> Float32[np.ndarray, " n"]:
        """Return the light mirrored back to an emitter beside the lens, white plaster that faces it = 1.

        The lobe is that of ``returned_light``; the half vector lies along the view, where Fresnel's share is that of
        light straight on.

        Args:
            film: Rows.
            cosine: Between the view and the normal of the wrinkle.
        """
        alpha2 = self.alpha2[film]
        lobe = alpha2 / np.square(cosine * cosine * (alpha2 - np.float32(1.0)) + np.float32(1.0))
        return np.asarray(np.float32(0.25) * self.mirrored[film] * lobe)


def layers_and_dye(opacity: float) -> tuple[float, float]:
    """Return the layers that a painted opacity stands for, and the fraction of light that dye in them takes away."""
    layers = np.log(max(1.0 - opacity, 1e-3)) / np.log(1.0 - _LAYER)
    if layers <= _MOST_LAYERS:
        return float(layers), 0.0
    return _MOST_LAYERS, float(1.0 - max(1.0 - opacity, 1e-3) / (1.0 - _LAYER) ** _MOST_LAYERS)


def pile_reflectance(cosine: Float[np.ndarray, " n"], layers: float) -> Float[np.ndarray, " n"]:
    """Return the fraction of unpolarised light that layers with air between them mirror: ``m r / (1 + (m - 1) r)``.

    Args:
        cosine: Of the angle of incidence, 0-1.
        layers: Of two surfaces each; any number above 0.
    """
    surfaces = 2.0 * layers
    inside = np.sqrt(1.0 - (1.0 - cosine**2) / _INDEX**2)
    across = ((cosine - _INDEX * inside) / (cosine + _INDEX * inside)) ** 2
    along = ((inside - _INDEX * cosine) / (inside + _INDEX * cosine)) ** 2
    return np.asarray(sum(surfaces * r / (1.0 + (surfaces - 1.0) * r) for r in (across, along)) / 2.0)
