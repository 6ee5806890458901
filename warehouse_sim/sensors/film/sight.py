"""The film that rays of a sensor meet before what is solid: exact rays against the film of a scene alone."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float, Float32, Int, Int32

from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.schema import SceneSpec
from warehouse_sim.sensors.film.blocks import Cones
from warehouse_sim.sensors.film.optics import FilmOptics
from warehouse_sim.sensors.film.wrinkles import wrinkled

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
