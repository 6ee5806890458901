"""Scene and camera -> clean pixels of every kind, and exact rays. Only this room knows OpenGL."""

from collections.abc import Sequence
from typing import Any

from warehouse_sim.config import from_mapping
from warehouse_sim.errors import ConfigError
from warehouse_sim.registry import Registry
from warehouse_sim.render.renderer import Capabilities, Renderer, Silhouette
from warehouse_sim.yaml_file import parse_yaml

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


def backend_options(name: str, pairs: Sequence[str]) -> dict[str, Any]:
    """Return the options of a backend that ``key=value`` texts give, as ``open_renderer`` takes them.

    A backend declares its options as a frozen dataclass ``Options`` of its class.

    Raises:
        UnknownNameError: No such backend.
        ConfigError: The backend has no such option, or not with this value.
    """
    declared, where = getattr(BACKENDS.get(name), "Options", None), f"--backend-options of {name}"
    given: dict[str, Any] = {}
    for pair in pairs:
        key, is_pair, value = pair.partition("=")
        if not is_pair or key in given:
            raise ConfigError(f"{where}: expected key=value, each key once; found {pair!r}")
        given[key] = parse_yaml(value, f"{where}: {key}")
    if not given:
        return {}
    if declared is None:
        raise ConfigError(f"{where}: this backend has none; leave them out")
    checked = from_mapping(declared, given, where)
    return {key: getattr(checked, key) for key in given}


__all__ = ["BACKENDS", "Capabilities", "Renderer", "Silhouette", "backend_options", "open_renderer"]
