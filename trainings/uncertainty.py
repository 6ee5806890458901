"""Fit the uncertainty of estimators on scenes of their own, and measure what it is worth on others, disturbed and not.

    python -m trainings.uncertainty densefusion-depth icp-multistart --write

It is fitted on the frozen recipe from a seed that nothing else uses, read by three depth cameras, with masks that are
right and wrong in four ways, and judged under every error of masks and on cameras that it was not fitted on.
Samples are kept, newer weights collect them again; ``uncertainty.yaml`` is written into the models' folders.
"""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import tyro

from benchmarks.estimators.disturbed import LEARNT, RECIPE, TEST, VAL, made, predict
from benchmarks.result import RESULTS, write_result
from trainings.data import FOLDER
from trainings.uncertainty_fit import fit
from trainings.uncertainty_samples import Samples, collect, joined
from warehouse_sim.benchmark.disturbances import MASK_ERRORS
from warehouse_sim.benchmark.entrants.ways import way_of
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.results import predictions
from warehouse_sim.estimators.pose.uncertainty.model import read_uncertainty, write_uncertainty
from warehouse_sim.estimators.predict import read_images
from warehouse_sim.evaluation import Scores, evaluate
from warehouse_sim.learning.run_folder import WEIGHTS

SEED = 8
FITTED_ON: Mapping[str, tuple[str, ...]] = {
    "quadratic": ("exact", "dilated by 1 px", "as of a segmenter", "touching merged"),
    "d455": ("exact", "eroded by 1 px", "as of a segmenter", "touching merged"),
    "tof_industrial": ("exact", "dilated by 1 px", "as of a segmenter"),
}
"""Cameras, and the masks with each of them; what else is judged was never seen."""
JUDGED_ON = ("d435",)
"""Cameras that it was not fitted on, with right masks."""


def samples_of(method: str, scenes: int, views: int, every: int, folder: Path) -> Samples:
    """Return what a method does on the scenes of the fit, collected first where it is not kept."""
    parts = []
    for sensor, masks in FITTED_ON.items():
        data = made(folder / "data" / f"uncertainty_{sensor}_{SEED}", sensor, scenes, views, SEED, VAL)
        for name in masks:
            file = folder / "uncertainty" / Path(method).name / data.name / f"{name.replace(' ', '_')}.npz"
            if not _is_fresh(file, method):
                estimator = way_of(method).open(DatasetReader(data).objects, uncertainty=False)
                collect(estimator, data, "val", name, every).save(file)
                print(f"collected {file}", flush=True)
            parts.append(Samples.load(file))
    return joined(parts)


def fitted(method: str, samples: Samples) -> None:
    """Fit the uncertainty of a method and write it into its folder."""
    way = way_of(method)
    model = fit(samples, *way.config.way)
    write_uncertainty(way.folder, read_uncertainty(way.folder).with_model(model))
    print(f"{method}: fitted on {model.samples}, AUROC {model.auroc}, bound holds {model.coverage} on scenes left out")


def judged(method: str, only: Sequence[str], every: int, folder: Path) -> Iterator[tuple[str, Scores]]:
    """Yield scores under each disturbance, and by each camera that the uncertainty was not fitted on."""
    stressed = made(folder / "data" / f"stress_{RECIPE}", LEARNT, 24, 6, 41, TEST)
    data = {name: (stressed, name) for name in only or MASK_ERRORS}
    data |= {
        f"{name} camera": (made(folder / "data" / f"sensor_{name}", name, 16, 6, 16, TEST), "exact")
        for name in JUDGED_ON
        if not only or name in only
    }
    for label, (root, masks) in data.items():
        reader = DatasetReader(root)
        estimator = way_of(method).open(reader.objects)
        images = list(read_images(estimator, reader, reader.images("test")[::every]))
        place = folder / "scores" / Path(method).name / root.name / f"uncertainty {label}".replace(" ", "_")
        predictions.write(place / "predictions.csv", predict(estimator, images, MASK_ERRORS[masks]))
        yield label, evaluate(place / "predictions.csv", root, "test", method=f"{method}, {label}")


def rows(method: str, label: str, scores: Scores) -> list[dict[str, Any]]:
    """Return what a score says of uncertainty as rows of a result file."""
    trust = scores.trust
    common = {"method": method, "data": label, "failures": trust.failures}
    values = [
        ("auroc", trust.auroc, trust.auroc_interval, trust.estimates),
        ("aurc", trust.aurc, None, trust.estimates),
        ("aurc of a perfect ranking", trust.aurc_least, None, trust.estimates),
        *((f"bound holds, {item.label}", item.fraction, item.interval, item.count) for item in trust.bound),
    ]
    return [
        {
            "name": f"{method}, {label}: {metric}",
            **common,
            "metric": metric,
            "value": round(value, 4),
            **({} if interval is None else {"interval": [round(end, 4) for end in interval]}),
            "n": count,
        }
        for metric, value, interval, count in values
        if np.isfinite(value)
    ]


def main(
    methods: tyro.conf.Positional[tuple[str, ...]],
    folder: Path = FOLDER,
    scenes: int = 12,
    views: int = 4,
    every: int = 1,
    only: tuple[str, ...] = (),
    refit: bool = True,
    judge: bool = True,
    write: bool = False,
) -> None:
    """Fit and judge the uncertainty of estimators.

    Args:
        methods: Bundled models or run folders, perhaps with +verify, or registered estimators that need no training.
        folder: Where data, samples, predictions and scores are kept.
        scenes: Number of scenes of the fit.
        views: Observations of each of them.
        every: Every so manyth image, in fit and judgement; the others count for nothing.
        only: Names of disturbances or cameras that are judged; all by default.
        refit: Whether uncertainty is fitted; else what lies in the folders is judged.
        judge: Whether it is judged afterwards.
        write: Store the result.
    """
    found = []
    for method in methods:
        if refit:
            fitted(method, samples_of(method, scenes, views, every, folder))
        for label, scores in judged(method, only, every, folder) if judge else ():
            found += rows(method, label, scores)
            trust = scores.trust
            holds = ", ".join(f"{item.label}: {100 * item.fraction:.0f} % of {item.count}" for item in trust.bound)
            print(
                f"{method}, {label}: {trust.failures} of {trust.estimates} fail, AUROC {trust.auroc:.3f} "
                f"[{trust.auroc_interval[0]:.3f}, {trust.auroc_interval[1]:.3f}], AURC {trust.aurc:.4f} "
                f"(perfect {trust.aurc_least:.4f}); bound holds {holds}",
                flush=True,
            )
    if write:
        chosen = "".join(f" {name!r}" for name in only)
        how_much = f"--every {every}" + (f" --only{chosen}" if only else "") + ("" if refit else " --no-refit")
        command = f"python -m trainings.uncertainty {' '.join(methods)} {how_much} --write"
        how = {"recipe": RECIPE, "seed of the fit": SEED, "scenes": scenes, "views": views, "every": every}
        write_result(RESULTS / "uncertainty.json", command, found, data=how)


def _is_fresh(file: Path, method: str) -> bool:
    weights = way_of(method).folder / WEIGHTS
    return file.is_file() and not (weights.is_file() and weights.stat().st_mtime > file.stat().st_mtime)


if __name__ == "__main__":
    tyro.cli(main, description=__doc__)
