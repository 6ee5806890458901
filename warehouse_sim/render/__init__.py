"""Scene and camera -> clean pixels of every kind, and exact rays. Only this room knows OpenGL."""

from typing import Any

from warehouse_sim.errors import ConfigError
from warehouse_sim.render.options import BACKENDS, backend_options, option_settings, with_shortcuts
from warehouse_sim.render.renderer import AmodalMask, Capabilities, Renderer


def open_renderer(name: str = "raster", options: Any = None, **settings: Any) -> Renderer:
    """Open the render backend ``name``; use it as a context manager or call ``close``.

    Args:
        name: A name of ``BACKENDS``.
        options: The backend's own, as ``backend_options`` returns them; by default those that ``settings`` say.
        settings: Options by their names, such as ``device`` of ``raster``.

    Raises:
        UnknownNameError: No such backend.
        ConfigError: The backend has no such option, or the value is none that it takes.
        RenderError: The backend cannot run on this machine; the message says what is missing.
    """
    backend = BACKENDS.get(name)
    if options is None:
        options = backend_options(name, settings)
    elif settings or not isinstance(options, getattr(backend, "Options", ())):
        raise ConfigError(f"the render backend {name} takes its own options alone; make them with backend_options()")
    renderer: Renderer = backend() if options is None else backend(options)
    return renderer


__all__ = [
    "BACKENDS",
    "AmodalMask",
    "Capabilities",
    "Renderer",
    "backend_options",
    "open_renderer",
    "option_settings",
    "with_shortcuts",
]
