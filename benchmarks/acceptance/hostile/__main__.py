"""Try hostile input on every command that reads it, and judge what comes of it.

    python -m benchmarks.acceptance.hostile                        # about ten minutes on two cores
    python -m benchmarks.acceptance.hostile --only 'recipe/*nan*'  # some cases, with all that they print
    python -m benchmarks.acceptance.hostile --cases 60 --out x.json

Exit code 0 only if no case ended in a traceback, a crash, a hang or silent nonsense.
"""

import json
import os
import tempfile
import time
from pathlib import Path

import tyro
from rich.console import Console

from benchmarks.acceptance.hostile.cases import all_cases
from benchmarks.acceptance.hostile.pick import only as matching
from benchmarks.acceptance.hostile.pick import pick
from benchmarks.acceptance.hostile.run import COMMAND, Result, try_cases
from benchmarks.acceptance.hostile.stock import Stock, make_stock
from benchmarks.acceptance.hostile.table import as_json, count_table, fault_lines
from benchmarks.acceptance.hostile.watch import Limits, Watched
from benchmarks.result import machine


def main(
    cases: int = 1000,
    seed: int = 0,
    only: tuple[str, ...] = (),
    workers: int = 2,
    out: Path | None = None,
    stock: Path | None = None,
    limits: Limits = Limits(),  # noqa: B008  frozen
) -> int:
    """Try hostile input and print a table of what came of it.

    Args:
        cases: Cases to try, drawn evenly from all there are.
        seed: Decides which are drawn.
        only: Ids of cases to try instead, ``*`` stands for anything; prints all that they print.
        workers: Processes side by side, >= 1.
        out: JSON file for the result.
        stock: Folder that keeps the valid files for the next run.
        limits: When a command line is given up.
    """
    console, start = Console(width=160, highlight=False), time.monotonic()
    with tempfile.TemporaryDirectory(prefix="hostile-stock-") as folder:
        os.environ["WAREHOUSE_SIM_CACHE"] = str(Path(folder) / "cache")
        made = _stock(stock or Path(folder), limits, console)
        everything = list(all_cases(made))
        chosen = matching(everything, only) if only else pick(everything, cases, seed)
        console.print(f"{len(chosen)} of {len(everything)} cases", style="dim")
        results = try_cases(chosen, workers, limits, _Progress(console, len(chosen), verbose=bool(only)))
    console.print(count_table(results))
    for line in fault_lines(results):
        console.print(line, markup=False, soft_wrap=True)
    if out is not None:
        result = as_json(results, seed, cases, machine(), time.monotonic() - start)
        out.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
        console.print(f"output: {out}")
    return int(any(result.verdict.is_fault for result in results))


def _stock(root: Path, limits: Limits, console: Console) -> Stock:
    """Return the stock in ``root``, made now unless it is whole."""
    whole = root / "whole"
    if whole.is_file():
        return Stock(root.resolve())
    with Watched(COMMAND, limits, root / "scratch") as watched:
        stock = make_stock(root.resolve(), watched, lambda text: console.print(text, style="dim"))
    whole.touch()
    return stock


class _Progress:
    """Prints each fault when it is found and a line every twentieth of the cases, or all that each case prints."""

    def __init__(self, console: Console, total: int, verbose: bool) -> None:
        self._console, self._total, self._verbose = console, total, verbose
        self._done, self._faults = 0, 0

    def __call__(self, result: Result) -> None:
        self._done += 1
        self._faults += result.verdict.is_fault
        if self._verbose:
            self._show(result)
            return
        if result.verdict.is_fault:
            line = f"{result.verdict.label}: {result.verdict.cause}: {result.case.id}: {result.verdict.reason}"
            self._console.print(line, markup=False, soft_wrap=True)
        if self._done * 20 // self._total > (self._done - 1) * 20 // self._total:
            self._console.print(f"{self._done} of {self._total} cases, {self._faults} faults", style="dim")

    def _show(self, result: Result) -> None:
        self._console.print(f"== {result.case.id}, must: {result.case.expect}", markup=False, soft_wrap=True)
        for outcome in result.outcomes:
            status = outcome.death or f"exit code {outcome.code}"
            self._console.print(
                f"$ warehouse-sim {' '.join(outcome.argv)[:500]}: {status}", markup=False, soft_wrap=True
            )
            self._console.print((outcome.out + outcome.err)[-3000:], markup=False, soft_wrap=True)
        self._console.print(f"-> {result.verdict.label}: {result.verdict.reason}", markup=False, soft_wrap=True)


if __name__ == "__main__":
    raise SystemExit(tyro.cli(main))
