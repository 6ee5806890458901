"""A settled scene becomes observations: render -> sense -> annotate, viewpoint by viewpoint, variant by variant."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from jaxtyping import Bool

from warehouse_sim.annotate import annotate, targets_in_view
from warehouse_sim.annotate.dense import class_numbers, object_coordinates
from warehouse_sim.annotate.film import FilmCaster
from warehouse_sim.errors import WarehouseSimError
from warehouse_sim.generation.light import LightMeter, measure_conditions, target_illuminance
from warehouse_sim.generation.recipe.paired_variants import Variant, base_variant
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.level_view import level_view
from warehouse_sim.geometry.pose import invert
from warehouse_sim.render.lens import LensRenderer
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.render.renderer import AmodalMask, Renderer
from warehouse_sim.scene.streams import scene_rng
from warehouse_sim.schema import (
    CAMERA,
    RIGHT,
    MountedReading,
    ObjectInstance,
    Observation,
    Reading,
    RenderBuffers,
    RgbdReading,
    SceneChange,
    SceneSpec,
    Viewpoint,
)
from warehouse_sim.schema.outputs import USUAL, Output
from warehouse_sim.sensors.film import FilmSight
from warehouse_sim.sensors.rig import MountedSensor, RigConfig, SensorChoice
from warehouse_sim.sensors.view import CleanImages, SensorView


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
    def of(
        cls, scene: SceneSpec, base: "Instruments | None", change: SceneChange, caster: RayCaster | None
    ) -> "Instruments":
        """Return those of a scene; what ``change`` leaves alone is that of the base, whose paired variant the scene is.

        Args:
            scene: Settled and lit.
            base: Those of the scene that it is a paired variant of; None when it is no paired variant.
            change: What differs from the base's scene.
            caster: Rays against the scene, where there are such and no base.
        """
        unmoved = base if base and not (change.objects or change.surfaces) else None
        caster = unmoved.caster if unmoved else caster or RayCaster(scene)
        sight = unmoved.sight if unmoved else FilmSight(scene)
        film = base.film if base and not change.objects else FilmCaster(scene)
        same_exposure = base and (base.scene.exposure, base.scene.lighting) == (scene.exposure, scene.lighting)
        meter = base.meter if base and change.nothing and same_exposure else LightMeter(scene, caster)
        return cls(scene, caster, film, meter, sight)


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
    wanted: tuple[Output, ...]
    """What is to be made."""
    color: bool
    """Whether anybody looks at the image of the rig's camera."""


class Stage:
    """Keeps what serves from one moment to the next.

    Args:
        renderer: Renders scenes, which are loaded into it here.
        camera: The rig's.
        wanted: What is to be made.
        caster: Rays against the first scene, where there are such.
    """

    def __init__(
        self,
        renderer: Renderer,
        camera: PinholeCamera,
        wanted: tuple[Output, ...] = USUAL,
        caster: RayCaster | None = None,
    ) -> None:
        self._camera, self._wanted, self._caster = camera, wanted, caster
        self._renderer = renderer if camera.distortion is None else LensRenderer(renderer)
        self._base: Instruments | None = None
        """Those of the first scene, whose paired variants the others are."""
        self._last: Instruments | None = None
        """Those of the last moment."""
        self._loaded: SceneSpec | None = None

    def set_up(
        self, variant: Variant, index: int, viewpoint: Viewpoint, sensors: Mapping[str, MountedSensor] | None = None
    ) -> tuple[Moment, SceneChange]:
        """Return the moment of a viewpoint, and what of its scene differs from the first one; at first everything.

        Args:
            variant: As the viewpoint has it.
            index: Of the viewpoint.
            viewpoint: From where.
            sensors: What will observe it; the rig's camera alone by default.
        """
        change = SceneChange.between(None if self._base is None else self._base.scene, variant.scene)
        if self._last is None or self._last.scene is not variant.scene:
            self._last = Instruments.of(variant.scene, self._base, change, self._caster if self._base is None else None)
            self._base = self._base or self._last
        lit = variant.scene.seen_from(viewpoint)
        shown = self._loaded
        if shown is None or shown.exposure != lit.exposure or not SceneChange.between(shown, lit).nothing:
            self._renderer.load(lit)
            self._loaded = lit
        wanted, camera = self._wanted, self._camera
        color = "rgb" in wanted or any(item.reads_light for name, item in (sensors or {}).items() if name != CAMERA)
        drawn = color or "clean" in wanted or variant.sensor.rgbd.depth.needs_color
        images = CleanImages(self._renderer, camera, "normals" in wanted, drawn)
        moment = Moment(variant, index, viewpoint, lit, camera, self._renderer, images, self._last, wanted, color)
        return moment, change


Readings = Mapping[str, MountedReading[Reading]]


def observe_scene(
    scene: SceneSpec,
    rig: RigConfig,
    renderer: Renderer,
    variants: Sequence[Variant] = (),
    level: bool = False,
    caster: RayCaster | None = None,
) -> Iterator[Observation]:
    """Yield one observation for each viewpoint of a settled scene; with variants, all viewpoints for each of them.

    Paired variants, observations of one viewpoint in several variants, share a ``variant_group``. What differs between
    the scene and a variant of it is one ``SceneChange``; what that leaves alone is taken from the first paired variant.

    Args:
        scene: What to look at.
        rig: Its sensors.
        renderer: Renders the scene, which is loaded into it here.
        variants: The scene and its paired variants, see ``make_variants``; by default the scene alone.
        level: Whether observations of a tilted camera have that of a level one, too.
        caster: Rays against the scene, in whatever light; made here by default.

    Raises:
        ValueError: A level camera is requested, but does not see what the tilted one sees.
    """
    variants = variants or (base_variant(scene, SensorChoice("", rig.rgbd)),)
    stage = Stage(renderer, rig.make_camera(), rig.wanted, caster)
    first: list[tuple[_Unlit, _Unlit | None]] = []
    errors = None
    if rig.calibration is not None:
        errors = rig.calibration.sample(rig.reading(), partial(scene_rng, scene.seed, scene.scene_index))
    for number, variant in enumerate(variants):
        sensors = replace(rig, rgbd=variant.sensor.rgbd).reading()
        kept = [name for name in sensors if name == CAMERA or rig.output_of(name) in rig.wanted]
        for index, viewpoint in enumerate(variant.scene.viewpoints):
            moment, change = stage.set_up(variant.seen_from(index), index, viewpoint, sensors)
            known = first[index] if number else (None, None)
            observation, unlit = _observe(moment, sensors, known[0], change)
            upright, upright_unlit = _observe_level(moment, sensors, observation, known[1], change, level)
            if number == 0 and len(variants) > 1:
                first.append((unlit, upright_unlit))
            group = index if len(variants) > 1 else None
            place = number * len(variant.scene.viewpoints) + index
            yield replace(
                _numbered(observation, place, group, kept),
                level=upright and _numbered(upright, place, group, kept),
                nominal=None if errors is None else errors.nominal(observation, viewpoint),
            )


def _numbered(observation: Observation, index: int, group: int | None, kept: Sequence[str]) -> Observation:
    """Return an observation with its number, its group of variants and the readings of sensors that are ``kept``."""
    conditions = replace(observation.conditions, variant_group=group)
    readings = {name: item for name, item in observation.readings.items() if name in kept}
    return replace(observation, observation_index=index, conditions=conditions, readings=readings)


@dataclass(frozen=True, eq=False)
class _Unlit:
    """What of an observation does not depend on light."""

    targets: list[ObjectInstance]
    amodal_masks: list[AmodalMask]
    film: Bool[np.ndarray, "h w"] | None
    """Pixels in which targets are seen through film."""
    readings: Readings
    """Of the sensors that read no light."""


def _observe(
    moment: Moment, sensors: Mapping[str, MountedSensor], first: _Unlit | None, change: SceneChange
) -> tuple[Observation, _Unlit]:
    """Return the observation of a moment, and what of it its paired variants may take over.

    Args:
        moment: What is observed.
        sensors: What observes it.
        first: That of the first paired variant; None when this is the first.
        change: What differs from the first paired variant's scene.
    """
    known = {} if first is None or change.objects or change.surfaces else first.readings
    readings = _read(moment, sensors, known)
    buffers = moment.images.seen_from(moment.viewpoint.T_world_camera)
    unread = {name: item for name, item in readings.items() if not sensors[name].reads_light}
    if first is None or change.objects:
        unlit = _see_targets(moment, buffers, unread)
    else:
        unlit = replace(first, readings=unread)
    return _annotated(moment, readings, buffers, unlit), unlit


def _observe_level(
    moment: Moment,
    sensors: Mapping[str, MountedSensor],
    observation: Observation,
    first: _Unlit | None,
    change: SceneChange,
    wanted: bool,
) -> tuple[Observation | None, _Unlit | None]:
    """Return the observation of the level virtual camera at the place of a tilted one, None where it is not needed.

    Its images are rendered and read again, from random streams of their own; what other sensors read is the same and
    seen from the level camera.
    """
    camera, T_world_level = level_view(moment.camera, moment.viewpoint.T_world_camera) if wanted else (None, None)
    if camera is None or T_world_level is None or camera == moment.camera:
        return None, None
    viewpoint = replace(moment.viewpoint, T_world_camera=T_world_level)
    images = CleanImages(moment.renderer, camera)
    upright = replace(moment, viewpoint=viewpoint, camera=camera, images=images, wanted=())
    cameras = {name: sensors[name] for name in (CAMERA, RIGHT) if name in sensors}
    renamed = {name: replace(item, stream=f"{item.stream} level") for name, item in cameras.items()}
    level, unlit = _observe(upright, renamed, first, change)
    T_level_camera = invert(T_world_level) @ observation.T_world_camera
    others = {
        name: replace(item, T_camera_sensor=T_level_camera @ item.T_camera_sensor)
        for name, item in observation.readings.items()
        if name not in cameras
    }
    return replace(level, readings={**level.readings, **others}), unlit


def _read(moment: Moment, sensors: Mapping[str, MountedSensor], known: Readings) -> Readings:
    """Return what each sensor of the rig reads, in the rig's order; what is ``known`` is not read again."""
    scene, viewpoint, found = moment.variant.scene, moment.viewpoint, dict[str, MountedReading[Reading]]()
    for name, mounted in sensors.items():
        if name in known:
            found[name] = known[name]
            continue
        view = SensorView(
            scene=moment.scene,
            viewpoint=viewpoint,
            camera=moment.camera,
            T_camera_sensor=mounted.T_camera_sensor(viewpoint),
            caster=moment.instruments.caster,
            images=moment.images,
            readings={before: item.reading for before, item in found.items()},
            name=name,
            film=moment.instruments.sight,
            color=moment.color,
        )
        stream = mounted.stream_of(moment.index, moment.variant.noise_sample)
        reading = mounted.sensor.read(view, scene_rng(scene.seed, scene.scene_index, stream))
        if not isinstance(getattr(reading, "channels", None), Mapping):
            raise WarehouseSimError(
                f"sensors: {name} ({mounted.kind}) gave {type(reading).__name__}, which is no reading: "
                "read() must return an object whose channels are arrays by name"
            )
        found[name] = MountedReading(view.T_camera_sensor, reading)
    return found


def _see_targets(moment: Moment, buffers: RenderBuffers, readings: Readings) -> _Unlit:
    """Return which targets are in view, and how; ``buffers`` are the camera's."""
    camera, T_world_camera = moment.camera, moment.viewpoint.T_world_camera
    targets = targets_in_view(moment.variant.scene, camera, T_world_camera)
    amodal_masks = moment.renderer.amodal_masks(camera, T_world_camera, targets)
    film = moment.instruments.film.image(camera, T_world_camera, buffers, targets)
    return _Unlit(targets, amodal_masks, film, readings)


def _annotated(moment: Moment, readings: Readings, buffers: RenderBuffers, unlit: _Unlit) -> Observation:
    """Return the observation with its labels, and the light that was measured."""
    variant, viewpoint, camera = moment.variant, moment.viewpoint, moment.camera
    T_world_camera, meter = viewpoint.T_world_camera, moment.instruments.meter
    camera_reading = readings[CAMERA].reading
    assert isinstance(camera_reading, RgbdReading)
    labels = annotate(
        variant.scene, camera, T_world_camera, buffers, camera_reading.depth,
        unlit.amodal_masks, unlit.targets, unlit.film,
    )  # fmt: skip
    visible = [item.instance_id for item in labels if item.pixels_visible > 0]
    lux = target_illuminance(meter, viewpoint, camera, buffers.instance_mask, visible)
    measured = measure_conditions(meter, viewpoint)
    return Observation(
        scene_index=variant.scene.scene_index,
        observation_index=moment.index,
        camera=camera,
        T_world_camera=T_world_camera,
        readings=readings,
        buffers=buffers,
        annotations=tuple(replace(item, illuminance=lux.get(item.instance_id)) for item in labels),
        viewpoint=viewpoint,
        object_coordinates=object_coordinates(camera, buffers, labels)
        if "object_coordinates" in moment.wanted
        else None,
        class_numbers=class_numbers(variant.scene, buffers.instance_mask) if "class_mask" in moment.wanted else None,
        conditions=replace(measured, variant=variant.name, absent=variant.absent, sensor=variant.sensor.name),
    )
