"""Run a suite: generate missing data, run all estimators, score, compare, and write the result."""

import os
import shutil
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from itertools import chain
from pathlib import Path

from warehouse_sim.benchmark.ahead import Question, make_ahead
from warehouse_sim.benchmark.entrants.detected import SEEN
from warehouse_sim.benchmark.entrants.entrant import Entrant, Evaluated, Group, entrant
from warehouse_sim.benchmark.entrants.trained import trained, trainings_of
from warehouse_sim.benchmark.facts import data_facts, detector_facts, estimator_facts, renderers
from warehouse_sim.benchmark.groups import fixed_subset, lidar_points, split_name
from warehouse_sim.benchmark.machine import machine
from warehouse_sim.benchmark.negatives.score import negative_rows
from warehouse_sim.benchmark.recorded.entries import BASELINE
from warehouse_sim.benchmark.recorded.score import baseline_group, face_rows, find_recorded, who_answers
from warehouse_sim.benchmark.report.markdown import page
from warehouse_sim.benchmark.result import LeftOut, SuiteResult, beside, read_result, write_result
from warehouse_sim.benchmark.rows.effects import effect_rows
from warehouse_sim.benchmark.rows.finding import detection_rows, found_by
from warehouse_sim.benchmark.rows.row import Row
from warehouse_sim.benchmark.rows.scores import require_metrics, score_rows, worst_rows
from warehouse_sim.benchmark.rows.simulated import driven_rows, simulated_rows
from warehouse_sim.benchmark.scored import SPLITS, Answer, Opened, machine_of, scored
from warehouse_sim.benchmark.sealed.score import open_set
from warehouse_sim.benchmark.sets import MadeSet, made
from warehouse_sim.benchmark.suite import ConditionConfig, DataConfig, Suite, quickened
from warehouse_sim.benchmark.third_party import counted, on_folder
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.errors import (
    DatasetError,
    EvaluationError,
    InputError,
    MissingPackageError,
    TrainingError,
    UnknownNameError,
)
from warehouse_sim.evaluation import Scores
from warehouse_sim.output import write_bytes

Progress = Callable[[float, str], None]
_CANNOT = (TrainingError, InputError, DatasetError, EvaluationError, MissingPackageError, UnknownNameError)
"""Why an estimator is left out of a table by name, with the reason; all else ends the run."""


@dataclass(frozen=True)
class RunConfig:
    """How a suite is run; nothing of it changes a number."""

    out: Path = Path("out/bench")
    """Folder of the benchmark: data, predictions, scores and results."""
    workers: int = field(default_factory=lambda: os.cpu_count() or 1)
    """Processes that generate, then train, predict and score side by side."""
    overwrite: bool = False
    """Detect, predict and score again, whatever is kept."""
    command: str = ""
    """What the result says makes it again."""


@dataclass
class _Run:
    """What a run has found so far."""

    suite: Suite
    config: RunConfig
    progress: Progress
    opened: dict[str, Opened] = field(default_factory=dict)
    groups: list[Group] = field(default_factory=list)
    answers: list[Answer] = field(default_factory=list)
    left_out: list[LeftOut] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    reused: int = 0
    made_now: set[tuple[str, Entrant]] = field(default_factory=set)
    """Conditions and entrants whose answers were made in this run, before they were requested in order."""


def run_suite(
    suite: Suite,
    estimators: Sequence[str] = (),
    quick: bool = False,
    config: RunConfig = RunConfig(),
    progress: Progress = lambda fraction, note: None,
    data: Path | None = None,
    sealed: Path | None = None,
) -> SuiteResult:
    """Run a suite, write ``results/SUITE.json`` and the page beside it, and return what this run found.

    Data, predictions and scores that were made of the same inputs (recipe, weights, settings, by their hashes) are
    taken from ``config.out``; a run that was stopped goes on where it was. Estimators of a result there that do not run
    this time stay in it, unless ``config.overwrite``.

    Args:
        suite: What is evaluated.
        estimators: Estimators to run; those of the suite and its detectors by default.
        quick: Whether at small sizes.
        config: Where and how.
        progress: Called with the fraction that is done and what is going on.
        data: Third-party folder that is scored in place of the suite's own data, or the public half of a frozen set.
        sealed: The sealed half of that set, which the caller has checked.

    Raises:
        UnknownNameError: There is no such recipe, estimator or disturbance.
        ConfigError: The suite names what there is not.
        InputError: The suite does not take such a folder.
        EvaluationError: Predictions cannot be scored.
    """
    started = time.monotonic()
    run = _Run(quickened(suite) if quick else suite, config, progress)
    extra: list[Row] = []
    if config.overwrite:
        shutil.rmtree(config.out / SEEN, ignore_errors=True)
    # Who is not known shall be said before anything is made.
    run.groups = list(_entrants(run, estimators)) if estimators else [entrant(name) for name in run.suite.estimators]
    if estimators:  # The suite's own detectors would take longer than most of them.
        run.suite = replace(run.suite, detectors=())
    if "recorded" in suite.takes:
        extra += _on_recorded(run, data)
    elif sealed is not None:
        _on_sealed(run, sealed, data)
    elif data is not None:
        _on_folder(run, data, estimators)
    else:
        _open_data(run)
        _train(run)
        _ask(run)
    rows = (*_rows(run), *extra)
    result = SuiteResult(
        suite=suite.title,
        question=suite.question,
        quick=quick,
        command=config.command,
        machine=machine(renderers(run.opened.values())),
        seconds=round(time.monotonic() - started, 1),
        reused=run.reused,
        data=tuple(data_facts(run.opened, run.answers)),
        estimators=(*estimator_facts(run.groups), *detector_facts(run.suite.detectors, run.groups)),
        rows=rows,
        left_out=tuple(run.left_out),
        notes=tuple(run.notes),
    )
    path = result_file(config.out, suite.name, quick, data)
    stored = None
    if path.is_file() and not config.overwrite:
        with suppress(EvaluationError):  # What cannot be read is replaced.
            stored = read_result(path)
    store(beside(stored, result) if stored else result, path)
    return result


def _entrants(run: _Run, names: Sequence[str]) -> Iterator[Group]:
    """Yield the groups of a command line; what is none is left out, and an error where nothing else is there."""
    for name in names:
        try:
            yield entrant(name)
        except _CANNOT as problem:
            if len(names) == 1:
                raise
            _leave_out(run, name, "all", problem)


def result_file(out: Path, name: str, quick: bool, data: Path | None = None) -> Path:
    """Return where a result lies."""
    parts = [name, *([data.resolve().name] if data else []), *(["quick"] if quick else [])]
    return out / "results" / f"{'-'.join(parts)}.json"


def store(result: SuiteResult, path: Path) -> None:
    """Write a result and its page beside it."""
    write_result(result, path)
    write_bytes(path.with_suffix(".md"), (page(result) + "\n").encode("utf-8"))


def _open_data(run: _Run) -> None:
    counts_points = any("lidar_points" in split_name(name) for name in run.suite.by)
    for name, data in run.suite.data.items():
        if not data.trained_on:
            found = _made(run, name, data)
            reader = DatasetReader(found.root)
            run.opened[name] = Opened(found, reader, lidar_points(reader, SPLITS[0]) if counts_points else {})


def _made(run: _Run, name: str, data: DataConfig) -> MadeSet:
    def report(done: int, total: int) -> None:
        run.progress(0.0, f"data {name}: {done} of {total} scenes")

    return made(name, data, run.config.out, run.config.workers, report)


def _train(run: _Run, roots: Mapping[str, Path] | None = None) -> None:
    """Train what the suite trains; each training of each length is evaluated after the named estimators."""
    if not run.suite.trainings:
        return
    known = roots or {name: _made(run, name, item).root for name, item in run.suite.data.items() if item.trained_on}
    _train_ahead(run, known)
    for name, training in run.suite.trainings.items():

        def report(fraction: float, note: str, title: str = f"training {name}") -> None:
            run.progress(0.0, f"{title}: {fraction:.0%}, {note}")

        try:
            run.groups += trained(name, training, known, run.config.out, report)
        except _CANNOT as problem:
            _leave_out(run, name, "training", problem)


def _train_ahead(run: _Run, roots: Mapping[str, Path]) -> None:
    wanted = [
        one
        for name, training in run.suite.trainings.items()
        for one in trainings_of(name, training, roots, run.config.out)
    ]
    make_ahead(wanted, run.config.workers, lambda done, total: run.progress(0.0, f"{done} of {total} trainings"))


def _on_folder(run: _Run, data: Path, estimators: Sequence[str]) -> None:
    """Run the suite on a third-party folder, by the protocol of the dissertation."""
    run.suite, opened, rules = on_folder(run.suite, data)
    run.opened[opened.made.name] = opened
    run.groups = [entrant(name) for name in estimators or run.suite.estimators]
    _train(run, {opened.made.name: data})
    _ask(run)
    run.answers = counted(run.answers, rules, data)
    run.notes.append(rules.text)


def _on_sealed(run: _Run, sealed: Path, public: Path | None) -> None:
    """Run the suite on a frozen set whose halves are both there."""
    run.progress(0.0, f"{sealed.name} is unpacked")
    run.opened, note = open_set(run.suite, sealed, public, run.config.out)
    kept = {name: item for name, item in run.suite.evaluated.items() if item.data in run.opened}
    run.suite = replace(run.suite, conditions=kept)
    run.notes.append(note)
    _train(run)
    _ask(run)


def _on_recorded(run: _Run, data: Path | None) -> list[Row]:
    """Score what of some recorded frames can be scored, and say what cannot."""
    if data is None:
        run.notes.append("no recorded frames were given, so nothing is scored: name their folder with --data")
        return []
    rows: list[Row] = []
    for item in find_recorded(data):
        run.progress(0.0, item.path.name)
        if item.kind == "other":
            run.notes.append(item.note)
        elif item.kind == "posed":
            name = item.path.resolve().name
            run.opened[name] = Opened(MadeSet(name, item.path), DatasetReader(item.path), {}, item.split)
        else:
            run.groups += [] if BASELINE in {group.name for group in run.groups} else [baseline_group()]
            rows += _of_faces(run, item.path)
    evaluated = {name: ConditionConfig(name) for name in run.opened}
    run.suite = replace(run.suite, conditions=evaluated)
    _ask(run)
    run.answers, silent = who_answers(run.answers)
    run.left_out += silent
    return rows


def _of_faces(run: _Run, folder: Path) -> Iterator[Row]:
    for group in run.groups:
        try:
            yield from face_rows(group, folder)
        except _CANNOT as problem:
            _leave_out(run, group.name, folder.name, problem)


def _ask(run: _Run) -> None:
    evaluated = [
        (name, item, group) for name, item in run.suite.evaluated.items() for group in _evaluated(item, run.groups)
    ]
    _ask_ahead(run, [(name, item, member) for name, item, group in evaluated for member in group.members])
    for number, (name, condition, group) in enumerate(evaluated):

        def report(fraction: float, note: str, number: int = number, title: str = f"{group.name}, {name}") -> None:
            run.progress((number + fraction) / len(evaluated), f"{title}: {note}")

        report(0.0, "evaluated")
        try:
            answer = _answer(run, name, condition, group, report)
        except _CANNOT as problem:
            _leave_out(run, group.name, name, problem)
            continue
        if not run.answers:
            require_metrics(run.suite, answer.scores[0].table)
        run.answers.append(answer)


def _ask_ahead(run: _Run, evaluated: Sequence[tuple[str, ConditionConfig, Entrant]]) -> None:
    """Make answers side by side, and remember which were made now.

    Of those who share detections in a dataset one goes first: the others take what it found.
    """
    first: dict[tuple[str, str], int] = {}
    for number, (_, condition, member) in enumerate(evaluated):
        if isinstance(member, Evaluated):
            first.setdefault((condition.data, member.config_under(condition).detections), number)
    firsts = [evaluated[number] for number in first.values()]
    others = [item for number, item in enumerate(evaluated) if number not in first.values()]
    for part in (firsts, others):
        questions = []
        for _, condition, member in part:
            opened = run.opened[condition.data]
            questions.append(
                Question(member, condition, opened.made, opened.split, run.config.out, run.config.overwrite)
            )
        made = make_ahead(
            questions, run.config.workers, lambda done, total: run.progress(done / total, f"{done} of {total} answers")
        )
        run.made_now |= {(part[number][0], part[number][2]) for number in made}


def _evaluated(condition: ConditionConfig, groups: Sequence[Group]) -> list[Group]:
    groups = [group for group in groups if group.name != BASELINE]
    if not condition.estimators:
        return list(groups)
    return [group for group in groups if group.name in condition.estimators or not _is_evaluated(group)]


def _is_evaluated(group: Group) -> bool:
    return isinstance(group.members[0], Evaluated)


def _answer(run: _Run, name: str, condition: ConditionConfig, group: Group, report: Progress) -> Answer:
    opened = run.opened[condition.data]
    found: list[Scores] = []
    for member in group.members:
        is_new = (name, member) in run.made_now
        overwrite = run.config.overwrite and not is_new
        scores, reused = scored(member, condition, opened, run.config.out, overwrite, report)
        run.reused += reused and not is_new
        if condition.seconds_an_object is not None:
            scores = replace(scores, table=scores.table.select(fixed_subset(scores.table)))
        found.append(scores)
    machine = machine_of(group.members[0], condition, opened, run.config.out)
    return Answer(group, name, opened, tuple(found), machine)


def _rows(run: _Run) -> Iterator[Row]:
    scores = [row for answer in run.answers for row in score_rows(answer, run.suite)]
    yield from worst_rows(scores, list(run.suite.evaluated)) if run.suite.worst_first else ()
    yield from scores
    yield from chain.from_iterable(effect_rows(run.answers, run.suite, item) for item in run.suite.compare)
    yield from _found(run)
    yield from _simulated(run)
    yield from _negative(run)


def _found(run: _Run) -> Iterator[Row]:
    """Yield how well the suite's detectors find the objects of each of its datasets."""
    for detector in run.suite.detectors:
        for name, opened in run.opened.items():
            run.progress(1.0, f"{detector} finds, {name}")
            try:
                found = found_by(detector, opened, run.config.out, run.config.overwrite)
                yield from detection_rows(detector, name, found, opened)
            except _CANNOT as problem:
                _leave_out(run, detector, name, problem)


def _simulated(run: _Run) -> Iterator[Row]:
    for answer in run.answers if run.suite.simulate else ():
        run.progress(1.0, f"{answer.group.name}, {answer.condition}: simulated truck")
        yield from simulated_rows(answer, run.config.out, run.suite.simulated_poses)
    run.progress(1.0, "closed loop")
    answered = {answer.group.name for answer in run.answers}
    failed = {item.estimator for item in run.left_out} - answered
    yield from driven_rows(
        [group for group in run.groups if group.name not in failed], run.suite.approach, run.config.out
    )


def _negative(run: _Run) -> list[Row]:
    def report(done: int, total: int) -> None:
        run.progress(done / total, f"negatives: {done} of {total} halls")

    rows, left_out = negative_rows(run.groups, run.suite.negatives, run.config.out, run.config.workers, report)
    run.left_out += left_out
    return rows


def _leave_out(run: _Run, estimator: str, condition: str, problem: Exception) -> None:
    """Say who could not be scored and why; results name no folder of the machine that they were made on."""
    reason = str(problem)
    folders = (run.config.out, *(item.made.root for item in run.opened.values()))
    for path in sorted({f for folder in folders for f in (folder, folder.parent)}, key=lambda f: -len(str(f))):
        if len(path.parts) > 1:
            reason = reason.replace(f"{path}/", "")
    run.left_out.append(LeftOut(estimator, condition, reason))
