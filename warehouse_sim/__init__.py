"""Synthetic warehouse dataset generator and 6D-pose benchmark.

The names below are imported on first use, so that ``import warehouse_sim`` loads no torch, MuJoCo or OpenGL.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from warehouse_sim.optional import require_extra
from warehouse_sim.version import __version__

if TYPE_CHECKING:
    from warehouse_sim.api.camera import Camera, Rig
    from warehouse_sim.api.dataset import Dataset
    from warehouse_sim.api.folders import convert, validate
    from warehouse_sim.api.generate import Writer, generate
    from warehouse_sim.api.observation import Observation
    from warehouse_sim.api.recipe import Recipe, recipe
    from warehouse_sim.api.scene import Scene
    from warehouse_sim.api.scoring import evaluate, predict, report
    from warehouse_sim.api.stream import stream
    from warehouse_sim.api.training import load_estimator, train
    from warehouse_sim.errors import WarehouseSimError
    from warehouse_sim.estimators.image import Detection, RgbdImage
    from warehouse_sim.schema import PoseEstimate

__all__ = [
    "Camera",
    "Dataset",
    "Detection",
    "Observation",
    "PoseEstimate",
    "Recipe",
    "RgbdImage",
    "Rig",
    "Scene",
    "WarehouseSimError",
    "Writer",
    "__version__",
    "convert",
    "evaluate",
    "generate",
    "load_estimator",
    "predict",
    "recipe",
    "report",
    "stream",
    "train",
    "validate",
]

_PUBLIC = {
    "Camera": "warehouse_sim.api.camera",
    "Dataset": "warehouse_sim.api.dataset",
    "Detection": "warehouse_sim.estimators.image",
    "Observation": "warehouse_sim.api.observation",
    "PoseEstimate": "warehouse_sim.schema",
    "Recipe": "warehouse_sim.api.recipe",
    "RgbdImage": "warehouse_sim.estimators.image",
    "Rig": "warehouse_sim.api.camera",
    "Scene": "warehouse_sim.api.scene",
    "WarehouseSimError": "warehouse_sim.errors",
    "Writer": "warehouse_sim.api.generate",
    "convert": "warehouse_sim.api.folders",
    "evaluate": "warehouse_sim.api.scoring",
    "generate": "warehouse_sim.api.generate",
    "load_estimator": "warehouse_sim.api.training",
    "predict": "warehouse_sim.api.scoring",
    "recipe": "warehouse_sim.api.recipe",
    "report": "warehouse_sim.api.scoring",
    "stream": "warehouse_sim.api.stream",
    "train": "warehouse_sim.api.training",
    "validate": "warehouse_sim.api.folders",
}
"""Where each public name is imported from when it is first used."""
_EXTRA = dict.fromkeys(("Camera", "Recipe", "Rig", "Scene", "Writer", "generate", "recipe", "stream"), "generate")
"""Names whose module cannot be imported without an extra of this package."""
_GUESSES = dict.fromkeys(("load", "load_dataset", "open", "read"), "Dataset") | {"load_recipe": "recipe"}
"""What people write who do not know the names."""


if not TYPE_CHECKING:  # to whom every other name is an error

    def __getattr__(name: str) -> Any:
        """Import a public name when it is first used (PEP 562)."""
        if name not in _PUBLIC:
            meant = f"; use warehouse_sim.{_GUESSES[name]}" if name in _GUESSES else ""
            raise AttributeError(f"module 'warehouse_sim' has no attribute {name!r}{meant}", name=name)
        if name in _EXTRA:
            require_extra(_EXTRA[name], f"for warehouse_sim.{name}")
        globals()[name] = found = getattr(import_module(_PUBLIC[name]), name)
        return found


def __dir__() -> list[str]:
    return sorted(__all__)
