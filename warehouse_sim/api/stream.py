"""Observations that are made while a network trains on them, and stored nowhere."""

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, cast

from warehouse_sim.api.arguments import checked
from warehouse_sim.api.generate import resolved, with_outputs
from warehouse_sim.api.observation import Observation
from warehouse_sim.api.recipe import Recipe
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.streamed import ObservedDataset
from warehouse_sim.generation import stream as made
from warehouse_sim.generation.plan import target_models
from warehouse_sim.generation.recipe import Recipe as ResolvedRecipe
from warehouse_sim.optional import require_extra
from warehouse_sim.ranges import Range

if TYPE_CHECKING:
    from warehouse_sim.learning.samples.torch_data import IterableData


class StreamedObservation(Observation):
    """An observation of a stream: all that ``ws.Dataset`` yields.

    Args:
        dataset: It with the geometries of its objects.
    """

    def __init__(self, dataset: ObservedDataset) -> None:
        # It has all of a reader that an observation requires.
        self._reader = cast(DatasetReader, dataset)
        self._image = dataset.record


@checked
def stream(
    recipe: str | Path | Recipe | ResolvedRecipe,
    sample: Callable[[Observation], Any] | None = None,
    *,
    seed: Annotated[int, Range(0, 2**63 - 1)] = 0,
    workers: Annotated[int, Range(1, 256)] = 1,
    start: Annotated[int, Range(0, 2**40)] = 0,
    scenes: Annotated[int, Range(1, 1_000_000)] | None = None,
    outputs: str | Sequence[str] = (),
) -> "IterableData":
    """Return the observations of a recipe as an ``IterableDataset`` of torch, made as they are taken.

    Number n is always the same, and equal to that of ``ws.generate`` with this seed. A single worker is a process of
    its own, which makes the next scene while what is here is trained on; at most two scenes a worker are in memory,
    and workers end with whoever iterates. Give workers to the stream and none to a loader.

    Example:
        >>> observations = ws.stream("smoke", lambda obs: obs.depth.max(), scenes=1)
        >>> [round(float(most), 1) > 0 for most in observations]
        [True, True]

    Args:
        recipe: Name of a shipped recipe, path of a .yaml file, or a ``ws.recipe``.
        sample: Turns an observation into what a batch is collated of; the observation itself by default.
        seed: Of the dataset that it would be.
        workers: Processes; a script calls this under ``if __name__ == "__main__":``.
        start: Observations to leave out at the beginning, to go on where a training stopped.
        scenes: Number of scenes; without end by default.
        outputs: What is made of an observation, as ``ws.generate`` takes it.

    Raises:
        UnknownNameError: There is no such recipe or output.
        MissingPackageError: torch is not installed.
    """
    require_extra("learn", "for ws.stream")
    from warehouse_sim.learning.samples.torch_data import IterableData

    wanted = with_outputs(resolved(recipe), (outputs,) if isinstance(outputs, str) else tuple(outputs))
    return IterableData(_Observations(wanted, seed, workers, start, scenes), sample or (lambda item: item))


class _Observations:
    """Observations of a recipe, from the same one on whenever they are iterated."""

    def __init__(self, recipe: ResolvedRecipe, seed: int, workers: int, start: int, scenes: int | None) -> None:
        self._recipe, self._seed, self._workers, self._start, self._scenes = recipe, seed, workers, start, scenes
        self._models = target_models(recipe)

    def __iter__(self) -> Iterator[StreamedObservation]:
        for item in made.stream(self._recipe, self._seed, self._workers, self._start, scenes=self._scenes, apart=True):
            yield StreamedObservation(ObservedDataset(item, self._models))
