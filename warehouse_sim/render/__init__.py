"""Scene and camera -> clean pixels of every kind, and exact rays. Only this room knows OpenGL."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import fields
from typing import Any

from warehouse_sim.config import from_mapping
from warehouse_sim.errors import ConfigError, RenderError
from warehouse_sim.registry import Registry
from warehouse_sim.render.renderer import AmodalMask, Capabilities, Renderer
from warehouse_sim.yaml_file import parse_yaml

BACKENDS = Registry("render backend")
"""Each name stands for a class; it may have ``Options``, a frozen dataclass of defaults that its constructor takes."""
BACKENDS.add("raster", "warehouse_sim.render.raster.backend:RasterRenderer")
BACKENDS.add("mujoco", "warehouse_sim.render.mujoco.backend:MujocoRenderer")
BACKENDS.add("pyrender", "warehouse_sim.render.pyrender.backend:PyrenderRenderer")
BACKENDS.add("pathtrace", "warehouse_sim.render.pathtrace.backend:PathtraceRenderer")


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


def require_drawn(outputs: Collection[str], name: str, settings: Mapping[str, Any]) -> None:
    """Reject outputs that a backend does not draw, before any scene is made.

    Args:
        outputs: Names of what is wanted.
        name: A name of ``BACKENDS``.
        settings: Options by their names.

    Raises:
        RenderError: Normals are wanted, which it does not draw.
    """
    if "normals" not in outputs:
        return
    with open_renderer(name, **settings) as renderer:
        if not renderer.capabilities.normals:
            raise RenderError(
                f"outputs: normals is wanted, which the {name} backend does not draw; "
                "use raster or pathtrace, or leave normals out"
            )


def backend_options(name: str, pairs: Mapping[str, Any]) -> Any:
    """Return the options of a backend as the dataclass that it declares; None for a backend that declares none.

    Args:
        name: A name of ``BACKENDS``.
        pairs: Values by the name of the option; text is read as in a recipe ("0.5" is a number).

    Raises:
        UnknownNameError: No such backend.
        ConfigError: The backend has no such option, or the value is none that it takes.
    """
    where = f"options of the render backend {name}"
    kind = getattr(BACKENDS.get(name), "Options", None)
    if kind is not None:
        return from_mapping(kind, {key: _plain(value, f"{where}: {key}") for key, value in pairs.items()}, where)
    if pairs:
        raise ConfigError(f"{where}: {', '.join(pairs)} given, but it takes none; leave them out")
    return None


def option_settings(name: str, pairs: Sequence[str]) -> dict[str, Any]:
    """Return the checked settings that ``key=value`` texts give, as ``open_renderer`` takes them.

    Raises:
        UnknownNameError: No such backend.
        ConfigError: A text is no pair, a key comes twice, or the backend has no such option or not with this value.
    """
    given: dict[str, str] = {}
    for pair in pairs:
        key, is_pair, value = pair.partition("=")
        if not is_pair or key in given:
            raise ConfigError(
                f"options of the render backend {name}: expected key=value, each key once; found {pair!r}"
            )
        given[key] = value
    checked = backend_options(name, given)
    return {key: getattr(checked, key) for key in given}


def with_shortcuts(name: str, pairs: Sequence[str], flags: Mapping[str, Any]) -> tuple[str, ...]:
    """Return ``key=value`` texts with those of a command line's flags, such as ``--samples 16``.

    Args:
        name: A name of ``BACKENDS``.
        pairs: What ``--backend-options`` gives.
        flags: Values by the name of the option; None and False where the flag is not given.

    Raises:
        UnknownNameError: No such backend.
        ConfigError: The backend has no option of this name.
    """
    given = {key: value for key, value in flags.items() if value is not None and value is not False}
    kind = getattr(BACKENDS.get(name), "Options", None)
    known = {item.name for item in fields(kind)} if kind is not None else set()
    if missing := [f"--{key}" for key in given if key not in known]:
        raise ConfigError(
            f"{', '.join(missing)}: the render backend {name} has no such option; leave out or add --backend pathtrace"
        )
    return (*pairs, *(f"{key}={str(value).lower()}" for key, value in given.items()))


def _plain(value: Any, where: str) -> Any:
    return parse_yaml(value, where) if isinstance(value, str) else value


__all__ = [
    "BACKENDS",
    "AmodalMask",
    "Capabilities",
    "Renderer",
    "backend_options",
    "open_renderer",
    "option_settings",
    "require_drawn",
    "with_shortcuts",
]
