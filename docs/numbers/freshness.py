"""How far stored results are those of the suites and models as they are."""

from collections.abc import Iterator

from docs.numbers.stored import RESULTS
from warehouse_sim.benchmark.entrants.entrant import entrant
from warehouse_sim.benchmark.facts import detector_facts, estimator_facts
from warehouse_sim.benchmark.result import EstimatorFacts, SuiteResult, read_result
from warehouse_sim.benchmark.suite import Suite, load_suite
from warehouse_sim.resources import suite_names


def unstored() -> list[str]:
    """Return the suites of which no full result is stored."""
    return [name for name in suite_names() if not (RESULTS / "suites" / f"{name}.json").is_file()]


def lines(names: list[str]) -> Iterator[list[str]]:
    """Yield the cells of each suite: name, size, version, what its result lacks, whose files have changed."""
    for name in names:
        path = RESULTS / "suites" / f"{name}.json"
        if not path.is_file():
            yield [f"`{name}`", "no stored result", "-", "-", "-"]
            continue
        result, suite = read_result(path), load_suite(name)
        size = ", ".join(f"{item.images} images, {item.ground_truths} objects" for item in result.data)
        yield [
            f"`{name}`",
            f"{'quick' if result.quick else 'full'}: {size}",
            result.machine["packages"]["warehouse-sim"],
            _listed(lacking(suite, result)),
            _changed(suite, result),
        ]


def lacking(suite: Suite, result: SuiteResult) -> list[str]:
    """Return estimators, detectors, trainings and conditions of a suite that its stored result lacks."""
    stored = {item.name.partition("@")[0] for item in result.estimators}
    wanted = [*suite.estimators, *suite.detectors, *suite.trainings]
    conditions = {row.condition for row in result.rows if row.table == "scores"}
    return [
        *(item for item in wanted if item not in stored),
        *(item for item in suite.evaluated if item not in conditions),
    ]


def changed(suite: Suite, result: SuiteResult) -> list[str]:
    """Return the estimators and detectors whose weights or settings are not those that the result was made with."""
    then = {item.name: item.weights_sha256 for item in result.estimators}
    return [name for name in _trained(result) if then[name] != _today(name, suite).weights_sha256]


def _changed(suite: Suite, result: SuiteResult) -> str:
    names = changed(suite, result)
    return "all bundled ones" if names and names == _trained(result) else _listed(names)


def _trained(result: SuiteResult) -> list[str]:
    return [item.name for item in result.estimators if item.weights_sha256 and item.samples is None]


def _today(name: str, suite: Suite) -> EstimatorFacts:
    if name in suite.detectors:
        return next(iter(detector_facts([name], [])))
    return next(iter(estimator_facts([entrant(name)])))


def _listed(names: list[str]) -> str:
    return ", ".join(f"`{name}`" for name in names) or "-"
