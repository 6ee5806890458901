"""Run folders: settings of a trained estimator leaf by leaf, its weights and other files damaged."""

import json
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import yaml

from benchmarks.acceptance.hostile.bytes_damage import damages, replace
from benchmarks.acceptance.hostile.case import Case, Check, Expectation
from benchmarks.acceptance.hostile.documents import Mutant, leaves, mutated_document, mutated_leaf
from benchmarks.acceptance.hostile.draw import one_of
from benchmarks.acceptance.hostile.readings import page_problem
from benchmarks.acceptance.hostile.stock import Stock
from benchmarks.acceptance.hostile.watch import Outcome

_COLUMNS = 7
_SURFACES = "objects.safetensors"
# Who reads which file.
_READERS: dict[str, tuple[str, ...]] = {
    "config.yaml": (*("predict",) * 9, *("report",) * 2, "export", *("train --init",) * 2, *("train --resume",) * 2),
    "weights.safetensors": (*("predict",) * 4, "export", *("train --init",) * 2),
    _SURFACES: ("predict",),
    "calibration.yaml": ("predict",),
    "result.json": ("report",),
    "curves.csv": ("report",),
}


def cases(stock: Stock) -> Iterator[Case]:
    """Yield the cases of run folders and of stored scores."""
    config = yaml.safe_load((stock.run / "config.yaml").read_text(encoding="utf-8"))
    mutants = [mutant for path, _ in leaves(config) for mutant in mutated_leaf(config, path, "yaml")]
    for mutant in [*mutants, *mutated_document((stock.run / "config.yaml").read_bytes(), "yaml")]:
        yield _mutant_case(stock, "config.yaml", mutant)
    for name in ("result.json",):
        data = json.loads((stock.run / name).read_text(encoding="utf-8"))
        for path, _ in leaves(data):
            for mutant in mutated_leaf(data, path, "json"):
                # Notes on the training, shown as they are: only what is no JSON must be rejected.
                yield _mutant_case(
                    stock, name, mutant, "reject" if mutant.mutation in ("nan", "inf", "minus_inf") else "either"
                )
    for name in _READERS:
        content = (stock.run / name).read_bytes()
        for damage in damages(content, name):

            def write(folder: Path, damage=damage, name: str = name) -> None:  # type: ignore[no-untyped-def]
                damage.apply(stock.copy_run(folder) / name)

            # A run that has no calibration or result yet is a run.
            optional = name in ("calibration.yaml", "result.json")
            gone = damage.name in ("missing", "a dangling link")
            yield _case(stock, name, damage.name, write, "either" if optional and gone else damage.expect)
    yield from _score_cases(stock)


def _mutant_case(stock: Stock, file: str, mutant: Mutant, expect: Expectation | None = None) -> Case:
    def write(folder: Path) -> None:
        replace(stock.copy_run(folder) / file, mutant.make())

    return _case(stock, f"{file}:{mutant.where}", mutant.mutation, write, expect or mutant.expect)


def _score_cases(stock: Stock) -> Iterator[Case]:
    """Yield stored scores, which report reads, with leaves of one group and of the head replaced."""
    content = (stock.scores / "scores.json").read_bytes()
    data = json.loads(content)
    chosen = [path for path, _ in leaves(data) if path[0] in ("format", "dataset", "counts", "docking_failures")]
    chosen += [path for path, _ in leaves(data["overall"], ("overall",))][:8]
    mutants = [mutant for path in chosen for mutant in mutated_leaf(data, path, "json")]
    for mutant in [*mutants, *mutated_document(content, "json")]:

        def write(folder: Path, mutant: Mutant = mutant) -> None:
            (folder / "scores").mkdir()
            (folder / "scores" / "scores.json").write_bytes(mutant.make())
            (folder / "scores" / "errors.csv").write_bytes((stock.scores / "errors.csv").read_bytes())

        must = mutant.where == "document" or mutant.mutation in ("nan", "inf", "minus_inf", "digits_5001")
        steps = (("report", str(stock.data), "scores", "--out", "page.html"),)
        expect = mutant.expect if must else "either"
        yield Case(
            "run", f"scores.json:{mutant.where}", mutant.mutation, steps, write, expect, _page_is_sane, ("scores",)
        )


def _case(stock: Stock, what: str, mutation: str, write: Callable[[Path], None], expect: Expectation) -> Case:
    file = what.partition(":")[0]
    reader = one_of(_READERS[file], what, mutation)
    if reader == "report" and what.startswith("config.yaml:") and not what.endswith(":document"):
        expect = "either"  # a page shows some settings and uses none
    few = ("--max-steps", "2", "--batch", "2", "--threads", "1", "--cache", "none")
    data = str(stock.data)
    refine = ("--refine", "icp") if file == _SURFACES else ()  # surfaces are read for ICP alone
    step: tuple[str, ...]
    check: Check
    step, check = {
        "predict": (("predict", "run", "--data", data, "--out", "poses.csv", *refine), _poses_are_possible(stock)),
        "report": (("report", "run", "--out", "page.html"), _page_is_sane),
        "export": (("export", "run", "--out", "network.onnx"), _exported),
        "train --init": (
            ("train", "densefusion-pointcloud", "--data", data, "--out", "new", "--init", "run", *few),
            _trained("new"),
        ),
        "train --resume": (
            ("train", "densefusion-pointcloud", "--data", data, "--out", "run", "--resume", "--size", "nano", *few),
            _trained("run"),
        ),
    }[reader]
    key = what.rpartition(".")[2]
    return Case("run", what, mutation, (step,), write, expect, check, (file, Path(file).stem, key, "run"))


def _poses_are_possible(stock: Stock) -> Check:
    """Return a check that there is a row for each visible target, finite, before the camera and not beyond a hall."""
    wanted = len((stock.root / "run_predictions.csv").read_text(encoding="ascii").splitlines())

    def check(folder: Path, outcomes: Sequence[Outcome]) -> str | None:
        lines = (folder / "poses.csv").read_text(encoding="ascii").splitlines()
        if len(lines) != wanted:
            return f"it predicts {len(lines) - 1} poses instead of {wanted - 1}"
        for line in lines[1:]:
            words = line.split(",")
            t = [float(word) for word in words[5].split()]
            if len(words) != _COLUMNS or not all(abs(value) < 1e5 for value in t):
                return f"it places an object at {t} mm"
        return None

    return check


def _page_is_sane(folder: Path, outcomes: Sequence[Outcome]) -> str | None:
    return page_problem(folder / "page.html")


def _exported(folder: Path, outcomes: Sequence[Outcome]) -> str | None:
    path = folder / "network.onnx"
    return None if path.is_file() and path.stat().st_size > 1000 else "no network was written"


def _trained(run: str) -> Check:
    def check(folder: Path, outcomes: Sequence[Outcome]) -> str | None:
        result = json.loads((folder / run / "result.json").read_text(encoding="utf-8"))
        wrong = [key for key, value in result.items() if isinstance(value, float) and not 0.0 <= value < 1e9]
        return f"{wrong[0]} of the training is {result[wrong[0]]}" if wrong else None

    return check
