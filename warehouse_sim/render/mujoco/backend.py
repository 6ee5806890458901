"""The mujoco backend: one context, one loaded scene in the three forms in which it is rendered, any number of views."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Literal

import mujoco
import numpy as np
from jaxtyping import Bool, Float32, Int32, Int64, UInt8

from warehouse_sim.errors import RenderError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.ranges import Range, ranged
from warehouse_sim.render.canvas_tiles import amodal_mask_by_tiles
from warehouse_sim.render.mujoco.device import choose_platform, open_device
from warehouse_sim.render.mujoco.model import ALONE, FILM, MAX_LIGHTS, SOLID, VisualModel, build_visual_model
from warehouse_sim.render.painted_mesh import require_renderable
from warehouse_sim.render.renderer import AmodalMask, Capabilities, ClosingRenderer, loaded, require_view, still_open
from warehouse_sim.schema import ObjectInstance, RenderBuffers, SceneSpec

NEAR, FAR = 0.05, 1000.0
"""Distances of the clipping planes (m); with reversed depth in floats the far one costs no precision."""


def aim(scene: mujoco.MjvScene, camera: PinholeCamera, T_world_camera: Transform) -> None:
    """Look through ``camera``: its frustum is set edge by edge, so that the principal point may lie anywhere.

    OpenGL samples a pixel at its middle, half a pixel right of and below its first edge: the edges of the image are at
    u = -0.5 and u = width - 0.5.
    """
    left, right = (np.array([-0.5, camera.width - 0.5]) - camera.cx) * NEAR / camera.fx
    top, bottom = (camera.cy - np.array([-0.5, camera.height - 0.5])) * NEAR / camera.fy
    for eye in scene.camera:  # two for stereo; a single image is taken between them
        eye.pos, eye.forward, eye.up = T_world_camera[:3, 3], T_world_camera[:3, 2], -T_world_camera[:3, 1]
        eye.frustum_center, eye.frustum_width = (left + right) / 2, (right - left) / 2
        eye.frustum_bottom, eye.frustum_top = bottom, top
        eye.frustum_near, eye.frustum_far = NEAR, FAR


def render_color(
    scene: mujoco.MjvScene, context: mujoco.MjrContext, size: tuple[int, int]
) -> UInt8[np.ndarray, "h w 3"]:
    """Render the lit image of ``size`` (width, height), antialiased."""
    rect = mujoco.MjrRect(0, 0, *size)
    pixels = np.empty((size[1], size[0], 3), np.uint8)
    mujoco.mjr_render(rect, scene, context)
    mujoco.mjr_readPixels(pixels, None, rect, context)
    return np.ascontiguousarray(pixels[::-1])


def render_ids(
    scene: mujoco.MjvScene, context: mujoco.MjrContext, size: tuple[int, int]
) -> tuple[Int64[np.ndarray, "h w"], Float32[np.ndarray, "h w"]]:
    """Render the number of the geom that each pixel shows, -1 for none, and its depth (m), 0 for none.

    Both come from one pass in MuJoCo's segmentation mode, which has no antialiasing. In it the geom's number plus one
    is its colour, and depth runs from 1 at the near to 0 at the far plane:
    d = near (far - z) / (z (far - near)), as glFrustum after ``mjDEPTH_ZEROFAR`` gives it.
    """
    rect = mujoco.MjrRect(0, 0, *size)
    pixels, depth = np.empty((size[1], size[0], 3), np.uint8), np.empty((size[1], size[0]), np.float32)
    mujoco.mjr_render(rect, scene, context)
    mujoco.mjr_readPixels(pixels, depth, rect, context)
    code = pixels[::-1] @ np.array([1, 1 << 8, 1 << 16])
    metres = NEAR * FAR / (depth[::-1].astype(np.float64) * (FAR - NEAR) + NEAR)
    return code - 1, np.where(code > 0, metres, 0.0).astype(np.float32)


def set_numbering(scene: mujoco.MjvScene) -> None:
    """Make ``render_ids`` possible: geoms are rendered flat in the colour of their number."""
    scene.flags[mujoco.mjtRndFlag.mjRND_SEGMENT] = 1
    scene.flags[mujoco.mjtRndFlag.mjRND_IDCOLOR] = 1


_START_PX = (64, 64)


class LoadedScene:
    """Geometry, textures and framebuffers of one scene; nothing moves, so that a view only moves the camera.

    Args:
        scene: The scene.
        visual: The same as a MuJoCo model.
        samples: Samples a pixel of the image.
    """

    def __init__(self, scene: SceneSpec, visual: VisualModel, samples: int) -> None:
        self._scene, self._visual = scene, visual
        model = visual.model
        model.vis.global_.offwidth, model.vis.global_.offheight = _START_PX
        model.vis.quality.offsamples = samples
        self._data = mujoco.MjData(model)
        mujoco.mj_kinematics(model, self._data)
        mujoco.mj_camlight(model, self._data)
        self._context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_50)
        self._context.readDepthMap = mujoco.mjtDepthMap.mjDEPTH_ZEROFAR
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)
        self._size = _START_PX
        model.geom_group[:] = visual.group
        self._colors = self._collect((SOLID, FILM))
        self._numbers = self._collect((SOLID,))
        set_numbering(self._numbers)
        self._alone: mujoco.MjvScene | None = None
        # One more row answers for pixels that show nothing, whose number is -1.
        shown = [geom.objid for geom in self._numbers.geoms[: self._numbers.ngeom]]
        self._owner: Int32[np.ndarray, " n"] = np.append(visual.owner[shown], 0).astype(np.int32)

    def render(self, camera: PinholeCamera, T_world_camera: Transform) -> RenderBuffers:
        """Draw colours, depth and instance masks."""
        size = self._fit(camera)
        aim(self._colors, camera, T_world_camera)
        rgb = render_color(self._colors, self._context, size)
        aim(self._numbers, camera, T_world_camera)
        numbers, depth = render_ids(self._numbers, self._context, size)
        return RenderBuffers(rgb=rgb, depth=depth, instance_mask=self._owner[numbers])

    def amodal_mask(self, camera: PinholeCamera, T_world_camera: Transform, instance: ObjectInstance) -> AmodalMask:
        """Draw ``instance`` alone, tile by tile of the canvas around the image."""
        model, mine = self._visual.model, self._visual.owner == instance.instance_id
        model.geom_group[:] = np.where(mine & (self._visual.group == SOLID), ALONE, SOLID)
        alone = self._alone = self._collect((ALONE,), self._alone)
        set_numbering(alone)
        size = self._fit(camera)

        def draw(tile: PinholeCamera) -> Bool[np.ndarray, "h w"]:
            aim(alone, tile, T_world_camera)
            return render_ids(alone, self._context, size)[0] >= 0

        return amodal_mask_by_tiles(camera, T_world_camera, self._scene, instance, NEAR, draw)

    def release(self) -> None:
        """Free the device memory."""
        self._context.free()

    def _collect(self, groups: tuple[int, ...], into: mujoco.MjvScene | None = None) -> mujoco.MjvScene:
        """Return the geoms of ``groups`` as what MuJoCo draws."""
        model = self._visual.model
        scene = into or mujoco.MjvScene(model, maxgeom=model.ngeom + 16)
        option = mujoco.MjvOption()
        option.geomgroup[:] = [int(number in groups) for number in range(len(option.geomgroup))]
        everything = mujoco.mjtCatBit.mjCAT_ALL
        mujoco.mjv_updateScene(model, self._data, option, None, mujoco.MjvCamera(), everything, scene)
        return scene

    def _fit(self, camera: PinholeCamera) -> tuple[int, int]:
        """Make the framebuffer as large as the image; return its width and height."""
        size = camera.width, camera.height
        if size != self._size:
            mujoco.mjr_resizeOffscreen(*size, self._context)
            self._size = size
        return size


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
