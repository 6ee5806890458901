"""Scene and camera -> clean pixels: colour, depth, ids, normals, silhouettes; and exact rays. Only this room knows OpenGL."""

from typing import Any

from warehouse_sim.registry import Registry
from warehouse_sim.render.renderer import Renderer, Silhouette

BACKENDS = Registry("render backend")
BACKENDS.add("raster", "warehouse_sim.render.raster.backend:RasterRenderer")


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


__all__ = ["BACKENDS", "Renderer", "Silhouette", "open_renderer"]
