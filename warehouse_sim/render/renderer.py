"""What every render backend offers."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from types import TracebackType
from typing import Protocol, Self, TypeVar

import numpy as np
from jaxtyping import Bool

from warehouse_sim.errors import RenderError
from warehouse_sim.geometry.boxes import mask_box_xyxy
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.schema import ObjectInstance, RenderBuffers, SceneSpec


@dataclass(frozen=True, eq=False)
class AmodalMask:
    """The pixels that one object would cover if it stood alone, on the pixel grid of the image."""

    offset: tuple[int, int]
    """Column and row in the image of the mask's first pixel; may be negative."""
    mask: Bool[np.ndarray, "sh sw"]
    """Tight around the covered pixels; 0 x 0 when nothing is covered."""

    @classmethod
    def of(cls, covered: Bool[np.ndarray, "h w"], left: int = 0, top: int = 0) -> "AmodalMask":
        """Cut ``covered``, whose first pixel is in column ``left`` and row ``top`` of the image, to what it covers."""
        box = mask_box_xyxy(covered)
        if box is None:
            return NOTHING_COVERED
        x, y, last_x, last_y = box
        return cls((left + x, top + y), covered[y : last_y + 1, x : last_x + 1].copy())


NOTHING_COVERED = AmodalMask((0, 0), np.zeros((0, 0), bool))


@dataclass(frozen=True)
class Capabilities:
    """What a backend can draw; what is False or missing is left out of its buffers, never faked."""

    normals: bool = True
    """Surface normals in ``RenderBuffers.normals``; ``render(normals=True)`` raises otherwise."""
    amodal_masks: bool = True
    """Unoccluded amodal masks; ``amodal_masks`` raises otherwise."""
    film: bool = True
    """Parts with an opacity below 1 in the colours; they are left out otherwise."""
    textures: bool = True
    """The materials' textures in the colours, by their albedo at least."""
    shadows: bool = True
    """Shadows of the lights."""
    global_illumination: bool = False
    """Light that surfaces send each other, followed and not approximated."""
    without_color: bool = False
    """``render(color=False)`` is there, and saves what colours alone need."""
    max_lights: int | None = None
    """Lights that are rendered, the most important ones; None = all."""


class Renderer(Protocol):
    """Draw loaded scenes; not to be shared between threads.

    Parts whose material has an opacity below 1 are film. Film tints the colour and shines, and is hidden by what stands
    before it; depth, instance ids, normals, amodal masks and shadows are those of the scene without it, so that labels
    speak of the goods that it is wrapped around.
    """

    @property
    def description(self) -> str:
        """Name and version of the renderer, for logs and manifests."""

    @property
    def capabilities(self) -> Capabilities:
        """What this backend can draw; requested more, it raises RenderError and names a backend that can."""

    def load(self, scene: SceneSpec) -> None:
        """Make ``scene`` the one that is rendered, replacing the one before.

        Raises:
            RenderError: The scene names a material, model or texture that does not exist.
        """

    def render(self, camera: PinholeCamera, T_world_camera: Transform, normals: bool = False) -> RenderBuffers:
        """Render the loaded scene; all channels are sampled at the same pixel centres.

        Backends draw pinholes; ``lens.LensRenderer`` around one draws cameras with a lens, too. Those that are capable
        of it take a further argument ``color``: with False the colours are left out (0 x 0), all else is the same.

        Args:
            camera: Intrinsics; the principal point may lie anywhere.
            T_world_camera: Pose of the OpenCV camera.
            normals: Whether to fill ``RenderBuffers.normals``.

        Raises:
            RenderError: See ``require_view``.
        """

    def amodal_masks(
        self, camera: PinholeCamera, T_world_camera: Transform, instances: Sequence[ObjectInstance]
    ) -> list[AmodalMask]:
        """Return the unoccluded amodal mask of each of ``instances``, which belong to the loaded scene.

        An amodal mask may leave the image: it lives on a canvas of three image widths by three image heights with
        the image in the middle, as BOP counts it, and is cut at the border of that canvas and at the near plane.
        """

    def close(self) -> None:
        """Give back the graphics context; the renderer cannot be used afterwards."""

    def __enter__(self) -> Self:
        """Return the renderer itself."""

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the renderer."""


def render_without_color(
    renderer: Renderer, camera: PinholeCamera, T_world_camera: Transform, normals: bool = False
) -> RenderBuffers:
    """Render the loaded scene without colours where the backend is capable of it, with them otherwise."""
    if not renderer.capabilities.without_color:
        return renderer.render(camera, T_world_camera, normals)
    render: Callable[..., RenderBuffers] = renderer.render
    return render(camera, T_world_camera, normals, color=False)


class ClosingRenderer(ABC):
    """A renderer that closes at the end of a ``with`` block."""

    @abstractmethod
    def close(self) -> None:
        """Give back the graphics context; the renderer cannot be used afterwards."""

    def __enter__(self) -> Self:
        """Return the renderer itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the renderer."""
        self.close()


_Held = TypeVar("_Held")


def still_open(held: _Held | None) -> _Held:
    """Return what an open renderer holds.

    Raises:
        RenderError: The renderer is closed: it holds None.
    """
    if held is None:
        raise RenderError("the renderer is closed; open a new one with open_renderer()")
    return held


def loaded(scene: _Held | None) -> _Held:
    """Return the loaded scene.

    Raises:
        RenderError: It is None, as nothing is loaded.
    """
    if scene is None:
        raise RenderError("no scene is loaded; call load(scene) before rendering")
    return scene


_WIDEST = 1e3
"""Tangent of the largest angle to the optical axis that is rendered; beyond it, single precision fails."""
_NARROWEST = 1e-6
"""Least extent of an image at a distance of 1 (m); below it, neighbouring pixels are one place."""


def require_view(camera: PinholeCamera, T_world_camera: Transform) -> None:
    """Reject what graphics libraries cannot draw: a lens that distorts, and a view that is no view.

    Raises:
        RenderError: The camera has a lens, its angles are far too small or large, or its pose is not finite.
    """
    if camera.distortion is not None:
        raise RenderError("backends render cameras without distortion only; render with LensRenderer(renderer)")
    left, right, top, bottom = camera.tangent_bounds()
    if max(map(abs, (left, right, top, bottom))) > _WIDEST or min(right - left, bottom - top) < _NARROWEST:
        raise RenderError(
            f"a camera of {camera.width} x {camera.height} px with fx={camera.fx:g}, fy={camera.fy:g}, "
            f"cx={camera.cx:g}, cy={camera.cy:g} cannot be rendered; check its focal lengths and principal point"
        )
    if not np.isfinite(T_world_camera).all():
        raise RenderError(f"the camera's pose is not finite: {T_world_camera[:3, 3]}")
