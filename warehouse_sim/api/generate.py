"""A recipe becomes a dataset folder."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

from warehouse_sim.api.arguments import checked
from warehouse_sim.api.dataset import Dataset
from warehouse_sim.api.recipe import Recipe
from warehouse_sim.generation.generate import generate as make_dataset
from warehouse_sim.generation.plan import GenerateConfig, default_formats
from warehouse_sim.generation.recipe import Recipe as ResolvedRecipe
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.ranges import Range


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
    skip_failed: bool = False,
    backend: str = "raster",
    backend_options: Mapping[str, Any] | None = None,
) -> Dataset:
    """Sample, settle, render and label scenes; the same bytes as ``warehouse-sim generate`` writes.

    Example:
        >>> data = ws.generate("smoke", "made", scenes=1, formats="bop")
        >>> len(data), data[0].rgb.shape
        (2, (370, 1224, 3))

    Args:
        recipe: Name of a shipped recipe, path of a .yaml file, or a ``ws.recipe``.
        out: Folder to make; it must be empty unless ``resume``.
        scenes: Number of scenes; the recipe's own number by default.
        seed: Of the dataset; the same seed gives the same bytes, whatever the number of workers.
        formats: Formats to write, see ``warehouse-sim list``; by default KITTI and BOP, or BOP where there is no LiDAR.
        workers: Processes. With more than one, a script calls this under ``if __name__ == "__main__":``.
        resume: Go on with a run that was interrupted.
        skip_failed: Do without scenes that failed twice.
        backend: What renders.
        backend_options: Its options by name.

    Returns:
        The dataset.

    Raises:
        UnknownNameError: There is no such recipe, format or backend.
        DatasetError: The folder holds something else, or a format cannot hold the data.
        SettleError: A scene does not come to rest in any attempt.
    """
    resolved = _resolved(recipe)
    named = (formats,) if isinstance(formats, str) else tuple(formats)
    config = GenerateConfig(
        scenes=scenes,
        seed=seed,
        formats=named or default_formats(resolved),
        backend=backend,
        backend_options=dict(backend_options or {}),
        workers=workers,
        resume=resume,
        skip_failed=skip_failed,
    )
    make_dataset(resolved, Path(out), config)
    return Dataset(out)


def _resolved(recipe: str | Path | Recipe | ResolvedRecipe) -> ResolvedRecipe:
    if isinstance(recipe, Recipe):
        return recipe.resolved
    return recipe if isinstance(recipe, ResolvedRecipe) else load_recipe(str(recipe))
