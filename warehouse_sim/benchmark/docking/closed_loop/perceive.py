"""Who estimates the pallet on the way: ground truth, or an estimator that sees what the truck's camera sees."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Float32, Int32, UInt8

from warehouse_sim.benchmark.docking.closed_loop.drive import Glance
from warehouse_sim.estimators.api import PoseEstimator
from warehouse_sim.estimators.gravity import down_of_camera
from warehouse_sim.estimators.image import Detection, RgbdImage
from warehouse_sim.estimators.tracking.tracker import View, in_sight
from warehouse_sim.generation.light import light_scene
from warehouse_sim.generation.observe import Stage
from warehouse_sim.generation.occlusion import FractionRange, OcclusionConfig, VisibleFractions, request_views
from warehouse_sim.generation.recipe import Recipe
from warehouse_sim.generation.recipe.paired_variants import base_variant, overlaid
from warehouse_sim.generation.scene import SampledScene
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform, invert
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.render.renderer import Renderer
from warehouse_sim.scene import scene_rng
from warehouse_sim.schema import CAMERA, ObjectInstance, ObjectModel, PoseEstimate, RgbdReading, SceneSpec, Viewpoint
from warehouse_sim.sensors.rgbd.depth.models import MODELS, PRESETS
from warehouse_sim.sensors.rig import SensorChoice
from warehouse_sim.sensors.view import SensorView

_KEPT_CLEAR = 2.6
"""Least distance from the camera to what is put before the pallet (m): it is passed by nobody before it leaves."""


@dataclass(frozen=True, eq=False)
class Shot:
    """What the truck's camera read, and the ground truth behind it."""

    scene_index: int
    camera: PinholeCamera
    rgb: UInt8[np.ndarray, "h w 3"]
    depth: Float32[np.ndarray, "h w"]
    instance_mask: Int32[np.ndarray, "h w"]


Relight = Callable[[SceneSpec], SceneSpec]
"""Return a scene in the wanted light, its viewpoints exposed for what they see."""


class LiveScene:
    """One scene in one light before one camera.

    Args:
        recipe: Its rig is the truck's.
        sampled: The scene.
        renderer: Draws; the scene is loaded into it here.
        light: Preset of the light; the other settings are the recipe's own.
        sensor: Model or preset of the depth camera, "own" for what the recipe draws.
        hidden: The scene with what hides the pallet at first, None where nothing does.
        hidden_for: Way (m) after which that is gone.
    """

    def __init__(
        self,
        recipe: Recipe,
        sampled: SampledScene,
        renderer: Renderer,
        light: str,
        sensor: str,
        hidden: SceneSpec | None = None,
        hidden_for: float = 0.0,
    ) -> None:
        self._camera = recipe.sensors.make_camera()
        self._stage = Stage(renderer, self._camera)
        self.choice = choice_of(recipe, sampled, sensor)
        rig = replace(recipe.sensors, rgbd=self.choice.rgbd, lidar=None, lidars={}, right=None, imu=None, more={})
        self._sensor = rig.mounted()[CAMERA]
        self._scenes = [self._prepared(recipe, sampled, sampled.scene, light)]
        self._hidden_for = hidden_for if hidden is not None else 0.0
        if hidden is not None:
            self._scenes.append(self._prepared(recipe, sampled, hidden, light))

    def shoot(self, viewpoint: Viewpoint, driven: float, stream: str) -> Shot:
        """Return what the camera reads at a place.

        Args:
            viewpoint: Where the truck stands and how it moves.
            driven: How far it has come (m).
            stream: Name of the random stream of this image's noise.
        """
        scene, relight = self._scenes[1 if driven < self._hidden_for else 0]
        (viewpoint,) = relight(replace(scene, viewpoints=(viewpoint,))).viewpoints
        moment, _ = self._stage.set_up(base_variant(scene, self.choice), 0, viewpoint)
        buffers = moment.images.seen_from(viewpoint.T_world_camera)
        view = SensorView(
            scene=moment.scene,
            viewpoint=viewpoint,
            camera=moment.camera,
            T_camera_sensor=self._sensor.T_camera_sensor(viewpoint),
            caster=moment.instruments.caster,
            images=moment.images,
            readings={},
            name=CAMERA,
            film=moment.instruments.sight,
        )
        reading = self._sensor.sensor.read(view, scene_rng(scene.seed, scene.scene_index, stream))
        assert isinstance(reading, RgbdReading)
        return Shot(scene.scene_index, moment.camera, reading.rgb, reading.depth, buffers.instance_mask)

    def _prepared(
        self, recipe: Recipe, sampled: SampledScene, scene: SceneSpec, light: str
    ) -> tuple[SceneSpec, Relight]:
        caster = RayCaster(scene)
        settings = overlaid(sampled.settings.lights, {"preset": light}, f"{recipe.name}: lights")

        def relight(dark: SceneSpec) -> SceneSpec:
            return light_scene(dark, settings, caster, self._camera, sampled.stream("lighting"))

        return relight(replace(scene, viewpoints=scene.viewpoints[:1])), relight


def choice_of(recipe: Recipe, sampled: SampledScene, sensor: str) -> SensorChoice:
    """Return the RGB-D camera of a scene with one of the depth models in place of its own, its unit drawn as usual."""
    own = recipe.sensors.sample_sensor(sampled.stream("sensor"))
    if sensor == "own":
        return own
    model = PRESETS[sensor] if sensor in PRESETS else MODELS[sensor]()
    return SensorChoice(sensor, replace(own.rgbd, depth=model.sampled(sampled.stream("sensor"))))


def hidden_scene(
    recipe: Recipe, sampled: SampledScene, view: Viewpoint, target: int, visible: tuple[float, float], stream: str
) -> tuple[SceneSpec | None, str]:
    """Return the scene with something before a pallet, so that no more than is requested is seen, or why there is none.

    Args:
        recipe: Of the scene.
        sampled: The scene.
        view: The first view; it stays where it is.
        target: Instance id of the pallet.
        visible: Least and greatest visible fraction.
        stream: Name of the random stream.
    """
    first = replace(view, target=target, sequence=0)
    scene = replace(sampled.scene, viewpoints=(first,))
    evaluated = VisibleFractions((FractionRange(*visible),))
    config = OcclusionConfig(evaluated, kinds=("traffic", "load"), tries=24, camera_clearance=_KEPT_CLEAR)
    rng = scene_rng(scene.seed, scene.scene_index, stream)
    found, report = request_views(scene, sampled.settings, recipe.sensors.make_camera(), config, RayCaster(scene), rng)
    (outcome,) = report.requests
    return (None, outcome.reason) if outcome.reason else (found, "")


_LEAST_PIXELS = 32
"""As estimators ask of a dataset's ground-truth masks."""


def nominal(sigma: float, turn_deg: float) -> Float[np.ndarray, "6 6"]:
    """Return the covariance of estimates that state none: by place (m) and by turn (deg), standard deviations."""
    return np.diag([sigma**2] * 3 + [float(np.deg2rad(turn_deg)) ** 2] * 3)


@dataclass(frozen=True, eq=False)
class Oracle:
    """Knows the pallet while it is in sight; ``T_object_wrong`` makes it wrong by always the same."""

    pallet: ObjectInstance
    model: ObjectModel
    camera: PinholeCamera
    T_object_wrong: Transform | None = None
    min_score: float = 0.0

    def __call__(self, glance: Glance) -> PoseEstimate | None:
        """Return the true pose in the camera frame."""
        T_world_camera = glance.viewpoint.T_world_camera
        here = View(0, glance.index, self.camera, T_world_camera, glance.viewpoint.time)
        if not in_sight(here, self.pallet.T_world_object[:3, 3]):
            return None
        T = invert(T_world_camera) @ self.pallet.T_world_object
        T = T if self.T_object_wrong is None else T @ self.T_object_wrong
        return PoseEstimate(0, glance.index, self.model.obj_id, 1.0, T, covariance=nominal(0.002, 0.1))


@dataclass(frozen=True, eq=False)
class Seen:
    """An estimator on live images, with the ground-truth mask of the pallet.

    Args:
        live: Renders what the truck sees.
        estimator: Estimates poses.
        pallet: The truck's.
        model: Its geometry.
        number: Of the approach; images of one scene have numbers of their own.
        min_score: Scores below this do not count, of estimators whose uncertainty was fitted; a score without
            uncertainty is no probability, and counts whatever it is.
        sigma: What is taken for the covariance where the estimator states none.
    """

    live: LiveScene
    estimator: PoseEstimator
    pallet: ObjectInstance
    model: ObjectModel
    number: int
    min_score: float = 0.2
    sigma: tuple[float, float] = (0.02, 1.5)

    def __call__(self, glance: Glance) -> PoseEstimate | None:
        """Return the estimate of the pallet that the truck was sent to."""
        shot = self.live.shoot(glance.viewpoint, glance.driven, f"closed loop {self.number} {glance.index}")
        image = RgbdImage(
            shot.camera,
            shot.depth,
            (),
            shot.rgb,
            shot.scene_index,
            1000 * self.number + glance.index,
            glance.T_odom_camera,
            down_of_camera(glance.T_odom_camera),
        )
        mask = shot.instance_mask == self.pallet.instance_id
        if int(mask.sum()) < _LEAST_PIXELS:
            return None
        mine = Detection(mask, self.model.obj_id, number=self.pallet.instance_id)
        estimates = self.estimator.estimate(replace(image, detections=(mine,)))
        found = [item for item in estimates if item.obj_id == self.model.obj_id]
        if not found:
            return None
        best = max(found, key=lambda item: item.score)
        if best.covariance is not None:
            return best
        return replace(best, covariance=nominal(*self.sigma), score=max(best.score, self.min_score))
