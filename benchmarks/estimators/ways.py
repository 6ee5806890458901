"""How tables use an estimator: a trained one with ICP, ``NAME+evidence`` with evidence in its place.

``NAME+evidence+flight`` is told besides that the camera measures time of flight.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from warehouse_sim import load_estimator
from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.estimators import Onboarding, PoseEstimator
from warehouse_sim.estimators.settings import PredictConfig
from warehouse_sim.resources import data_folder, model_names

_TRAINED = PredictConfig(selection="consensus", refine="icp")
_EVIDENCE, _FLIGHT = "+evidence", "+flight"


@dataclass(frozen=True)
class Way:
    """An estimator and how it predicts."""

    model: str
    """Bundled model, run folder, or registered estimator that needs no training."""
    config: PredictConfig
    """Settings of prediction."""

    @property
    def folder(self) -> Path:
        """Where its weights, if any, and its doubt lie."""
        return Path(self.model) if Path(self.model).is_dir() else data_folder("models") / self.model


def way_of(method: str) -> Way:
    """Return what a method of a command line stands for.

    Raises:
        SystemExit: Evidence is asked for beside an estimator that goes by nothing else.
    """
    told = method.removesuffix(_FLIGHT)
    model = told.removesuffix(_EVIDENCE)
    if not (model in model_names() or Path(model).is_dir()):
        if model != method:
            raise SystemExit(f"{model} needs no training and decides by evidence itself: leave {_EVIDENCE} out")
        return Way(model, PredictConfig())
    config = replace(_TRAINED, time_of_flight=told != method)
    return Way(model, replace(config, refine="evidence") if model != told else config)


def open_way(method: str, objects: Mapping[int, ObjectInfo], doubt: bool = True) -> PoseEstimator:
    """Return the estimator, shown the objects of a dataset where it learns them that way."""
    way = way_of(method)
    estimator = load_estimator(way.model, replace(way.config, doubt=doubt))
    if isinstance(estimator, Onboarding):
        estimator.onboard(objects)
    return estimator
