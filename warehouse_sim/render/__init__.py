"""Scene and camera -> clean pixels of every kind, and exact rays. Only this room knows OpenGL."""

from typing import Any

from warehouse_sim.registry import Registry
from warehouse_sim.render.renderer import Capabilities, Renderer, Silhouette

BACKENDS = Registry("render backend")
BACKENDS.add("raster", "warehouse_sim.render.raster.backend:RasterRenderer")
BACKENDS.add("mujoco", "warehouse_sim.render.mujoco.backend:MujocoRenderer")
BACKENDS.add("pyrender", "warehouse_sim.render.pyrender.backend:PyrenderRenderer")
BACKENDS.add("pathtrace", "warehouse_sim.render.pathtrace.backend:PathtraceRenderer")


def open_renderer(name: str = "raster", **options: Any) -> Renderer:
    """Open the render backend ``name``; use it as a context manager or call ``close``.

    Args:
        name: A name of ``BACKENDS``.
        options: Keyword arguments of the backend, such as ``device`` of ``raster``.

    Raises:
        UnknownNameError: No such backend.
        RenderError: The backend cannot run on this machine; the message says what is missing.
    """
    renderer: Renderer = BACKENDS.get(name)(**options)
    return renderer


__all__ = ["BACKENDS", "Capabilities", "Renderer", "Silhouette", "open_renderer"]
