"""How tables use an estimator: ``NAME+WORD+...``, such as ``densefusion-depth+verify``.

Words are selections (argmax, weighted, weighted-50, consensus), refinements (icp, verification), ``flight`` for a
camera that measures time of flight, ``lidar`` and ``lidar-sparse`` for the depth of a LiDAR, ``boxes`` for ground-truth
boxes in place of ground-truth masks, and ``nominal`` for the calibration that the rig states. A trained estimator that
names neither selection nor refinement goes by consensus and ICP; one that names a selection alone is not refined.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import get_args

from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.errors import InputError, UnknownNameError
from warehouse_sim.estimators.api import Composition, Configurable, PoseEstimator
from warehouse_sim.estimators.load import load_estimator
from warehouse_sim.estimators.pose.choose import Selection
from warehouse_sim.estimators.registries import ESTIMATORS
from warehouse_sim.estimators.settings import PredictConfig
from warehouse_sim.resources import data_folder, model_names

_VERIFICATION = "verify"
_WORDS: dict[str, dict[str, object]] = {
    **{name: {"selection": name} for name in get_args(Selection)},
    "icp": {"refine": "icp"},
    _VERIFICATION: {"refine": "verify"},
    "flight": {"time_of_flight": True},
    "lidar": {"depth": "lidar"},
    "lidar-sparse": {"depth": "lidar-sparse"},
    "boxes": {"detections": "gt-boxes"},
    "nominal": {"calibration": "nominal"},
}
_OF_TRAINED = ("selection", "refine", "time_of_flight")


@dataclass(frozen=True)
class Way:
    """An estimator and how it predicts."""

    model: str
    """Bundled model, run folder, or registered estimator that needs no training."""
    config: PredictConfig
    """Settings of prediction."""

    @property
    def folder(self) -> Path:
        """Where its weights, if any, and its uncertainty lie."""
        return Path(self.model) if Path(self.model).is_dir() else data_folder("models") / self.model

    @property
    def is_trained(self) -> bool:
        """Whether it has weights, or those behind it have."""
        return _has_stages(self.model)

    @property
    def parts(self) -> tuple[str, ...]:
        """Names of all bundled models that it may be made of."""
        registered = ESTIMATORS.get(self.model) if self.model in ESTIMATORS.names() else None
        inner = f"{registered.front_end}+{registered.estimator}" if isinstance(registered, Composition) else ""
        return (self.model, *filter(None, inner.split("+")))

    def open(self, objects: Mapping[int, ObjectInfo], uncertainty: bool = True) -> PoseEstimator:
        """Return the estimator, shown the objects of a dataset where it learns them that way."""
        estimator = load_estimator(self.model, replace(self.config, uncertainty=uncertainty))
        estimator.onboard(objects)
        return estimator


def is_trained(model: str) -> bool:
    """Return whether a name is that of bundled weights, or a run folder."""
    return model in model_names() or Path(model).is_dir()


def way_of(method: str) -> Way:
    """Return what a method of a command line stands for.

    Raises:
        UnknownNameError: There is no such word.
        InputError: Verification or ICP is requested beside an estimator that goes by nothing else.
    """
    if Path(method).is_dir():
        return Way(method, PredictConfig(selection="consensus", refine="icp"))
    model, *words = method.split("+")
    options: dict[str, object] = {}
    for word in words:
        if word not in _WORDS:
            raise UnknownNameError(f"word of {method!r}", word, list(_WORDS))
        options |= _WORDS[word]
    if not _has_stages(model):
        if beside := [word for word in words if set(_WORDS[word]) & set(_OF_TRAINED)]:
            raise InputError(f"{model} needs no training and decides by verification itself: leave +{beside[0]} out")
        return Way(model, replace(PredictConfig().without_stages(), **options))  # type: ignore[arg-type]
    default = PredictConfig(selection="consensus", refine="none" if "selection" in options else "icp")
    return Way(model, replace(default, **options))  # type: ignore[arg-type]


def _has_stages(model: str) -> bool:
    """Return whether selection and refinement are to be chosen: of networks, alone or behind a front end."""
    if is_trained(model) or model not in ESTIMATORS.names():
        return is_trained(model)
    registered = ESTIMATORS.get(model)
    behind = registered.estimator if isinstance(registered, Composition) else ""
    return isinstance(registered, Configurable) and (not behind or is_trained(behind))
