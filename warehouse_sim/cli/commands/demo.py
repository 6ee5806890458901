"""``warehouse-sim demo``: the whole way on one recipe, by the same commands that a user calls."""

import json
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from warehouse_sim.cli.checks import processes
from warehouse_sim.cli.commands.evaluate import evaluate, report
from warehouse_sim.cli.commands.generate import generate
from warehouse_sim.cli.commands.predict import predict
from warehouse_sim.cli.commands.preview import preview
from warehouse_sim.cli.commands.train import train
from warehouse_sim.cli.commands.view import validate
from warehouse_sim.cli.console import finish, say
from warehouse_sim.dataset.card.croissant import FILE as CROISSANT
from warehouse_sim.dataset.card.croissant import write_croissant
from warehouse_sim.errors import DatasetError
from warehouse_sim.optional import require_extra
from warehouse_sim.output import make_folder, write_bytes


def demo(
    out: Path = Path("out/demo"),
    recipe: str = "demo",
    scenes: int | None = None,
    seed: int = 0,
    estimator: str = "densefusion-pointcloud",
    max_minutes: float = 5.0,
    workers: int | None = None,
) -> int:
    """Go the whole way: preview, generate, validate, train, predict, evaluate, report.

    A demo that was interrupted goes on where it stopped when it is started again on the same folder.

    Args:
        out: Folder for everything; the page to open is ``report.html`` in it, ``croissant.json`` describes the dataset.
        recipe: Name of a shipped recipe or path of a recipe file.
        scenes: Number of scenes; the recipe's own number by default.
        seed: Seed of the dataset and of the training, >= 0.
        estimator: Estimator to train.
        max_minutes: Time for training in minutes.
        workers: Processes that generate; one per processor by default.
    """
    require_extra("generate", "to make scenes")
    require_extra("learn", "to train")
    require_extra("report", "to write a report")
    from warehouse_sim.estimators.pose.densefusion.settings import TrainConfig
    from warehouse_sim.estimators.settings import PredictConfig

    data, run, workers = out / "data", out / estimator, processes(workers)
    make_folder(out)
    clock = _StageClock()
    with clock.stage("preview"):
        preview(recipe, seed=seed, out=out / "preview.png")
    with clock.stage("generate"):
        generate(recipe, out=data, scenes=scenes, seed=seed, workers=workers, resume=data.exists())
    with clock.stage("validate"):
        if validate(data) != 0:
            raise DatasetError(f"{data}: the generated dataset fails its own checks; please report this as a bug")
    write_croissant(data, out / CROISSANT)
    with clock.stage("train"):
        if not (run / "result.json").is_file():
            train(estimator, (data,), run, resume=run.exists(), config=TrainConfig(max_minutes=max_minutes, seed=seed))
    scored = []
    plain = PredictConfig(selection="argmax", refine="none")
    methods = {estimator: plain, f"{estimator}-icp": replace(plain, refine="icp")}
    for method, config in methods.items():
        predictions, folder = out / "predictions" / f"{method}.csv", out / "scores" / method
        with clock.stage(f"predict {method}"):
            predict(str(run), data=data, out=predictions, overwrite=True, config=config)
        with clock.stage(f"evaluate {method}"):
            evaluate(predictions, folder, data, overwrite=True)
        scored.append(folder)
    with clock.stage("report"):
        report((data, run, *scored), out / "report.html", overwrite=True)
    write_bytes(out / "timing.json", (json.dumps(clock.seconds, indent=1) + "\n").encode("utf-8"))
    say(f"the demo took {sum(clock.seconds.values()) / 60:.1f} minutes")
    finish(out / "report.html", "preview", "demo", "--seed", "1", "--out", out / "another.png")
    return 0


class _StageClock:
    """Wall seconds by stage."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Time the block."""
        start = time.monotonic()
        yield
        self.seconds[name] = round(time.monotonic() - start, 1)
