"""The mujoco backend: one context, one loaded scene, any number of views."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Literal

from warehouse_sim.errors import RenderError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.ranges import Range, ranged
from warehouse_sim.render.mujoco.device import choose_platform, open_device
from warehouse_sim.render.mujoco.loaded_scene import LoadedScene
from warehouse_sim.render.mujoco.model import MAX_LIGHTS, build_visual_model
from warehouse_sim.render.painted_mesh import require_renderable
from warehouse_sim.render.renderer import AmodalMask, Capabilities, ClosingRenderer, loaded, require_view, still_open
from warehouse_sim.schema import ObjectInstance, RenderBuffers, SceneSpec


@dataclass(frozen=True)
@ranged
class MujocoOptions:
    """Options of the mujoco backend."""

    platform: Literal["egl", "osmesa"] | None = None
    """What to draw through; null asks the environment variable MUJOCO_GL, then EGL. A process cannot use both."""
    device: Annotated[int, Range(0, 1023)] | None = None
    """Number of the EGL device, 0-1,023; null = the first that works."""
    samples: Annotated[int, Range(0, 64)] = 4
    """Samples a pixel of the image, 0-64, 0 for no antialiasing; depth and instance masks always have one."""
    shadow_px: Annotated[int, Range(0, 16_384, "px")] = 2048
    """Edge of each light's shadow map, 0-16,384, all drawn again for each image; 0 = no shadows."""


class MujocoRenderer(ClosingRenderer):
    """MuJoCo's classic renderer; see ``render.renderer.Renderer`` for the methods.

    Args:
        options: What draws, and how finely.

    Raises:
        RenderError: No context can be opened.
    """

    Options = MujocoOptions

    def __init__(self, options: MujocoOptions | None = None) -> None:
        self._options = options or MujocoOptions()
        chosen = choose_platform(self._options.platform)
        self._context, driver = open_device(chosen, self._options.device)
        self.description = f"mujoco on {driver} through {chosen}"
        self._scene: LoadedScene | None = None

    @property
    def capabilities(self) -> Capabilities:
        """No normals: nothing in fixed-function OpenGL draws them exactly."""
        return Capabilities(normals=False, shadows=self._options.shadow_px > 0, max_lights=MAX_LIGHTS)

    def load(self, scene: SceneSpec) -> None:
        """Compile ``scene`` and upload it."""
        still_open(self._context).make_current()
        require_renderable(scene)
        visual = build_visual_model(scene, self._options.shadow_px)
        if self._scene is not None:
            self._scene.release()
        self._scene = LoadedScene(scene, visual, self._options.samples)

    def render(self, camera: PinholeCamera, T_world_camera: Transform, normals: bool = False) -> RenderBuffers:
        """Render the loaded scene."""
        require_view(camera, T_world_camera)
        still_open(self._context).make_current()
        if normals:
            raise RenderError("the mujoco backend renders no normals; use raster or pathtrace")
        return loaded(self._scene).render(camera, T_world_camera)

    def amodal_masks(
        self, camera: PinholeCamera, T_world_camera: Transform, instances: Sequence[ObjectInstance]
    ) -> list[AmodalMask]:
        """Draw each of ``instances`` of the loaded scene alone, which takes a pass for each."""
        require_view(camera, T_world_camera)
        still_open(self._context).make_current()
        scene = loaded(self._scene)
        return [scene.amodal_mask(camera, T_world_camera, instance) for instance in instances]

    def close(self) -> None:
        """Give back the context and all device memory."""
        if self._context is None:
            return
        self._context.make_current()
        if self._scene is not None:
            self._scene.release()
        self._context.free()
        self._context = self._scene = None
