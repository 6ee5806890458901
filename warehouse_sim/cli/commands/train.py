"""``warehouse-sim train``: a dataset folder becomes a run folder."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated, Any

import tyro

from warehouse_sim.cli.console import finish, fraction_progress, say
from warehouse_sim.estimators.pose.densefusion.settings import Preset, TrainConfig, with_preset
from warehouse_sim.estimators.registries import DETECTORS, SEGMENTERS
from warehouse_sim.learning.settings import LoopConfig


def train(
    estimator: tyro.conf.Positional[str],
    data: tuple[Path, ...],
    out: Path,
    resume: bool = False,
    init: str | None = None,
    cache: Path | None = None,
    preset: Preset = "plain",
    config: Annotated[TrainConfig, tyro.conf.arg(name="")] = TrainConfig(),  # noqa: B008  frozen
) -> None:
    """Train an estimator on the train split, watch it on val, and fit there how its confidence predicts its error.

    Test is never read. With --stream.recipe observations are made while the network trains on them, and of the data,
    which that recipe has made with another seed, the train split is not read. Detectors and segmenters have settings of
    their own: ``warehouse-sim train NAME --help``.

    Args:
        estimator: Name of an estimator, see ``warehouse-sim list``.
        data: One or several dataset folders; objects of one number must be one geometry.
        out: Run folder to make: weights, resolved config, curves, result.
        resume: Go on with a run that was interrupted.
        init: Bundled estimator or run folder whose weights training begins with; fresh ones by default.
        cache: Folder that keeps the crops for the next training, by default ``warehouse-sim/crops`` in your cache
            folder; ``none`` keeps them in memory.
        preset: What settings are that are left at their defaults: robust gives the network what is around masks,
            disturbs these and turns clouds upright by gravity; plain trains on ground-truth masks in the camera's axes.
        config: How to train.
    """
    _train(estimator, data, out, resume, init, cache, with_preset(config, preset))
    finish(out, "predict", out, "--data", data[0], "--out", out / "predictions.csv")


def train_command(arguments: Sequence[str]) -> Callable[..., Any]:
    """Return what ``train`` does with a command line: a detector or a segmenter has settings of its own type."""
    name = next((item for item in arguments[1:] if not item.startswith("-")), "") if arguments[:1] == ["train"] else ""
    registry = next((item for item in (DETECTORS, SEGMENTERS) if name in item.names()), None)
    settings = getattr(registry.get(name), "settings", None) if registry else None
    return train if settings is None else _front_end_command(settings)


def _front_end_command(settings: Any) -> Callable[..., Any]:
    def train_front_end(
        estimator: tyro.conf.Positional[str],
        data: tuple[Path, ...],
        out: Path,
        resume: bool = False,
        init: str | None = None,
        cache: Path | None = None,
        config: Any = settings,
    ) -> None:
        """Train a detector or a segmenter on the train split and watch it on val; test is never read.

        Args:
            estimator: Name of a detector or a segmenter, see ``warehouse-sim list``.
            data: One or several dataset folders.
            out: Run folder to make: weights, resolved config, curves, result.
            resume: Go on with a run that was interrupted.
            init: Bundled one or run folder whose weights training begins with; fresh ones by default.
            cache: Folder that keeps the scaled images for the next training, by default in your cache folder; ``none``
                keeps them in memory.
            config: How to train.
        """
        _train(estimator, data, out, resume, init, cache, config)
        finish(out, "detect", out, "--data", data[0], "--out", out / "detections.json")

    train_front_end.__annotations__["config"] = Annotated[type(settings), tyro.conf.arg(name="")]
    return train_front_end


def _train(
    estimator: str,
    data: Sequence[Path],
    out: Path,
    resume: bool,
    init: str | None,
    cache: Path | None,
    config: LoopConfig,
) -> None:
    """Train and calibrate."""
    from warehouse_sim.api.training import fit

    remark = fit(estimator, data, out, config, resume, init, cache, fraction_progress)
    if remark:
        say(remark)
