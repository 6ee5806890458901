"""Synthetic warehouse dataset generator and 6D-pose benchmark.

The names below are imported on first use, so that ``import warehouse_sim`` loads no torch, MuJoCo or OpenGL.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from warehouse_sim.optional import require_extra
from warehouse_sim.version import __version__

if TYPE_CHECKING:
    from warehouse_sim.dataset.convert import convert
    from warehouse_sim.dataset.validate import validate
    from warehouse_sim.errors import WarehouseSimError
    from warehouse_sim.estimators.load import load_estimator
    from warehouse_sim.estimators.predict import predict
    from warehouse_sim.estimators.rgbd_image import Detection, RgbdImage
    from warehouse_sim.estimators.train import train
    from warehouse_sim.evaluation import evaluate
    from warehouse_sim.generation.generate import generate
    from warehouse_sim.schema import PoseEstimate

__all__ = [
    "Detection",
    "PoseEstimate",
    "RgbdImage",
    "WarehouseSimError",
    "__version__",
    "convert",
    "evaluate",
    "generate",
    "load_estimator",
    "predict",
    "train",
    "validate",
]

_PUBLIC = {
    "Detection": "warehouse_sim.estimators.rgbd_image",
    "PoseEstimate": "warehouse_sim.schema",
    "RgbdImage": "warehouse_sim.estimators.rgbd_image",
    "WarehouseSimError": "warehouse_sim.errors",
    "convert": "warehouse_sim.dataset.convert",
    "evaluate": "warehouse_sim.evaluation",
    "generate": "warehouse_sim.generation.generate",
    "load_estimator": "warehouse_sim.estimators.load",
    "predict": "warehouse_sim.estimators.predict",
    "train": "warehouse_sim.estimators.train",
    "validate": "warehouse_sim.dataset.validate",
}
"""Where each public name is imported from when it is first used."""
_EXTRA = {
    "generate": "generate",
    **dict.fromkeys(("train", "load_estimator", "predict"), "learn"),
}
"""Names whose module cannot be imported without an extra of this package."""


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used (PEP 562)."""
    if name not in _PUBLIC:
        raise AttributeError(f"module 'warehouse_sim' has no attribute {name!r}")
    if name in _EXTRA:
        require_extra(_EXTRA[name], f"for warehouse_sim.{name}")
    return getattr(import_module(_PUBLIC[name]), name)


def __dir__() -> list[str]:
    return sorted(__all__)
