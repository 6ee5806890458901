"""A scene inside Mitsuba: what stops light, what the camera sees through, lights and sky."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import mitsuba as mi
import numpy as np
from jaxtyping import Int32

from warehouse_sim.render.pathtrace.amodal_masks import AmodalMaskCaster
from warehouse_sim.render.pathtrace.lights import LightSampler, Sky
from warehouse_sim.render.pathtrace.materials import albedo_factor, gloss, scattering
from warehouse_sim.render.pathtrace.triangles import MaterialTriangles, mesh_shape, scene_triangles
from warehouse_sim.schema import Material, SceneSpec


@dataclass(frozen=True, eq=False)
class FilmSurface:
    """What the path tracer asks of one film material beside its scattering."""

    opacity: float
    gloss: Any
    """``mi.BSDF`` of what it mirrors where it is clear."""
    factor: Any
    """``mi.Texture`` of the local thickness, or None."""


class LoadedScene:
    """One scene, ready for rays.

    Args:
        spec: The scene; later changes to it are not seen.

    Raises:
        RenderError: The scene names something that it does not hold, or a texture that is not shipped.
    """

    def __init__(self, spec: SceneSpec) -> None:
        groups = scene_triangles(spec)
        solid = [group for group in groups if group.material.opacity >= 1.0]
        film = [group for group in groups if group.material.opacity < 1.0]
        self.solid = _mitsuba_scene(solid)
        self.film = _mitsuba_scene(film) if film else None
        self.film_surfaces = [_film_surface(group.material) for group in film]
        self.take_light(spec)
        glow = [np.array(group.material.base_color) * group.material.emission for group in solid]
        self.emission = mi.Float(np.concatenate([*glow, np.zeros(3)]).astype(np.float32))
        """Luminance (cd/m^2) of each solid material, three values each."""
        self.amodal_mask_caster = AmodalMaskCaster(spec)
        counts = [len(group.instance_ids) for group in solid]
        self._first_triangle = np.cumsum([0, *counts])
        self._owner = np.concatenate([*(group.instance_ids for group in solid), np.zeros(1, np.int32)])

    def take_light(self, spec: SceneSpec) -> None:
        """Put the scene into the lights, even light and exposure of ``spec``, which has the same objects."""
        self.lights = LightSampler(spec.lights)
        self.sky = Sky(spec.ambient)
        self.exposure = spec.exposure

    def instance_ids(
        self, shape: Int32[np.ndarray, " n"], triangle: Int32[np.ndarray, " n"], hit: np.ndarray
    ) -> Int32[np.ndarray, " n"]:
        """Return whose triangle each ray has met, 0 where ``hit`` is false.

        Args:
            shape: Number of the solid shape.
            triangle: Number of the triangle in it.
            hit: Whether the ray has met anything.
        """
        row = self._first_triangle[np.where(hit, shape, -1)] + np.where(hit, triangle, 0)
        return self._owner[row]


def _mitsuba_scene(groups: Sequence[MaterialTriangles]) -> Any:
    shapes = {
        f"shape{number:05d}": mesh_shape(group.corners, group.texture, scattering(group.material))
        for number, group in enumerate(groups)
    }
    # Unoptimised: merged shapes would lose their numbers.
    return mi.load_dict({"type": "scene", **shapes}, optimize=False)


def _film_surface(material: Material) -> FilmSurface:
    return FilmSurface(material.opacity, gloss(material), albedo_factor(material))
