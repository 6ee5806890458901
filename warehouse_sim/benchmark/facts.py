"""What a result says of its data and of who was evaluated."""

from collections.abc import Iterable, Iterator, Mapping, Sequence

from warehouse_sim.benchmark.entrants.entrant import ORACLE, Evaluated, Group
from warehouse_sim.benchmark.kept import weights_digest
from warehouse_sim.benchmark.result import DataFacts, EstimatorFacts
from warehouse_sim.benchmark.scored import Answer, Opened


def renderers(opened: Iterable[Opened]) -> tuple[str, ...]:
    """Return what rendered some datasets, each once."""
    manifests = [item.reader.manifest for item in opened]
    return tuple(dict.fromkeys(name for one in manifests if one is not None for name in one.renderers))


def data_facts(opened_ones: Mapping[str, Opened], answers: Sequence[Answer]) -> Iterator[DataFacts]:
    """Yield the facts of each dataset; what was counted stands in the first answer to it."""
    for name, opened in opened_ones.items():
        scores = next((answer.scores[0] for answer in answers if answer.opened is opened), None)
        found = opened.made
        yield DataFacts(
            name,
            found.recipe,
            found.recipe_sha256 or opened.reader.digest[:16],
            found.seed,
            len({image.scene_id for image in opened.reader.images(opened.split)}),
            len(opened.reader.images(opened.split)),
            0 if scores is None else len(scores.table),
            {} if scores is None else dict(scores.docking_left_out),
        )


def detector_facts(detectors: Sequence[str], groups: Sequence[Group]) -> Iterator[EstimatorFacts]:
    """Yield the facts of detectors that are no estimators."""
    for name in detectors:
        if name not in {group.name for group in groups}:
            digests = [weights_digest(part) for part in name.split("+")]
            yield EstimatorFacts(name, int(name != ORACLE), "+".join(item[:16] for item in digests if item))


def estimator_facts(groups: Sequence[Group]) -> Iterator[EstimatorFacts]:
    """Yield the facts of estimators."""
    for group in groups:
        evaluated = [item for item in group.members if isinstance(item, Evaluated)]
        digests = [weights_digest(name) for item in evaluated for name in item.way.parts]
        samples = group.facts.get("samples")
        yield EstimatorFacts(group.name, group.trainings, "+".join(item[:16] for item in digests if item), samples)
