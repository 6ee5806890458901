"""Run a suite: make what is missing, ask everyone, score, compare, and write the result."""

import os
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import chain
from pathlib import Path

from warehouse_sim.benchmark.effects import effect_rows
from warehouse_sim.benchmark.entrants import TRUTH, Asked, Group, entrant, weights_digest
from warehouse_sim.benchmark.finding import detection_rows, found_by
from warehouse_sim.benchmark.groups import lidar_points, split_name
from warehouse_sim.benchmark.page import page
from warehouse_sim.benchmark.result import DataFacts, EstimatorFacts, LeftOut, SuiteResult, machine, write_result
from warehouse_sim.benchmark.rows import Row, curve_rows, require_metrics, score_rows
from warehouse_sim.benchmark.scored import SPLIT, Answer, Opened, scored
from warehouse_sim.benchmark.sets import MadeSet, made
from warehouse_sim.benchmark.spread import spread_rows
from warehouse_sim.benchmark.suite import ConditionConfig, Suite, quickened
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.errors import DatasetError, InputError, MissingPackageError, TrainingError
from warehouse_sim.evaluation import ScoreConfig, Scores
from warehouse_sim.output import write_bytes

Progress = Callable[[float, str], None]
_CANNOT = (TrainingError, InputError, DatasetError, MissingPackageError)
"""Why an estimator is left out of a table by name, with the reason; all else ends the run."""


@dataclass(frozen=True)
class RunConfig:
    """How a suite is run; nothing of it changes a number."""

    out: Path = Path("out/bench")
    """Folder of the benchmark: data, predictions, scores and results."""
    workers: int = field(default_factory=lambda: os.cpu_count() or 1)
    """Processes that generate."""
    anew: bool = False
    """Predict and score again, whatever is kept."""
    command: str = ""
    """What the result says makes it again."""


@dataclass
class _Run:
    """What a run has found so far."""

    suite: Suite
    config: RunConfig
    progress: Progress
    opened: dict[str, Opened] = field(default_factory=dict)
    answers: list[Answer] = field(default_factory=list)
    left_out: list[LeftOut] = field(default_factory=list)
    reused: int = 0


def run_suite(
    suite: Suite,
    estimators: Sequence[str] = (),
    quick: bool = False,
    config: RunConfig = RunConfig(),
    progress: Progress = lambda share, note: None,
) -> SuiteResult:
    """Run a suite, write ``results/SUITE.json`` and the page beside it, and return the result.

    Data, predictions and scores that were made of the same inputs (recipe, weights, settings, by their hashes) are
    taken from ``config.out``; a run that was stopped goes on where it was.

    Args:
        suite: What is asked.
        estimators: Who is asked; those of the suite by default.
        quick: Whether at small sizes.
        config: Where and how.
        progress: Called with the share that is done and what is going on.

    Raises:
        UnknownNameError: There is no such recipe, estimator or disturbance.
        ConfigError: The suite names what there is not.
        EvaluationError: Predictions cannot be scored.
    """
    started = time.monotonic()
    suite = quickened(suite) if quick else suite
    groups = [entrant(name) for name in estimators or suite.estimators]
    run = _Run(suite, config, progress)
    _open_data(run)
    _ask(run, groups)
    rows = (*_rows(run), *_found(run))
    result = SuiteResult(
        suite=suite.title,
        question=suite.question,
        quick=quick,
        command=config.command,
        machine=machine(_renderers(run)),
        seconds=round(time.monotonic() - started, 1),
        reused=run.reused,
        data=tuple(_data_facts(run)),
        estimators=(*_estimator_facts(groups), *_detector_facts(run, groups)),
        rows=rows,
        left_out=tuple(run.left_out),
    )
    store(result, config.out / "results" / f"{suite.name}{'-quick' if quick else ''}.json")
    return result


def store(result: SuiteResult, path: Path) -> None:
    """Write a result and its page beside it."""
    write_result(result, path)
    write_bytes(path.with_suffix(".md"), (page(result) + "\n").encode("utf-8"))


def _open_data(run: _Run) -> None:
    counts_points = any("lidar_points" in split_name(name) for name in run.suite.by)
    for name, data in run.suite.data.items():
        if data.trained_on:
            continue
        run.progress(0.0, f"data {name}")
        found = made(name, data, run.config.out, run.config.workers, lambda done, total: None)
        reader = DatasetReader(found.root)
        run.opened[name] = Opened(found, reader, lidar_points(reader, SPLIT) if counts_points else {})


def _ask(run: _Run, groups: Sequence[Group]) -> None:
    asked = [(name, item, group) for name, item in run.suite.asked.items() for group in _asked(item, groups)]
    for number, (name, condition, group) in enumerate(asked):

        def told(share: float, note: str, number: int = number, title: str = f"{group.name}, {name}") -> None:
            run.progress((number + share) / len(asked), f"{title}: {note}")

        told(0.0, "asked")
        try:
            answer = _answer(run, name, condition, group, told)
        except _CANNOT as problem:
            run.left_out.append(LeftOut(group.name, name, str(problem)))
            continue
        if not run.answers:
            require_metrics(run.suite, answer.scores[0].table)
        run.answers.append(answer)


def _asked(condition: ConditionConfig, groups: Sequence[Group]) -> list[Group]:
    if not condition.estimators:
        return list(groups)
    return [group for group in groups if group.name in condition.estimators or not _is_asked(group)]


def _is_asked(group: Group) -> bool:
    return isinstance(group.members[0], Asked)


def _answer(run: _Run, name: str, condition: ConditionConfig, group: Group, told: Progress) -> Answer:
    opened = run.opened[condition.data]
    found: list[Scores] = []
    for member in group.members:
        scores, reused = scored(
            member, condition, opened, run.config.out, ScoreConfig(), anew=run.config.anew, progress=told
        )
        run.reused += reused
        found.append(scores)
    return Answer(group, name, opened, tuple(found))


def _rows(run: _Run) -> Iterator[Row]:
    for answer in run.answers:
        yield from score_rows(answer, run.suite)
        if run.suite.curves:
            yield from curve_rows(answer, run.suite)
            yield from spread_rows(answer, run.suite)
    yield from chain.from_iterable(effect_rows(run.answers, run.suite, item) for item in run.suite.compare)


def _found(run: _Run) -> Iterator[Row]:
    """Yield how well the suite's detectors find the objects of each of its datasets."""
    for detector in run.suite.detectors:
        for name, opened in run.opened.items():
            run.progress(1.0, f"{detector} finds, {name}")
            try:
                yield from detection_rows(
                    detector, name, found_by(detector, opened, run.config.out, run.config.anew), opened.reader
                )
            except _CANNOT as problem:
                run.left_out.append(LeftOut(detector, name, str(problem)))


def _renderers(run: _Run) -> tuple[str, ...]:
    manifests = [item.reader.manifest for item in run.opened.values()]
    return tuple(dict.fromkeys(name for one in manifests if one is not None for name in one.renderers))


def _data_facts(run: _Run) -> Iterator[DataFacts]:
    for name, opened in run.opened.items():
        scores = next((answer.scores[0] for answer in run.answers if answer.opened is opened), None)
        found: MadeSet = opened.made
        yield DataFacts(
            name,
            found.recipe,
            found.recipe_sha256 or opened.reader.digest[:16],
            found.seed,
            len({image.scene_id for image in opened.reader.images(SPLIT)}),
            len(opened.reader.images(SPLIT)),
            0 if scores is None else len(scores.table),
            {} if scores is None else dict(scores.docking_left_out),
        )


def _detector_facts(run: _Run, groups: Sequence[Group]) -> Iterator[EstimatorFacts]:
    for name in run.suite.detectors:
        if name not in {group.name for group in groups}:
            digests = [weights_digest(part) for part in name.split("+")]
            yield EstimatorFacts(name, int(name != TRUTH), "+".join(item[:16] for item in digests if item))


def _estimator_facts(groups: Sequence[Group]) -> Iterator[EstimatorFacts]:
    for group in groups:
        asked = [item for item in group.members if isinstance(item, Asked)]
        digests = [weights_digest(name) for item in asked for name in item.way.parts]
        samples = group.facts.get("samples")
        yield EstimatorFacts(group.name, group.trainings, "+".join(item[:16] for item in digests if item), samples)
