"""A settled scene becomes observations: render -> sense -> annotate, one viewpoint after the other, twin after twin."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool

from warehouse_sim.annotate import annotate, targets_in_view
from warehouse_sim.annotate.film import FilmCaster
from warehouse_sim.generation.light_meter import LightMeter
from warehouse_sim.generation.lighting import measure_conditions, target_illuminance
from warehouse_sim.generation.twins import Variant, base_variant
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.render.lens import LensRenderer
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.render.renderer import Renderer, Silhouette
from warehouse_sim.scene.lighting import ev_of_exposure
from warehouse_sim.scene.streams import scene_rng
from warehouse_sim.schema import (
    CAMERA,
    LIDAR,
    RIGHT,
    LidarScan,
    MountedReading,
    ObjectInstance,
    Observation,
    Reading,
    RenderBuffers,
    RgbdReading,
    SceneSpec,
    StereoReading,
    Viewpoint,
)
from warehouse_sim.sensors.lidar import EgoMotion, LidarConfig, scan
from warehouse_sim.sensors.rgbd import read_rgbd
from warehouse_sim.sensors.rig import RigConfig
from warehouse_sim.sensors.shot import Shot, camera_motion
from warehouse_sim.sensors.stereo import T_camera_right, read_stereo
from warehouse_sim.sensors.surfaces import see_surfaces


def observe_scene(
    scene: SceneSpec, rig: RigConfig, renderer: Renderer, variants: Sequence[Variant] = ()
) -> Iterator[Observation]:
    """Yield one observation for each viewpoint of a settled scene; with variants, all viewpoints for each of them.

    Twins, observations of one viewpoint in several variants, share a ``twin_group``. What a change leaves alone is not
    made again: labels and LiDAR of a twin in another light are those of the first.

    Args:
        scene: What to look at.
        rig: Camera, depth noise and LiDAR.
        renderer: Draws; the scene is loaded into it here.
        variants: The scene and its twins, see ``make_variants``; by default the scene alone.
    """
    variants = variants or (base_variant(scene, rig.rgbd),)
    watch = _Watch(rig, renderer, with_twins=len(variants) > 1)
    for number, variant in enumerate(variants):
        for index, viewpoint in enumerate(variant.scene.viewpoints):
            observation = watch.observe(variant, index, viewpoint)
            yield replace(observation, observation_index=number * len(variant.scene.viewpoints) + index)


@dataclass(frozen=True, eq=False)
class _View:
    """What twins of one viewpoint can share."""

    variant: Variant
    """In which it was seen."""
    targets: list[ObjectInstance]
    silhouettes: list[Silhouette]
    film: Bool[np.ndarray, "h w"] | None
    """Pixels in which targets are seen through film."""
    lidars: dict[str, MountedReading[LidarScan]]


class _Watch:
    """Observes, and remembers of each viewpoint what twins can share."""

    def __init__(self, rig: RigConfig, renderer: Renderer, with_twins: bool) -> None:
        self._rig, self._with_twins = rig, with_twins
        self._camera = rig.make_camera()
        self._renderer = renderer if self._camera.distortion is None else LensRenderer(renderer)
        self._views: dict[int, _View] = {}
        self._caster: tuple[Variant, RayCaster] | None = None
        self._meter: LightMeter | None = None
        self._film: tuple[Variant, FilmCaster] | None = None
        self._loaded: SceneSpec | None = None

    def observe(self, variant: Variant, index: int, viewpoint: Viewpoint) -> Observation:
        """Return the observation of viewpoint number ``index`` of a variant, under that index."""
        scene, T_world_camera = variant.scene, viewpoint.T_world_camera
        self._load(scene.seen_from(viewpoint))
        buffers = self._renderer.render(self._camera, T_world_camera, normals=variant.rgbd.depth.needs_normals)
        draw = f" draw {variant.noise_draw}" if variant.noise_draw else ""
        rng = scene_rng(scene.seed, scene.scene_index, f"rgbd {index}{draw}")
        rgbd = read_rgbd(buffers, self._shot(variant, viewpoint), variant.rgbd, rng)
        stereo = self._stereo(variant, index, viewpoint, buffers, rgbd)
        view = self._view(variant, index, viewpoint, buffers)
        labels = annotate(
            scene, self._camera, T_world_camera, buffers, rgbd.depth, view.silhouettes, view.targets, view.film
        )
        meter = self._meter_of(variant)
        seen = [item.instance_id for item in labels if item.pixels_visible > 0]
        lux = target_illuminance(meter, viewpoint, self._camera, buffers.instance_ids, seen)
        readings: dict[str, MountedReading[Reading]] = {CAMERA: MountedReading(np.eye(4), rgbd), **view.lidars}
        if self._rig.right is not None and stereo is not None:
            readings[RIGHT] = MountedReading(T_camera_right(self._rig.right), stereo)
        return Observation(
            scene_index=scene.scene_index,
            observation_index=index,
            camera=self._camera,
            T_world_camera=T_world_camera,
            readings=readings,
            buffers=buffers,
            annotations=tuple(replace(item, illuminance=lux.get(item.instance_id)) for item in labels),
            viewpoint=viewpoint,
            conditions=replace(
                measure_conditions(meter, viewpoint),
                variant=variant.name,
                twin_group=index if self._with_twins else None,
                absent=variant.absent,
            ),
        )

    def _stereo(
        self, variant: Variant, index: int, viewpoint: Viewpoint, left: RenderBuffers, read: RgbdReading
    ) -> StereoReading | None:
        """Return what the second camera adds, drawn in the light that is loaded."""
        config, color = self._rig.right, variant.rgbd.color
        if config is None:
            return None
        there = replace(viewpoint, T_world_camera=viewpoint.T_world_camera @ T_camera_right(config))
        right = self._renderer.render(self._camera, there.T_world_camera)
        exposure_ev = ev_of_exposure(variant.scene.seen_from(viewpoint).exposure)
        shot = Shot(self._camera, exposure_ev, camera_motion(there))
        draw = f" draw {variant.noise_draw}" if variant.noise_draw else ""
        rng = scene_rng(variant.scene.seed, variant.scene.scene_index, f"right {index}{draw}")
        return read_stereo(left, read.rgb, right, shot, color, config, rng)

    def _shot(self, variant: Variant, viewpoint: Viewpoint) -> Shot:
        surfaces, T_world_camera = None, viewpoint.T_world_camera
        if variant.rgbd.depth.needs_surfaces:
            surfaces = see_surfaces(variant.scene, self._caster_of(variant), self._camera, T_world_camera)
        exposure_ev = ev_of_exposure(variant.scene.seen_from(viewpoint).exposure)
        return Shot(self._camera, exposure_ev, camera_motion(viewpoint), surfaces)

    def _load(self, scene: SceneSpec) -> None:
        if self._loaded is not scene:
            self._renderer.load(scene)
            self._loaded = scene

    def _view(self, variant: Variant, index: int, viewpoint: Viewpoint, buffers: RenderBuffers) -> _View:
        """Return what does not depend on light and noise, as far as it is known from a twin."""
        known, T_world_camera = self._views.get(index), viewpoint.T_world_camera
        if known is not None and variant.same_surfaces_as(known.variant):
            return known
        lidars = self._lidars(variant, index, viewpoint)
        if known is not None and variant.same_things_as(known.variant):
            return replace(known, lidars=lidars)
        targets = targets_in_view(variant.scene, self._camera, T_world_camera)
        silhouettes = self._renderer.silhouettes(self._camera, T_world_camera, targets)
        film = self._film_of(variant).image(self._camera, T_world_camera, buffers, targets)
        view = _View(variant, targets, silhouettes, film, lidars)
        if self._with_twins and known is None:
            self._views[index] = view
        return view

    def _lidars(self, variant: Variant, index: int, viewpoint: Viewpoint) -> dict[str, MountedReading[LidarScan]]:
        found = {}
        if self._rig.lidar is not None:
            T_camera_lidar = self._rig.T_camera_lidar(viewpoint)
            sweep = self._scan(variant, self._rig.lidar, T_camera_lidar, viewpoint, f"lidar {index}")
            found[LIDAR] = MountedReading(T_camera_lidar, sweep)
        for name, item in self._rig.lidars.items():
            T_camera_lidar = item.mount.T_camera_sensor(viewpoint)
            sweep = self._scan(variant, item.lidar, T_camera_lidar, viewpoint, f"lidar {name} {index}")
            found[name] = MountedReading(T_camera_lidar, sweep)
        return found

    def _scan(
        self, variant: Variant, config: LidarConfig, T_camera_lidar: Transform, viewpoint: Viewpoint, stream: str
    ) -> LidarScan:
        rng = scene_rng(variant.scene.seed, variant.scene.scene_index, stream)
        T_world_lidar = viewpoint.T_world_camera @ T_camera_lidar
        return scan(self._caster_of(variant), config, T_world_lidar, rng, EgoMotion.of(viewpoint))

    def _caster_of(self, variant: Variant) -> RayCaster:
        if self._caster is None or not variant.same_surfaces_as(self._caster[0]):
            self._caster = variant, RayCaster(variant.scene)
        return self._caster[1]

    def _film_of(self, variant: Variant) -> FilmCaster:
        if self._film is None or not variant.same_things_as(self._film[0]):
            self._film = variant, FilmCaster(variant.scene)
        return self._film[1]

    def _meter_of(self, variant: Variant) -> LightMeter:
        if self._meter is None or self._meter.scene is not variant.scene:
            self._meter = LightMeter(variant.scene, self._caster_of(variant))
        return self._meter
