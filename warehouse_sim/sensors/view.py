"""What a sensor is, and what it may ask of the moment at which it reads."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Protocol

import numpy as np

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.render.renderer import Renderer, render_without_color
from warehouse_sim.scene.lighting.exposure import ev_of_exposure
from warehouse_sim.schema import Reading, RenderBuffers, SceneSpec, Viewpoint
from warehouse_sim.sensors.film import FilmImage, FilmSight, see_film
from warehouse_sim.sensors.motion import EgoMotion, Motion, camera_motion
from warehouse_sim.sensors.surfaces import Surfaces, see_surfaces
from warehouse_sim.sensors.white_balance import WHITE, Rgb, light_color


@dataclass(frozen=True, eq=False)
class Capture:
    """One image of a camera."""

    camera: PinholeCamera
    exposure_ev: float | None = None
    """Exposure value at ISO 100 that the image was rendered for; None = enough light for the least gain."""
    motion: Motion = field(default_factory=Motion)
    surfaces: Surfaces | None = None
    """Materials of the pixels, for depth models that need them."""
    film: FilmImage | None = None
    """Stretch film before the pixels, for depth models that see it; None = none in view."""
    light: Rgb = WHITE
    """Colour, of unit luminance, of the light on what is seen, for cameras that balance it."""


class CleanImages:
    """What the rig's camera would see without errors at one moment; each place is rendered when first requested.

    Args:
        renderer: The scene is loaded into it in the light of the moment.
        camera: Intrinsics and lens.
        normals: Whether every rendering has normals, requested or not.
        color: Whether colours are drawn.
    """

    def __init__(self, renderer: Renderer, camera: PinholeCamera, normals: bool = False, color: bool = True) -> None:
        self._camera, self._normals = camera, normals
        self._render = renderer.render if color else partial(render_without_color, renderer)
        self._rendered: dict[bytes, RenderBuffers] = {}

    def seen_from(self, T_world_camera: Transform, normals: bool = False) -> RenderBuffers:
        """Return the buffers of a camera at ``T_world_camera``; normals are among them at least where requested."""
        place = (T_world_camera + 0.0).tobytes()  # the sum has no negative zeros
        known = self._rendered.get(place)
        if known is None or (normals and known.normals is None):
            normals = normals or self._normals
            known = self._rendered[place] = self._render(self._camera, T_world_camera, normals=normals)
        return known


@dataclass(frozen=True, eq=False)
class SensorView:
    """One sensor's view of one moment: where it is, what is there, and what is seen."""

    scene: SceneSpec
    """The settled scene in the light and exposure of the moment."""
    viewpoint: Viewpoint
    """Where the rig stands, and how it moves."""
    camera: PinholeCamera
    """The rig's camera."""
    T_camera_sensor: Transform
    """Pose of the sensor in the camera frame: x forward, y left, z up; of a camera x right, y down, z forward."""
    caster: RayCaster
    """Exact rays against the scene."""
    images: CleanImages
    """What the rig's camera, or one like it elsewhere, would see without errors."""
    readings: Mapping[str, Reading]
    """What the sensors of the rig before this one read at the same moment, by name."""
    name: str = ""
    """Of the sensor in the rig, by which the constant errors of its unit are rendered."""
    film: FilmSight | None = None
    """Exact rays against the scene's film; None = there is none."""
    color: bool = True
    """Whether anybody wants the image of the rig's camera; where not, it may be left out."""

    @property
    def T_world_camera(self) -> Transform:
        """Pose of the rig's camera in the world."""
        return self.viewpoint.T_world_camera

    @property
    def T_world_sensor(self) -> Transform:
        """Pose of the sensor in the world."""
        return self.T_world_camera @ self.T_camera_sensor

    @property
    def ego_motion(self) -> EgoMotion | None:
        """How the vehicle moves; None when it stands."""
        return EgoMotion.of(self.viewpoint)

    @property
    def exposure_ev(self) -> float:
        """Exposure value at ISO 100 that the rig's camera is set to."""
        return ev_of_exposure(self.scene.exposure)

    def render(self, T_world_camera: Transform | None = None, normals: bool = False) -> RenderBuffers:
        """Return the clean images of the rig's camera, or of one like it at ``T_world_camera``.

        Raises:
            RenderError: The backend renders no normals, but they are requested.
        """
        return self.images.seen_from(self.T_world_camera if T_world_camera is None else T_world_camera, normals)

    def surfaces(self, T_world_camera: Transform | None = None, reflections: bool = False) -> Surfaces:
        """Return the materials behind the pixels of ``render``, and the light that smooth ones throw on if asked."""
        place = self.T_world_camera if T_world_camera is None else T_world_camera
        return see_surfaces(self.scene, self.caster, self.camera, place, reflections)

    def film_before(self, T_world_camera: Transform | None = None) -> FilmImage | None:
        """Return the film before the pixels of ``render``; None where there is none."""
        place = self.T_world_camera if T_world_camera is None else T_world_camera
        return None if self.film is None else see_film(self.film, self.camera, place, self.render(place).depth)

    def light_color(self, T_world_camera: Transform) -> Rgb:
        """Return the colour, of unit luminance, of the light on what a camera at ``T_world_camera`` sees."""
        rgb = self.render(T_world_camera).rgb
        return light_color(self.scene, self.caster, self.camera, T_world_camera, rgb)

    def camera_motion(self, T_world_camera: Transform) -> Motion:
        """Return how a camera at ``T_world_camera`` moves with the vehicle, in its own frame."""
        return camera_motion(replace(self.viewpoint, T_world_camera=T_world_camera))


class Sensor(Protocol):
    """A frozen dataclass with the settings of a sensor; its fields, or its ``from_plain``, are what a recipe may set.

    Two class attributes may say more of it. With ``reads_light = False`` its reading does not depend on lights,
    exposure and emission: paired variants in another light or with other noise share it. With ``is_camera = True`` its
    frame is that of a camera, x right, y down, z forward; that of any other sensor is x forward, y left, z up.
    """

    def read(self, view: SensorView, rng: np.random.Generator) -> Reading:
        """Return what the sensor reads.

        Args:
            view: The moment, as this sensor sees it.
            rng: Source of all its errors; nothing else is random.
        """


def reads_light(sensor: Sensor) -> bool:
    """Return whether what a sensor reads may depend on light, exposure and noise of cameras; yes if silent."""
    return bool(getattr(sensor, "reads_light", True))


def is_camera(sensor: Sensor) -> bool:
    """Return whether a sensor's frame is that of a camera; no if silent."""
    return bool(getattr(sensor, "is_camera", False))
