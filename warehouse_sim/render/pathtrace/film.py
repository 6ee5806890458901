"""What stretch film does to a camera ray: scatters it, mirrors it or lets it pass.

Film is seen by the camera and lit like any surface, but all other light goes through it unhindered, because shadows
are those of the scene without film.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import drjit as dr
import mitsuba as mi

if TYPE_CHECKING:
    from warehouse_sim.render.pathtrace.loaded_scene import LoadedScene

_MIRROR_CHANCE = 0.25  # of the clear part; far above its 4 % of mirrored light, for the sake of highlights
_MIN_COSINE = 0.2


@dataclass(frozen=True, eq=False)
class FilmEvent:
    """What happens to each ray at the first film before the first solid surface."""

    hit: Any
    """Whether there is film."""
    passes: Any
    """Whether the ray goes on behind it."""
    mirrors: Any
    """Whether it is reflected by a clear part; otherwise it is scattered."""
    surface: Any
    """``mi.SurfaceInteraction3f`` of the film."""
    weight: Any
    """Factor on the path's share."""
    glosses: tuple[tuple[Any, Any], ...]
    """Rays mirrored by each film material, and its ``mi.BSDF`` there."""

    def evaluate_gloss(self, context: Any, surface: Any, local: Any) -> Any:
        """Return the mirroring part towards ``local``, zero for rays that are not mirrored."""
        values = [dr.select(mask, gloss.eval(context, surface, local, mask), 0.0) for mask, gloss in self.glosses]
        return sum(values[1:], values[0])

    def sample_gloss(self, context: Any, surface: Any, sampler: Any, sample: Any, weight: Any) -> tuple[Any, Any]:
        """Return ``sample`` and ``weight`` with those of mirrored rays replaced."""
        for mask, gloss in self.glosses:
            own, own_weight = gloss.sample(context, surface, sampler.next_1d(), sampler.next_2d(), mask)
            sample, weight = dr.select(mask, own, sample), dr.select(mask, own_weight, weight)
        return sample, weight


def film_event(scene: "LoadedScene", ray: Any, solid_distance: Any, sampler: Any, active: Any) -> FilmEvent:
    """Draw what the film does to ``ray``.

    Args:
        scene: Holds film.
        ray: Of unit direction.
        solid_distance: Distance to the first solid surface (m), infinite when there is none.
        sampler: Random numbers.
        active: Which rays see film.
    """
    assert scene.film is not None
    hit = scene.film.ray_intersect_preliminary(ray, coherent=False, active=active)
    on_film = active & hit.is_valid() & (hit.t < solid_distance)
    surface = hit.compute_surface_interaction(ray, mi.RayFlags.All, on_film)
    cosine = -dr.dot(surface.n, ray.d)
    enters = on_film & (cosine > 0.0)  # a sheet has two faces, and counts once
    clear = clear_fraction(scene, surface, hit.shape_index, enters)
    in_clear_part = enters & (sampler.next_1d() < clear)
    mirrors = in_clear_part & (sampler.next_1d() < _MIRROR_CHANCE)
    passes = (in_clear_part & ~mirrors) | (on_film & ~enters)
    reflected = 0.04 + 0.96 * dr.power(1.0 - dr.abs(cosine), 5)  # Schlick 1994
    weight = dr.select(passes & enters, (1.0 - reflected) / (1.0 - _MIRROR_CHANCE), 1.0)
    return FilmEvent(
        hit=on_film,
        passes=passes,
        mirrors=mirrors,
        surface=surface,
        weight=dr.select(mirrors, 1.0 / _MIRROR_CHANCE, weight),
        glosses=tuple(
            (mirrors & (hit.shape_index == number), film.gloss) for number, film in enumerate(scene.film_surfaces)
        ),
    )


def clear_fraction(scene: "LoadedScene", surface: Any, shape: Any, enters: Any) -> Any:
    """Return the fraction of film that is clear, 0-1: ``(1 - opacity)^(thickness / cosine)``, less the more it slants.

    Args:
        scene: Holds film.
        surface: Points on film, with where they are seen from.
        shape: Number of the film surface of each.
        enters: Which of them count; the others are all clear.
    """
    thickness, clearness = mi.Float(1.0), mi.Float(1.0)
    for number, film in enumerate(scene.film_surfaces):
        here = enters & (shape == number)
        clearness = dr.select(here, 1.0 - film.opacity, clearness)
        if film.factor is not None:
            thickness = dr.select(here, film.factor.eval_1(surface, here), thickness)
    cosine = dr.dot(surface.n, surface.to_world(surface.wi))
    return dr.power(clearness, thickness / dr.maximum(cosine, _MIN_COSINE))
