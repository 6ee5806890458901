"""Packages that an installation may lack, with one clear line when it does."""

from collections.abc import Mapping
from importlib import import_module
from importlib.util import find_spec
from types import ModuleType
from typing import Any

from warehouse_sim.errors import MissingPackageError

EXTRAS = {
    "generate": ("mujoco", "moderngl", "glcontext", "embreex", "segno"),
    "learn": ("torch", "safetensors", "tensorboardX"),
    "open3d": ("open3d",),
    "export": ("onnx", "onnxruntime", "onnxscript"),
    "report": ("plotly", "jinja2"),
    "mcap": ("mcap", "mcap_protobuf", "foxglove_schemas_protobuf"),
    "view": ("rerun",),
    "cluster": ("ray", "grpc", "fsspec"),
    "gym": ("gymnasium",),
    "peers": ("pyrender", "trimesh"),
}
"""Modules by the extra that brings them, where all of them are needed together."""


def imported_when_used(package: str, homes: Mapping[str, str], name: str) -> Any:
    """Return a name of a package from its module, imported only now (PEP 562).

    Args:
        package: The package's own name.
        homes: Module of each of its names, without the package's.
        name: The name.

    Raises:
        AttributeError: It has none of that name.
    """
    if name not in homes:
        raise AttributeError(f"module {package!r} has no attribute {name!r}")
    return getattr(import_module(f"{package}.{homes[name]}"), name)


def missing(extra: str) -> list[str]:
    """Return the modules of an extra that are not installed."""
    return [module for module in EXTRAS[extra] if not _is_installed(module)]


def require_extra(extra: str, purpose: str) -> None:
    """Make sure that an extra of warehouse-sim is installed, before anything is begun that needs it.

    Args:
        extra: Key of ``EXTRAS``.
        purpose: What needs it, as it reads after "is needed".

    Raises:
        MissingPackageError: A module of it is not installed.
    """
    if modules := missing(extra):
        raise MissingPackageError(f"{', '.join(modules)}: needed {purpose} but not installed; {_remedy(extra)}")


def require(module: str, extra: str, purpose: str) -> ModuleType:
    """Import ``module`` or say which extra of warehouse-sim brings it.

    Args:
        module: Dotted name to import.
        extra: Extra of this package that installs it.
        purpose: What needs it, as it reads after "is needed".

    Raises:
        MissingPackageError: The module cannot be imported.
    """
    try:
        return import_module(module)
    except ImportError as error:
        raise MissingPackageError(
            f"{module} is needed {purpose} but cannot be imported ({error}); {_remedy(extra)}"
        ) from error


def _is_installed(module: str) -> bool:
    try:
        return find_spec(module) is not None
    except ImportError:
        return False


def _remedy(extra: str) -> str:
    return f"install it with: pip install 'warehouse-sim[{extra}]'"
