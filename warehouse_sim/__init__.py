"""Synthetic warehouse dataset generator and 6D-pose benchmark.

The names below are imported on first use, so that ``import warehouse_sim`` loads no torch, MuJoCo or OpenGL.
"""

from importlib import import_module
from typing import Any

from warehouse_sim.optional import require_extra

__version__ = "0.1.0"

_PUBLIC = {
    "load_recipe": "warehouse_sim.generation.recipe",
    "generate": "warehouse_sim.generation.generate",
    "prepare_scene": "warehouse_sim.generation.scene",
    "observe_scene": "warehouse_sim.generation.observe",
    "sample_scene": "warehouse_sim.scene",
    "settle_scene": "warehouse_sim.physics",
    "open_renderer": "warehouse_sim.render",
    "DatasetReader": "warehouse_sim.dataset.reader",
    "validate": "warehouse_sim.dataset.validate",
    "train": "warehouse_sim.estimators.train",
    "load_estimator": "warehouse_sim.estimators.load",
    "RgbdImage": "warehouse_sim.estimators.rgbd_image",
    "Detection": "warehouse_sim.estimators.rgbd_image",
    "predict": "warehouse_sim.estimators.predict",
    "evaluate": "warehouse_sim.evaluation",
    "write_report": "warehouse_sim.evaluation.report",
}
_EXTRA = {
    **dict.fromkeys(("load_recipe", "generate", "prepare_scene", "settle_scene"), "generate"),
    **dict.fromkeys(("train", "load_estimator", "predict"), "learn"),
}
"""Names whose home cannot be imported without an extra of this package."""

__all__ = [*_PUBLIC, "__version__"]  # pyright: ignore[reportUnsupportedDunderAll]


def __getattr__(name: str) -> Any:
    """Import a public name when it is first asked for (PEP 562)."""
    if name not in _PUBLIC:
        raise AttributeError(f"module 'warehouse_sim' has no attribute {name!r}")
    if name in _EXTRA:
        require_extra(_EXTRA[name], f"for warehouse_sim.{name}")
    return getattr(import_module(_PUBLIC[name]), name)


def __dir__() -> list[str]:
    return sorted(__all__)
