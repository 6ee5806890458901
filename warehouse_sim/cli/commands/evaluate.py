"""``warehouse-sim evaluate`` and ``report``: predictions become scores, and scores a page that a person can look at."""

from pathlib import Path
from typing import Literal

import tyro

from warehouse_sim.cli.checks import write_beside, write_one
from warehouse_sim.cli.console import finish
from warehouse_sim.errors import InputError


def evaluate(
    predictions: tyro.conf.Positional[Path],
    out: Path,
    data: Path | None = None,
    split: str = "test",
    sealed: Path | None = None,
    sums: Path | None = None,
    bop: bool = False,
    vsd: bool = False,
    kitti: bool = False,
    overwrite: bool = False,
) -> None:
    """Score a BOP pose CSV against the ground truth; every undetected object counts as a miss.

    Args:
        predictions: BOP pose CSV, or a folder of KITTI result files, which get KITTI's average precision; for a sealed
            set a folder with a CSV for each of its layouts.
        out: Folder for ``scores.json`` (``kitti_scores.json``; ``SUITE.json`` of a sealed set, aggregates only).
        data: Dataset folder that holds the ground truth.
        split: Split to score on, or all of them.
        sealed: Sealed ground truth of a frozen test set in place of --data; its SHA-256 is checked.
        sums: List of hashes that came with a sealed set that this package does not list.
        bop: Add the scores of the BOP challenges: average recall by MSSD and MSPD, average precision of BOP 2024.
        vsd: Add to these the recall by VSD and the average recall of BOP 2019; it draws every pose.
        kitti: Of a CSV for a folder of KITTI's layout, score KITTI's average precision of upright boxes with the poses
            and the mean size of their class; the result files are kept in ``kitti_results``.
        overwrite: Replace scores with other content that stand in the folder.
    """
    if kitti and (sealed is not None or bop or vsd):
        raise InputError("evaluate: --kitti scores by KITTI's protocol alone; leave out --sealed, --bop and --vsd")
    if sealed is not None:
        _evaluate_sealed(predictions, sealed, sums, out, overwrite)
        return
    if data is None:
        raise InputError("evaluate: needs --data, the dataset folder, or --sealed, the file of a frozen set")
    if kitti or predictions.is_dir():
        _evaluate_kitti(predictions, data, out, split, overwrite)
        return
    from warehouse_sim.api.scoring import evaluate as run
    from warehouse_sim.evaluation import write_scores

    scores = run(predictions, data, split, bop=bop, vsd=vsd)
    path = write_beside(out, lambda folder: write_scores(scores, folder), overwrite)
    for line in scores.summary():
        print(line)
    finish(path, "report", data, out, "--out", out / "report.html")


def _evaluate_sealed(predictions: Path, sealed: Path, sums: Path | None, out: Path, overwrite: bool) -> None:
    from warehouse_sim.benchmark.report.markdown import summary
    from warehouse_sim.benchmark.result import write_result
    from warehouse_sim.benchmark.sealed.score import evaluate_sealed, log_evaluations

    result = evaluate_sealed(predictions, sealed, sums)
    log_evaluations(sealed, result)
    print("\n".join(summary(result)))
    name = f"{result.suite}.json"
    finish(write_beside(out, lambda folder: write_result(result, folder / name), overwrite), "report", out / name)


def _evaluate_kitti(predictions: Path, data: Path, out: Path, split: str, overwrite: bool) -> None:
    from warehouse_sim.dataset.results import predictions as prediction_file
    from warehouse_sim.evaluation.detection.kitti_ap import (
        KittiScore,
        evaluate_kitti_results,
        kitti_lines,
        write_kitti_scores,
    )
    from warehouse_sim.evaluation.detection.kitti_results import write_kitti_results

    scores = list[KittiScore]()

    def write(folder: Path) -> Path:
        results = predictions
        if not predictions.is_dir():
            results = folder / "kitti_results"
            write_kitti_results(prediction_file.read(predictions), data, split, results)
        scores[:] = evaluate_kitti_results(results, data, split)
        return write_kitti_scores(scores, folder)

    path = write_beside(out, write, overwrite)
    print("\n".join(kitti_lines(scores)))
    finish(path, "view", data, "--summary", "--out", out / "summary")


def report(
    folders: tyro.conf.Positional[tuple[Path, ...]],
    out: Path = Path("report.html"),
    frames: int | Literal["all"] = 300,
    overwrite: bool = False,
) -> None:
    """Write one self-contained HTML page about datasets, runs and scores, or about suites of the benchmark.

    Args:
        folders: Dataset, run and evaluation folders; or results of suites (SUITE.json) and folders of them, of which
            charts and leaderboards are drawn.
        out: HTML file to write; of suites, a name that ends in .md takes the leaderboards alone, as Markdown.
        frames: Frames of datasets on the page at most, >= 1, or all; of more, the worst by each filter and a sample.
        overwrite: Replace the file where it has other content.
    """
    from warehouse_sim.api.scoring import report as write

    finish(write_one(out, lambda page: write(*folders, out=page, frames=frames), overwrite))
