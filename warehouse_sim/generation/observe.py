"""A settled scene becomes observations: render -> sense -> annotate, one viewpoint after the other, twin after twin."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from warehouse_sim.annotate import annotate, targets_in_view
from warehouse_sim.generation.twins import Variant, base_variant
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.render.renderer import Renderer, Silhouette
from warehouse_sim.scene.streams import scene_rng
from warehouse_sim.schema import Conditions, LidarScan, ObjectInstance, Observation, SceneSpec, Viewpoint
from warehouse_sim.sensors.lidar import scan
from warehouse_sim.sensors.rgbd import read_rgbd
from warehouse_sim.sensors.rig import RigConfig


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
    lidar: LidarScan | None


class _Watch:
    """Observes, and remembers of each viewpoint what twins can share."""

    def __init__(self, rig: RigConfig, renderer: Renderer, with_twins: bool) -> None:
        self._rig, self._renderer, self._with_twins = rig, renderer, with_twins
        self._camera, self._T_camera_lidar = rig.make_camera(), rig.T_camera_lidar()
        self._views: dict[int, _View] = {}
        self._caster: tuple[Variant, RayCaster] | None = None
        self._loaded: SceneSpec | None = None

    def observe(self, variant: Variant, index: int, viewpoint: Viewpoint) -> Observation:
        """Return the observation of viewpoint number ``index`` of a variant, under that index."""
        scene, T_world_camera = variant.scene, viewpoint.T_world_camera
        self._load(scene.seen_from(viewpoint))
        buffers = self._renderer.render(self._camera, T_world_camera)
        draw = f" draw {variant.noise_draw}" if variant.noise_draw else ""
        rgbd = read_rgbd(buffers, variant.rgbd, scene_rng(scene.seed, scene.scene_index, f"rgbd {index}{draw}"))
        view = self._view(variant, index, T_world_camera)
        labels = annotate(
            scene, self._camera, T_world_camera, buffers, rgbd.depth, view.silhouettes, targets=view.targets
        )
        return Observation(
            scene_index=scene.scene_index,
            observation_index=index,
            camera=self._camera,
            T_world_camera=T_world_camera,
            T_camera_lidar=self._T_camera_lidar,
            rgbd=rgbd,
            buffers=buffers,
            lidar=view.lidar,
            annotations=labels,
            viewpoint=viewpoint,
            conditions=self._conditions(variant, index),
        )

    def _load(self, scene: SceneSpec) -> None:
        if self._loaded is not scene:
            self._renderer.load(scene)
            self._loaded = scene

    def _view(self, variant: Variant, index: int, T_world_camera: Transform) -> _View:
        """Return what does not depend on light and noise, as far as it is known from a twin."""
        known = self._views.get(index)
        if known is not None and variant.same_surfaces_as(known.variant):
            return known
        lidar = self._scan(variant, index, T_world_camera)
        if known is not None and variant.same_things_as(known.variant):
            return replace(known, lidar=lidar)
        targets = targets_in_view(variant.scene, self._camera, T_world_camera)
        silhouettes = self._renderer.silhouettes(self._camera, T_world_camera, targets)
        view = _View(variant, targets, silhouettes, lidar)
        if self._with_twins and known is None:
            self._views[index] = view
        return view

    def _scan(self, variant: Variant, index: int, T_world_camera: Transform) -> LidarScan | None:
        if self._rig.lidar is None:
            return None
        if self._caster is None or not variant.same_surfaces_as(self._caster[0]):
            self._caster = variant, RayCaster(variant.scene)
        rng = scene_rng(variant.scene.seed, variant.scene.scene_index, f"lidar {index}")
        return scan(self._caster[1], self._rig.lidar, T_world_camera @ self._T_camera_lidar, rng)

    def _conditions(self, variant: Variant, index: int) -> Conditions:
        return Conditions(
            lighting=variant.scene.lighting,
            variant=variant.name,
            twin_group=index if self._with_twins else None,
            absent=variant.absent,
        )
