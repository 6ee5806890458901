"""A settled scene becomes observations: render -> sense -> annotate, one viewpoint after the other, twin after twin."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from jaxtyping import Bool

from warehouse_sim.annotate import annotate, targets_in_view
from warehouse_sim.errors import WarehouseSimError
from warehouse_sim.generation.instruments import Instruments
from warehouse_sim.generation.light import measure_conditions, target_illuminance
from warehouse_sim.generation.twins import Variant, base_variant
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.level_view import level_view
from warehouse_sim.geometry.pose import invert
from warehouse_sim.render.lens import LensRenderer
from warehouse_sim.render.renderer import Renderer, Silhouette
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
from warehouse_sim.sensors.rig import MountedSensor, RigConfig, SensorChoice
from warehouse_sim.sensors.view import CleanImages, SensorView

Readings = Mapping[str, MountedReading[Reading]]


def observe_scene(
    scene: SceneSpec, rig: RigConfig, renderer: Renderer, variants: Sequence[Variant] = (), level: bool = False
) -> Iterator[Observation]:
    """Yield one observation for each viewpoint of a settled scene; with variants, all viewpoints for each of them.

    Twins, observations of one viewpoint in several variants, share a ``twin_group``. What differs between the scene and
    a variant of it is one ``SceneChange``; what that leaves alone is taken from the first twin.

    Args:
        scene: What to look at.
        rig: Its sensors.
        renderer: Draws; the scene is loaded into it here.
        variants: The scene and its twins, see ``make_variants``; by default the scene alone.
        level: Whether observations of a tilted camera have that of a level one, too.

    Raises:
        ValueError: A level camera is asked for, but does not see what the tilted one sees.
    """
    variants = variants or (base_variant(scene, SensorChoice("", rig.rgbd)),)
    camera = rig.make_camera()
    seeing = renderer if camera.distortion is None else LensRenderer(renderer)
    first: list[tuple[_Unlit, _Unlit | None]] = []
    base, loaded, errors = None, None, None
    if rig.calibration is not None:
        errors = rig.calibration.draw(rig.mounted(), partial(scene_rng, scene.seed, scene.scene_index))
    for number, variant in enumerate(variants):
        change = SceneChange.between(None if base is None else base.scene, variant.scene)
        instruments = Instruments.of(variant.scene, base, change)
        base = base or instruments
        sensors = replace(rig, rgbd=variant.sensor.rgbd).mounted()
        for index, viewpoint in enumerate(variant.scene.viewpoints):
            lit = variant.scene.seen_from(viewpoint)
            if loaded is None or _needs_reload(loaded, lit):
                seeing.load(lit)
                loaded = lit
            context = _Context(variant, index, viewpoint, lit, camera, seeing, CleanImages(seeing, camera), instruments)
            known = first[index] if number else (None, None)
            observation, unlit = _observe(context, sensors, known[0], change)
            upright, upright_unlit = _observe_level(context, sensors, observation, known[1], change, level)
            if number == 0 and len(variants) > 1:
                first.append((unlit, upright_unlit))
            group = index if len(variants) > 1 else None
            place = number * len(variant.scene.viewpoints) + index
            yield replace(
                _numbered(observation, place, group),
                level=upright and _numbered(upright, place, group),
                stated=None if errors is None else errors.stated(observation, viewpoint),
            )


def _numbered(observation: Observation, index: int, group: int | None) -> Observation:
    conditions = replace(observation.conditions, twin_group=group)
    return replace(observation, observation_index=index, conditions=conditions)


@dataclass(frozen=True, eq=False)
class _Context:
    """One viewpoint of one variant, with all that an observation of it needs."""

    variant: Variant
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


@dataclass(frozen=True, eq=False)
class _Unlit:
    """What of an observation does not depend on light."""

    targets: list[ObjectInstance]
    silhouettes: list[Silhouette]
    film: Bool[np.ndarray, "h w"] | None
    """Pixels in which targets are seen through film."""
    readings: Readings
    """Of the sensors that read no light."""


def _needs_reload(before: SceneSpec, after: SceneSpec) -> bool:
    return before.exposure != after.exposure or not SceneChange.between(before, after).nothing


def _observe(
    context: _Context, sensors: Mapping[str, MountedSensor], first: _Unlit | None, change: SceneChange
) -> tuple[Observation, _Unlit]:
    """Return the observation of a moment, and what of it its twins may take over.

    Args:
        context: What is observed.
        sensors: What observes it.
        first: That of the first twin; None when this is the first.
        change: What differs from the first twin's scene.
    """
    known = {} if first is None or change.objects or change.surfaces else first.readings
    readings = _read(context, sensors, known)
    buffers = context.images.seen_from(context.viewpoint.T_world_camera)
    unread = {name: item for name, item in readings.items() if not sensors[name].reads_light}
    if first is None or change.objects:
        unlit = _see_targets(context, buffers, unread)
    else:
        unlit = replace(first, readings=unread)
    return _annotated(context, readings, buffers, unlit), unlit


def _observe_level(
    context: _Context,
    sensors: Mapping[str, MountedSensor],
    observation: Observation,
    first: _Unlit | None,
    change: SceneChange,
    wanted: bool,
) -> tuple[Observation | None, _Unlit | None]:
    """Return the observation of the level virtual camera at the place of a tilted one, None where it is not needed.

    Its images are rendered and read anew, from random streams of their own; what other sensors read is the same and
    seen from the level camera.
    """
    camera, T_world_level = level_view(context.camera, context.viewpoint.T_world_camera) if wanted else (None, None)
    if camera is None or T_world_level is None or camera == context.camera:
        return None, None
    viewpoint = replace(context.viewpoint, T_world_camera=T_world_level)
    upright = replace(context, viewpoint=viewpoint, camera=camera, images=CleanImages(context.renderer, camera))
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


def _read(context: _Context, sensors: Mapping[str, MountedSensor], known: Readings) -> Readings:
    """Return what each sensor of the rig reads, in the rig's order; what is ``known`` is not read again."""
    scene, viewpoint, found = context.variant.scene, context.viewpoint, dict[str, MountedReading[Reading]]()
    for name, mounted in sensors.items():
        if name in known:
            found[name] = known[name]
            continue
        view = SensorView(
            scene=context.scene,
            viewpoint=viewpoint,
            camera=context.camera,
            T_camera_sensor=mounted.T_camera_sensor(viewpoint),
            caster=context.instruments.caster,
            images=context.images,
            readings={before: item.reading for before, item in found.items()},
            name=name,
        )
        stream = mounted.stream_of(context.index, context.variant.noise_draw)
        reading = mounted.sensor.read(view, scene_rng(scene.seed, scene.scene_index, stream))
        if not isinstance(getattr(reading, "channels", None), Mapping):
            raise WarehouseSimError(
                f"sensors: {name} ({mounted.kind}) gave {type(reading).__name__}, which is no reading: "
                "read() must return an object whose channels are arrays by name"
            )
        found[name] = MountedReading(view.T_camera_sensor, reading)
    return found


def _see_targets(context: _Context, buffers: RenderBuffers, readings: Readings) -> _Unlit:
    """Return which targets are in view, and how; ``buffers`` are the camera's."""
    camera, T_world_camera = context.camera, context.viewpoint.T_world_camera
    targets = targets_in_view(context.variant.scene, camera, T_world_camera)
    silhouettes = context.renderer.silhouettes(camera, T_world_camera, targets)
    film = context.instruments.film.image(camera, T_world_camera, buffers, targets)
    return _Unlit(targets, silhouettes, film, readings)


def _annotated(context: _Context, readings: Readings, buffers: RenderBuffers, unlit: _Unlit) -> Observation:
    """Return the observation with its labels, and the light that was measured."""
    variant, viewpoint, camera = context.variant, context.viewpoint, context.camera
    T_world_camera, meter = viewpoint.T_world_camera, context.instruments.meter
    camera_reading = readings[CAMERA].reading
    assert isinstance(camera_reading, RgbdReading)
    labels = annotate(
        variant.scene, camera, T_world_camera, buffers, camera_reading.depth,
        unlit.silhouettes, unlit.targets, unlit.film,
    )  # fmt: skip
    visible = [item.instance_id for item in labels if item.pixels_visible > 0]
    lux = target_illuminance(meter, viewpoint, camera, buffers.instance_ids, visible)
    measured = measure_conditions(meter, viewpoint)
    return Observation(
        scene_index=variant.scene.scene_index,
        observation_index=context.index,
        camera=camera,
        T_world_camera=T_world_camera,
        readings=readings,
        buffers=buffers,
        annotations=tuple(replace(item, illuminance=lux.get(item.instance_id)) for item in labels),
        viewpoint=viewpoint,
        conditions=replace(measured, variant=variant.name, absent=variant.absent, sensor=variant.sensor.name),
    )
