"""A renderer and what sensors read by, set up for one viewpoint of one variant of a scene after the other."""

from dataclasses import dataclass

from warehouse_sim.annotate.film import FilmCaster
from warehouse_sim.generation.light import LightMeter
from warehouse_sim.generation.paired_variants import Variant
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.render.lens import LensRenderer
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.render.renderer import Renderer
from warehouse_sim.schema import SceneChange, SceneSpec, Viewpoint
from warehouse_sim.sensors.film import FilmSight
from warehouse_sim.sensors.view import CleanImages


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


@dataclass(frozen=True, eq=False)
class Moment:
    """One viewpoint of one variant, with all that an observation of it needs."""

    variant: Variant
    """As this viewpoint has it."""
    index: int
    """Of the viewpoint."""
    viewpoint: Viewpoint
    scene: SceneSpec
    """The variant's, in the light and exposure of the viewpoint."""
    camera: PinholeCamera
    renderer: Renderer
    """The scene is loaded into it."""
    images: CleanImages
    instruments: Instruments


class Stage:
    """Keeps what serves from one moment to the next.

    Args:
        renderer: Renders scenes, which are loaded into it here.
        camera: The rig's.
    """

    def __init__(self, renderer: Renderer, camera: PinholeCamera) -> None:
        self._camera = camera
        self._renderer = renderer if camera.distortion is None else LensRenderer(renderer)
        self._base: Instruments | None = None
        """Those of the first scene, whose paired variants the others are."""
        self._last: Instruments | None = None
        """Those of the last moment."""
        self._loaded: SceneSpec | None = None

    def set_up(self, variant: Variant, index: int, viewpoint: Viewpoint) -> tuple[Moment, SceneChange]:
        """Return the moment of a viewpoint, and what of its scene differs from the first one; at first everything.

        Args:
            variant: As the viewpoint has it.
            index: Of the viewpoint.
            viewpoint: From where.
        """
        change = SceneChange.between(None if self._base is None else self._base.scene, variant.scene)
        if self._last is None or self._last.scene is not variant.scene:
            self._last = Instruments.of(variant.scene, self._base, change)
            self._base = self._base or self._last
        lit = variant.scene.seen_from(viewpoint)
        if self._loaded is None or _needs_reload(self._loaded, lit):
            self._renderer.load(lit)
            self._loaded = lit
        images = CleanImages(self._renderer, self._camera)
        return Moment(variant, index, viewpoint, lit, self._camera, self._renderer, images, self._last), change


def _needs_reload(before: SceneSpec, after: SceneSpec) -> bool:
    return before.exposure != after.exposure or not SceneChange.between(before, after).nothing
