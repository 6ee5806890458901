"""A recipe becomes a dataset folder."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

from warehouse_sim.api.arguments import checked
from warehouse_sim.api.dataset import Dataset
from warehouse_sim.api.recipe import Recipe
from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.errors import InputError
from warehouse_sim.generation.generate import generate as make_dataset
from warehouse_sim.generation.plan import GenerateConfig, default_formats
from warehouse_sim.generation.recipe import Recipe as ResolvedRecipe
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.ranges import Range
from warehouse_sim.render import backend_options as checked_options


@checked
def generate(
    recipe: str | Path | Recipe | ResolvedRecipe,
    out: str | Path,
    scenes: Annotated[int, Range(1, 1_000_000)] | None = None,
    *,
    seed: Annotated[int, Range(0, 2**63 - 1)] = 0,
    formats: str | Sequence[str] = (),
    workers: Annotated[int, Range(1, 256)] = 1,
    resume: bool = False,
    overwrite: bool = False,
    skip_failed: bool = False,
    backend: str = "raster",
    backend_options: Mapping[str, Any] | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Dataset:
    """Sample, settle, render and label scenes; the same bytes as ``warehouse-sim generate`` writes.

    Example:
        >>> data = ws.generate("smoke", "made", scenes=1, formats="bop")
        >>> len(data), data[0].rgb.shape
        (2, (370, 1224, 3))

    Args:
        recipe: Name of a shipped recipe, path of a .yaml file, or a ``ws.recipe``.
        out: Folder to make; it must be empty unless ``resume`` or ``overwrite``.
        scenes: Number of scenes; the recipe's own number by default.
        seed: Of the dataset; the same seed gives the same bytes, whatever the number of workers.
        formats: Formats to write, see ``warehouse-sim list``; by default KITTI and BOP, or BOP where there is no LiDAR.
        workers: Processes. With more than one, a script calls this under ``if __name__ == "__main__":``.
        resume: Go on with a run that was interrupted.
        overwrite: Delete the dataset that is there.
        skip_failed: Do without scenes that failed twice.
        backend: What renders.
        backend_options: Its options by name.
        progress: Called with the number of finished scenes and of all scenes.

    Returns:
        The dataset.

    Raises:
        UnknownNameError: There is no such recipe, format or backend.
        DatasetError: The folder holds something else, or a format cannot hold the data.
        SettleError: A scene does not come to rest in any attempt.
    """
    config = GenerateConfig(
        scenes=scenes,
        seed=seed,
        formats=(formats,) if isinstance(formats, str) else tuple(formats),
        backend=backend,
        backend_options=dict(backend_options or {}),
        workers=workers,
        resume=resume,
        overwrite=overwrite,
        skip_failed=skip_failed,
    )
    write_dataset(_resolved(recipe), Path(out), config, progress)
    return Dataset(out)


def write_dataset(
    recipe: ResolvedRecipe,
    out: Path,
    config: GenerateConfig,
    progress: Callable[[int, int], None] | None = None,
) -> Manifest:
    """Do what ``generate`` says, for a shard of a dataset, too, which ``Dataset`` does not open.

    Args:
        recipe: As the strict reader has it.
        out: As in ``generate``.
        config: All that decides the dataset; without formats, those that ``generate`` writes by default.
        progress: As in ``generate``.
    """
    if config.overwrite and config.resume:
        raise InputError("overwrite begins again and resume goes on; give one of them")
    complete = config if config.formats else replace(config, formats=default_formats(recipe))
    checked_options(config.backend, config.backend_options)
    return make_dataset(recipe, out, complete, progress or (lambda done, total: None))


def _resolved(recipe: str | Path | Recipe | ResolvedRecipe) -> ResolvedRecipe:
    if isinstance(recipe, Recipe):
        return recipe.resolved
    return recipe if isinstance(recipe, ResolvedRecipe) else load_recipe(str(recipe))
