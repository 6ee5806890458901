"""The film that rays of a sensor meet before what is solid: its wrinkles, and what its layers do to light.

Film of polyethylene has a refractive index of about 1.5, so that Fresnel's formulas give 4 % of reflection a surface
seen straight on and 7.7 % a layer: 90.5 % of the light goes straight on behind one layer of 2 % haze, as clear film is
sold. What goes through ``m`` surfaces is that of a pile of plates (Stokes 1862, "On the intensity of the light
reflected from or transmitted through a pile of plates"). Haze and its backward share have no source: priors.
"""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from jaxtyping import Bool, Float, Float32, Int, Int32

from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.schema import Material, SceneSpec
from warehouse_sim.sensors.film.blocks import Cones

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


_TEXELS = 256
_TEXEL = 0.004
"""Edge of a texel (m); the tile starts again each 1.024 m."""
_SLOPE = 0.11
"""Root mean square of the slope across the waves (rad)."""
_WAVES = ((18.0, 0.020, 0.22), (-25.0, 0.014, 0.15), (80.0, 0.030, 0.25))
"""Of each family: where it runs (deg above level), width and length of its waves (m)."""
_PATCH = 0.12
"""Size of the patches with more waves or fewer (m)."""


def wrinkled(
    points: Float32[np.ndarray, "n 3"], normals: Float32[np.ndarray, "n 3"], instance_ids: Int32[np.ndarray, " n"]
) -> Float32[np.ndarray, "n 3"]:
    """Return the normals of the wrinkles at places on film.

    Each object's tile begins elsewhere; it is laid on along the world axis that the film faces most.

    Args:
        points: World (m).
        normals: Unit, of the mesh.
        instance_ids: Whose film it is.
    """
    x, y, z = points.T
    across, along, upright = np.abs(normals.T)
    faces_z = upright > np.maximum(across, along)
    faces_x = (across > along) & ~faces_z
    start = instance_ids.astype(np.int64)
    u = np.floor(np.where(faces_x, y, x) * np.float32(1.0 / _TEXEL)).astype(np.int64) + 97 * start
    v = np.floor(np.where(faces_z, y, z) * np.float32(1.0 / _TEXEL)).astype(np.int64) + 61 * start
    slopes = _slopes()[:, v & (_TEXELS - 1), u & (_TEXELS - 1)]
    turned = normals.T.copy()
    turned[0] -= np.where(faces_x, np.float32(0.0), slopes[0])
    turned[1] -= np.where(faces_x, slopes[0], np.where(faces_z, slopes[1], np.float32(0.0)))
    turned[2] -= np.where(faces_z, np.float32(0.0), slopes[1])
    turned /= np.sqrt(np.square(turned).sum(axis=0))
    return turned.T


@lru_cache(maxsize=1)
def _slopes() -> Float32[np.ndarray, "2 t t"]:
    """Return the slopes along u and v of a tile that fits itself."""
    rng = np.random.default_rng(0x66696C6D)
    fu, fv = np.meshgrid(*(np.fft.fftfreq(_TEXELS, _TEXEL),) * 2)
    height = np.zeros((_TEXELS, _TEXELS))
    for degrees, width, length in _WAVES:
        turn = np.deg2rad(degrees)
        run, rise = fu * np.cos(turn) + fv * np.sin(turn), fv * np.cos(turn) - fu * np.sin(turn)
        band = np.exp(-((run * length) ** 2)) * np.exp(-(((np.abs(rise) * width - 0.5) / 0.25) ** 2))
        height += _filtered(rng, band) * _filtered(rng, np.exp(-((fu**2 + fv**2) * _PATCH**2))) ** 2 * width
    spectrum = np.fft.fft2(height)
    slopes = np.array([np.fft.ifft2(2j * np.pi * f * spectrum).real for f in (fu, fv)])
    slopes *= _SLOPE / np.sqrt(np.square(slopes).sum(axis=0).mean())
    fixed: Float32[np.ndarray, "2 t t"] = slopes.astype(np.float32)
    fixed.setflags(write=False)
    return fixed


def _filtered(rng: np.random.Generator, band: np.ndarray) -> np.ndarray:
    """Return noise of variance 1 with a given spectrum."""
    noise = np.fft.ifft2(np.fft.fft2(rng.standard_normal(band.shape)) * band).real
    return np.asarray(noise / noise.std())


CLASS_NAME = "wrap"
"""Film on the floor, such as water, lies on what is read anyway."""
_BEFORE = 1e-4
"""Film is before a surface when it is nearer by this (m)."""


@dataclass(frozen=True, eq=False)
class FilmMet:
    """The first film on each of some rays; light is relative to white plaster that faces an emitter beside the lens."""

    rays: Int[np.ndarray, " m"]
    """Which rays meet film before what is solid, rising."""
    distance: Float32[np.ndarray, " m"]
    """In units of the ray's direction."""
    instance_ids: Int32[np.ndarray, " m"]
    """Of the film."""
    passed: Float32[np.ndarray, " m"]
    """Fraction of the light that gets through, once."""
    clear: Float32[np.ndarray, " m"]
    """Fraction of it that is not turned aside."""
    diffuse: Float32[np.ndarray, " m"]
    """Light that the film scatters back."""
    glossy: Float32[np.ndarray, " m"]
    """Light that its wrinkles mirror back."""


class FilmSight:
    """All stretch film of a scene. Only the first sheet on a ray counts; what shines through goes on to the solid.

    Args:
        scene: The scene; later changes to it are not seen.

    Raises:
        MissingPackageError: Embree is not installed.
    """

    def __init__(self, scene: SceneSpec) -> None:
        # Painted opaque and alone, film is what rays meet.
        materials = {name: replace(item, opacity=1.0) for name, item in scene.materials.items() if item.opacity < 1.0}
        models = {
            name: replace(model, parts=tuple(part for part in model.parts if part.material in materials))
            for name, model in scene.models.items()
            if model.class_name == CLASS_NAME
        }
        models = {name: model for name, model in models.items() if model.parts}
        instances = tuple(item for item in scene.instances if item.model in models)
        self._caster = None
        if instances:
            alone = replace(scene, models=models, materials=materials, instances=instances)
            self._caster = RayCaster(alone)
            self._optics = FilmOptics.of(tuple(scene.materials[name] for name in self._caster.materials))
            places = [_sphere(models[item.model].size, item.T_world_object) for item in instances]
            self._centres = np.array([centre for centre, _ in places])
            self._radii = np.array([radius for _, radius in places])

    def near(self, origins: Float[np.ndarray, "n 3"], cones: Cones) -> Bool[np.ndarray, " n"]:
        """Return in which cones there may be film.

        Args:
            origins: Tips of the cones in the world (m).
            cones: In the world.
        """
        if self._caster is None:
            return np.zeros(len(origins), bool)
        to = self._centres - origins[:, None]
        far = np.maximum(np.sqrt(np.square(to).sum(axis=-1)), 1e-9)
        cosine = (cones.axes[:, None] * to).sum(axis=-1) / far
        half = np.where(far < self._radii, np.pi, np.arcsin(np.minimum(self._radii / far, 1.0))) + cones.spread[:, None]
        return np.asarray((cosine > np.cos(np.minimum(half, np.pi))).any(axis=1) | (half >= np.pi).any(axis=1))

    def met(
        self,
        rays: Int[np.ndarray, " m"],
        origins: Float[np.ndarray, "m 3"],
        directions: Float32[np.ndarray, "m 3"],
        solid: Float32[np.ndarray, " m"],
    ) -> FilmMet | None:
        """Return the film before solid surfaces; None where there is none.

        Args:
            rays: Their numbers, rising; neighbours go much the same way.
            origins: Where they start in the world (m).
            directions: Of any length, in the world.
            solid: Distance of what is solid on each ray, in units of its direction; infinite = nothing.
        """
        if self._caster is None or len(rays) == 0:
            return None
        found, hits = self._caster.cast_before(origins, directions, solid - np.float32(_BEFORE))
        if len(found) == 0:
            return None
        toward = directions[found] / np.sqrt(np.square(directions[found]).sum(axis=1))[:, None]
        points = origins[found] + hits.distance[:, None] * directions[found]
        fine = wrinkled(points.astype(np.float32), hits.normals, hits.instance_ids)
        passed, clear, diffuse = self._optics.at(hits.materials, _cosine(hits.normals, toward))
        glossy = self._optics.highlight(hits.materials, _cosine(fine, toward))
        return FilmMet(rays[found], hits.distance, hits.instance_ids, passed, clear, diffuse, glossy)


def _cosine(normals: Float32[np.ndarray, "n 3"], toward: Float32[np.ndarray, "n 3"]) -> Float32[np.ndarray, " n"]:
    return np.minimum(np.abs(np.einsum("ni,ni->n", normals, toward)), np.float32(1.0))


def _sphere(size: Float[np.ndarray, " 3"], T_world_object: Float[np.ndarray, "4 4"]) -> tuple[np.ndarray, float]:
    """Return centre and radius (m) of a ball around an object, whose origin is the middle of its box."""
    return T_world_object[:3, 3], float(np.linalg.norm(size) / 2 + 1e-3)
