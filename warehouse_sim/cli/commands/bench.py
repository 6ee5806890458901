"""``warehouse-sim bench``: suites of the benchmark, from data to a result with intervals."""

import shlex
import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import tyro

from warehouse_sim.cli.checks import processes
from warehouse_sim.cli.console import finish, fraction_progress
from warehouse_sim.errors import WarehouseSimError
from warehouse_sim.optional import missing, require_extra

if TYPE_CHECKING:
    from warehouse_sim.benchmark.suite import Suite


def bench(
    suite: tyro.conf.Positional[str],
    estimators: tuple[str, ...] = (),
    quick: bool = False,
    data: Path | None = None,
    sealed: Path | None = None,
    sums: Path | None = None,
    seal: Path | None = None,
    out: Path = Path("out/bench"),
    workers: int | None = None,
    overwrite: bool = False,
) -> int:
    """Run a suite: generate what is missing, predict, score, and write a result with an interval beside every number.

    What was made before is used again where recipe, weights and settings are the same, by their hashes; a run that was
    stopped goes on where it was. An estimator that cannot be scored is listed with the reason, and the rest goes on;
    exit code 1 says that there was one on the command line, or that one of all suites could not be run.

    Args:
        suite: Name of a shipped suite, see ``warehouse-sim list``, the path of a .yaml file, or ``all``.
        estimators: Estimators to run: oracle, shuffled, bundled names or run folders, perhaps with +verify, +argmax,
            +lidar and so on (docs/benchmark.md), file.py:Class, "exec:COMMAND", a CSV of poses or a folder of such; by
            default those of the suite, and its detectors.
        quick: Small sizes: minutes on two cores, wide intervals.
        data: Third-party folder that is scored in place of the suite's own data: LINEMOD, KITTI, recorded frames; with
            --sealed the public folder of a frozen set.
        sealed: Ground truth of a frozen set, whose SHA-256 is checked: its maker runs the suite on it.
        sums: List of hashes that came with a sealed set that this package does not list.
        seal: Run nothing, but make a fresh frozen set of the suite's recipes: this public folder and, beside it, its
            sealed file. A run that was stopped goes on.
        out: Folder for data, predictions, scores and results.
        workers: Processes that generate, then train, predict and score side by side; one per processor by default.
        overwrite: Detect, predict and score again, whatever is kept; data stay. Without it a result keeps
            estimators that do not run this time.
    """
    require_extra("generate", "to make scenes")
    require_extra("learn", "to predict")
    from warehouse_sim.benchmark.report.markdown import summary
    from warehouse_sim.benchmark.run import RunConfig, result_file, run_suite
    from warehouse_sim.benchmark.sealed.score import log_evaluations
    from warehouse_sim.benchmark.sealed.seal import require_sealed
    from warehouse_sim.benchmark.suite import load_suite, quickened
    from warehouse_sim.resources import suite_names

    if seal is not None:
        return _seal(quickened(load_suite(suite)) if quick else load_suite(suite), seal, processes(workers))
    if sealed is not None:
        require_sealed(sealed, sums)
    config = RunConfig(out, processes(workers), overwrite)
    failed = False
    for name in suite_names() if suite == "all" else [suite]:
        loaded = load_suite(name)
        # Of all suites, only that of recorded frames requires a folder of them.
        given = data if suite != "all" or "recorded" in loaded.takes else None
        command = ["warehouse-sim", "bench", name, *(["--estimators", *estimators] if estimators else [])]
        command += [*(["--quick"] if quick else []), *(["--data", given.name] if given else [])]
        command += ["--sealed", sealed.name] if sealed else []
        try:
            with fraction_progress(loaded.title) as progress:
                with_command = replace(config, command=shlex.join(command))
                result = run_suite(loaded, estimators, quick, with_command, progress, given, sealed)
        except WarehouseSimError as problem:
            if suite != "all":
                raise
            print(f"error: {loaded.title}: {problem}", file=sys.stderr)
            failed = True
            continue
        if sealed is not None:
            log_evaluations(sealed, result)
        print(f"{result.suite}: {result.question}")
        for line in summary(result):
            print(line)
        scored = {row.estimator for row in result.rows}
        failed = failed or any(item.name not in scored for item in result.estimators if estimators)
        failed = failed or bool(estimators and result.left_out)
        path = result_file(out, loaded.name, quick, given)
        _draw(path)
        finish(path)
    return int(failed)


def _seal(suite: "Suite", folder: Path, workers: int) -> int:
    from warehouse_sim.benchmark.sealed.make import make_set

    total = len([item for item in suite.data.values() if not item.trained_on])
    seen = dict[str, int]()
    with fraction_progress(folder.name) as progress:

        def report(name: str, done: int, scenes: int) -> None:
            seen[name] = done
            progress((len(seen) - 1 + done / scenes) / total, f"{name}: {done} of {scenes} scenes")

        path, digest = make_set(suite, folder, workers, report)
    print(f"{digest}  {path.name}")
    finish(path)
    return 0


def _draw(path: Path) -> None:
    """Draw the charts of a result beside it, where the packages for that are installed."""
    if missing("report"):
        print("no charts: the extra report is not installed; warehouse-sim report draws them later", file=sys.stderr)
        return
    from warehouse_sim.benchmark.report import write_suite_report

    write_suite_report([path], path.with_suffix(".html"))
