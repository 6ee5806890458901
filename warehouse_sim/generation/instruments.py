"""What measures a scene while it is observed: exact rays, film, light."""

from dataclasses import dataclass

from warehouse_sim.annotate.film import FilmCaster
from warehouse_sim.generation.light import LightMeter
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.schema import SceneChange, SceneSpec
from warehouse_sim.sensors.film import FilmSight


@dataclass(frozen=True, eq=False)
class Instruments:
    """Everything of a scene that is built once and asked from every viewpoint."""

    scene: SceneSpec
    caster: RayCaster
    film: FilmCaster
    meter: LightMeter
    sight: FilmSight
    """Film as sensors with a light of their own meet it."""

    @classmethod
    def of(cls, scene: SceneSpec, base: "Instruments | None", change: SceneChange) -> "Instruments":
        """Return those of a scene; what ``change`` leaves alone is that of the base, whose paired variant the scene is.

        Args:
            scene: Settled and lit.
            base: Those of the scene that it is a paired variant of; None when it is no paired variant.
            change: What differs from the base's scene.
        """
        unmoved = base if base and not (change.objects or change.surfaces) else None
        caster = unmoved.caster if unmoved else RayCaster(scene)
        sight = unmoved.sight if unmoved else FilmSight(scene)
        film = base.film if base and not change.objects else FilmCaster(scene)
        same_light = base and change.nothing and _metered_alike(base.scene, scene)
        meter = base.meter if base and same_light else LightMeter(scene, caster)
        return cls(scene, caster, film, meter, sight)


def _metered_alike(a: SceneSpec, b: SceneSpec) -> bool:
    """Return whether what a light meter tells of two scenes with the same lights is the same."""
    return (a.exposure, a.lighting) == (b.exposure, b.lighting)
