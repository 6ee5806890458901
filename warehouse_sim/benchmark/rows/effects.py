"""Paired effects: the same ground truth with one thing changed, by paired variants of a dataset or by conditions."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Bool, Float, Int

from warehouse_sim.benchmark.groups import groups, places_of
from warehouse_sim.benchmark.rows.row import Row
from warehouse_sim.benchmark.rows.scores import make_row, over_trainings
from warehouse_sim.benchmark.scored import Answer
from warehouse_sim.benchmark.suite import CompareConfig, Suite
from warehouse_sim.errors import ConfigError
from warehouse_sim.evaluation.intervals import difference_interval, seed_interval

_SAME = 0.005
"""Visible fractions nearer than this are the same."""
_MOVED = 0.02
"""Objects whose places differ by more (m) are not the same."""
Key = tuple[int, int, int]
"""Scene, place that it is seen from, instance."""
Pairs = tuple[Int[np.ndarray, " p"], Int[np.ndarray, " p"]]
"""Rows of the changed answer and of what it is compared with, about the same objects seen from the same places."""


def effect_rows(answers: Sequence[Answer], suite: Suite, compare: CompareConfig) -> Iterator[Row]:
    """Yield by how much each change raises the fraction of each metric, for every estimator.

    Args:
        answers: All of the suite.
        suite: Whose metrics and bins count.
        compare: What is compared.

    Raises:
        ConfigError: There is no variant or condition of the name to compare with.
    """
    if compare.between:
        yield from _between(answers, suite, compare)
        return
    for name in dict.fromkeys(answer.group.name for answer in answers):
        mine = [answer for answer in answers if answer.group.name == name]
        yield from _of_variants(mine, suite, compare) if compare.variants else _of_conditions(mine, suite, compare)


def _between(answers: Sequence[Answer], suite: Suite, compare: CompareConfig) -> Iterator[Row]:
    for one, other in compare.between:
        first, second = (_named(answers, name) for name in (one, other))
        for condition in (name for name in first if name in second):
            everything = np.arange(len(first[condition].scores[0].table))
            # The same rows: what counts as a ground truth depends on no estimate.
            compared = replace(compare, against=second[condition].group.name)
            yield from _rows(first[condition], second[condition], (everything, everything), suite, compared, "all")


def _named(answers: Sequence[Answer], name: str) -> dict[str, Answer]:
    """Return the answers by condition of an estimator, or of the longest training of that name."""
    names = dict.fromkeys(answer.group.name for answer in answers)
    longest = max((item for item in names if item.startswith(f"{name}@")), key=_steps, default=name)
    chosen = name if name in names else longest
    return {answer.condition: answer for answer in answers if answer.group.name == chosen}


def _steps(name: str) -> int:
    return int(name.rpartition("@")[2])


def _of_variants(answers: Sequence[Answer], suite: Suite, compare: CompareConfig) -> Iterator[Row]:
    for answer in answers:
        variants = answer.opened.variants
        if not variants:
            continue
        if compare.against not in variants:
            known = ", ".join(dict.fromkeys(variants))
            raise ConfigError(
                f"{suite.name}: compare: against: there is no paired variant {compare.against!r}; known: {known}"
            )
        for variant in dict.fromkeys(variants):
            if variant != compare.against:
                pairs = paired(answer, answer, _rows_of(answer, variant), _rows_of(answer, compare.against))
                yield from _rows(answer, answer, pairs, suite, compare, variant)


def _of_conditions(answers: Sequence[Answer], suite: Suite, compare: CompareConfig) -> Iterator[Row]:
    by_name = {answer.condition: answer for answer in answers}
    against = by_name.get(compare.against)
    if against is None:  # who could not answer it is named elsewhere
        return
    among = compare.among or tuple(name for name in by_name if name != compare.against)
    for name in among:
        if name in by_name:
            pairs = paired(by_name[name], against, _all_rows(by_name[name]), _all_rows(against))
            yield from _rows(by_name[name], against, pairs, suite, compare, "")


def _rows(
    first: Answer, second: Answer, pairs: Pairs, suite: Suite, compare: CompareConfig, label: str
) -> Iterator[Row]:
    mine, theirs = pairs
    if compare.changed_only:
        seen, other_seen = (answer.scores[0].table.visible_fraction for answer in (first, second))
        changed = np.abs(seen[mine] - other_seen[theirs]) > _SAME
        mine, theirs = mine[changed], theirs[changed]
    values = {metric: (over_trainings(first, metric), over_trainings(second, metric)) for metric in suite.metrics}
    subjects = first.subjects(suite.edges)
    for group, of_group in groups(subjects, compare.by):
        inside = of_group[mine]
        what = compare.factor if label == "all" else f"{compare.factor}: {label or first.condition}"
        named = what if group == "all" else f"{what}, {group}"
        for metric, (one, other) in values.items():
            gains = one[:, mine[inside]] - other[:, theirs[inside]]
            row = _effect(first, named, metric, gains, subjects.table.scene_id[mine[inside]], compare.against)
            if row is not None:
                yield row


def _effect(
    answer: Answer, label: str, metric: str, gains: Float[np.ndarray, "t p"], scene_id: np.ndarray, against: str
) -> Row | None:
    applies = ~np.isnan(gains).any(axis=0)
    if not applies.any():
        return None
    by_pair, scenes = gains[:, applies].mean(axis=0), scene_id[applies]
    value, (low, high) = float(by_pair.mean()), difference_interval(by_pair, scenes)
    if len(gains) > 1:
        one, other = seed_interval(gains[:, applies].mean(axis=1).tolist())
        low, high = max(min(low, one), -1.0), min(max(high, other), 1.0)
    return make_row(answer, "effects", label, metric, value, (low, high), scenes, against)


def paired(first: Answer, second: Answer, rows: Bool[np.ndarray, " n"], others: Bool[np.ndarray, " m"]) -> Pairs:
    """Return which of some rows of two answers belong together, by scene, place and instance.

    Args:
        first: The changed one.
        second: What it is compared with.
        rows: Of the first.
        others: Of the second.
    """
    mine, theirs = _seen(first), _seen(second)
    place = {theirs[row][0]: row for row in np.flatnonzero(others).tolist()}
    found = []
    for row in np.flatnonzero(rows).tolist():
        key, centre = mine[row]
        other = place.get(key, -1)
        # Scenes of two recipes with one seed may hold other things under the same numbers.
        if other >= 0 and np.abs(centre - theirs[other][1]).max() < _MOVED:
            found.append((row, other))
    left, right = np.array(found, dtype=int).reshape(-1, 2).T
    return left, right


def _seen(answer: Answer) -> list[tuple[Key, Float[np.ndarray, " 3"]]]:
    """Return of each row the scene, the number of the viewpoint and the instance, and where it is (camera frame, m)."""
    numbers = answer.opened.groups
    targets = {
        (image.scene_id, image.image_id, item.gt_index): item
        for image in answer.opened.reader.images(answer.opened.split)
        for item in image.targets
    }
    found = []
    for scene, image, index in places_of(answer.scores[0].table):
        item = targets[scene, image, index]
        key = scene, numbers[image] if numbers else image, item.instance_id or item.gt_index
        found.append((key, item.T_camera_object[:3, 3]))
    return found


def _rows_of(answer: Answer, variant: str) -> Bool[np.ndarray, " n"]:
    of_image = np.array([name == variant for name in answer.opened.variants])
    return of_image[answer.scores[0].table.image_id]


def _all_rows(answer: Answer) -> Bool[np.ndarray, " n"]:
    """Return all rows, of paired variants those of the base: the others have the same keys."""
    if answer.opened.variants:
        return _rows_of(answer, answer.opened.variants[0])
    return np.ones(len(answer.scores[0].table), dtype=bool)
