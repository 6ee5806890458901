"""How much of what must not be taken is rejected, at the score that accepts 95 of 100 pallets; kept hall by hall."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from warehouse_sim.benchmark.ahead import make_ahead
from warehouse_sim.benchmark.entrants.entrant import Evaluated, Group, Oracle
from warehouse_sim.benchmark.kept import folder_for
from warehouse_sim.benchmark.negatives.things import KINDS, MODEL, PALLET
from warehouse_sim.benchmark.negatives.trials import accepted, pallet_info, trials
from warehouse_sim.benchmark.result import LeftOut
from warehouse_sim.benchmark.rows.row import Place, Row
from warehouse_sim.benchmark.rows.scores import mean_row
from warehouse_sim.benchmark.suite import ConditionConfig, NegativesConfig
from warehouse_sim.config import to_mapping
from warehouse_sim.dataset.files.json_file import read_json, write_json
from warehouse_sim.errors import WarehouseSimError
from warehouse_sim.estimators.api import PoseEstimator
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.output import make_folder
from warehouse_sim.render import open_renderer

ALL = "all negatives"
RECALL = 0.95
"""Of pallets, which decides from which score on an estimate is accepted."""
_LEAST_SCORE = 1e-9

Score = tuple[str, float, float]
"""Kind of a trial, and what ``accepted`` says of it."""


@dataclass(frozen=True)
class Hall:
    """One hall in which estimators are shown pallets and negatives; can be pickled."""

    recipe: str
    seed: int
    index: int
    places: int
    members: tuple[Evaluated, ...]
    out: Path
    """Folder of the benchmark."""

    @property
    def is_made(self) -> bool:
        """Whether all of them have seen it."""
        return all(self.file(member).is_file() for member in self.members)

    def make(self) -> None:
        """Show it to those who have not seen it."""
        missing = [member for member in self.members if not self.file(member).is_file()]
        found: dict[Evaluated, list[Score]] = {member: [] for member in missing}
        with open_renderer("raster") as renderer:
            for trial in trials(self.recipe, self.seed, self.index, self.places, renderer):
                for member in missing:
                    found[member].append((trial.kind, *accepted(trial, opened(member))))
        for member, scores in found.items():
            make_folder(self.file(member).parent)
            write_json(self.file(member), scores)

    def scores(self, member: Evaluated) -> list[Score]:
        """Return what one of them made of it."""
        return [(str(kind), float(right), float(wrong)) for kind, right, wrong in read_json(self.file(member))]

    def file(self, member: Evaluated) -> Path:
        """Return where that is kept."""
        inputs: dict[str, Any] = member.inputs(ConditionConfig("")) | {
            "recipe": to_mapping(load_recipe(self.recipe)),
            "seed": self.seed,
            "places": self.places,
        }
        return folder_for(self.out / "negatives" / self.recipe, member.name, inputs) / f"{self.index:06d}.json"


@lru_cache(maxsize=16)
def opened(member: Evaluated) -> PoseEstimator:
    """Return an estimator that knows the pallet, and that nothing else is there.

    Raises:
        WarehouseSimError: It cannot be opened.
    """
    way = member.way
    return replace(way, config=replace(way.config, objects=(MODEL,))).open(pallet_info())


def negative_rows(
    groups: Sequence[Group],
    config: NegativesConfig,
    out: Path,
    workers: int,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> tuple[list[Row], list[LeftOut]]:
    """Return what fraction of pallets is accepted and of each kind of negative rejected, and who cannot be evaluated.

    Args:
        groups: Who is evaluated; of several trainings the first. Others than estimators and the ground truth are not.
        config: Which halls.
        out: Folder of the benchmark.
        workers: Processes.
        progress: Called with the halls that are done and how many there are.
    """
    known, left_out = list[Group](), list[LeftOut]()
    for group in groups if config.recipes else ():
        member = group.members[0]
        try:
            if isinstance(member, Evaluated):
                opened(member)
        except WarehouseSimError as problem:
            left_out.append(LeftOut(group.name, "negatives", str(problem)))
            continue
        known += [group] if isinstance(member, Evaluated | Oracle) else []
    members = tuple(member for group in known if isinstance(member := group.members[0], Evaluated))
    halls = [
        Hall(recipe, config.seed, index, config.places, members, out)
        for recipe in config.recipes
        for index in range(config.scenes)
    ]
    make_ahead(halls, workers, progress)
    for number, hall in enumerate(halls):
        if not hall.is_made:
            hall.make()
        progress(number + 1, len(halls))
    return [row for group in known for row in _rows(group, halls)], left_out


def _rows(group: Group, halls: Sequence[Hall]) -> Iterator[Row]:
    member = group.members[0]
    found = [
        (number, hall.recipe, score)
        for number, hall in enumerate(halls)
        for score in (hall.scores(member) if isinstance(member, Evaluated) else _of_the_truth(hall.places))
    ]
    least = threshold([right for _, _, (kind, right, _) in found if kind == PALLET])
    for recipe in dict.fromkeys(hall.recipe for hall in halls):
        mine = [(number, score) for number, name, score in found if name == recipe]
        for label, kinds in {ALL: KINDS[1:], **{kind: (kind,) for kind in KINDS}}.items():
            chosen = [(number, score) for number, score in mine if score[0] in kinds]
            values = [(right >= least) if kind == PALLET else (wrong < least) for _, (kind, right, wrong) in chosen]
            metric = "accepted" if label == PALLET else "rejected"
            place: Place = "negatives", group.name, recipe, label, metric
            scenes = np.array([number for number, _ in chosen])
            yield mean_row(place, np.array(values, dtype=float), scenes, group.trainings)


def threshold(right: Sequence[float]) -> float:
    """Return the score from which on an estimate is accepted, by the best right estimate of each pallet."""
    return max(float(np.quantile(right, 1.0 - RECALL, method="lower")), _LEAST_SCORE)


def _of_the_truth(places: int) -> list[Score]:
    return [(kind, float(kind == PALLET), 0.0) for _ in range(places) for kind in KINDS]
