"""A recipe, or scenes by hand, become a dataset folder."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from types import TracebackType
from typing import Annotated, Any, Self

from warehouse_sim.api.arguments import checked
from warehouse_sim.api.dataset import Dataset
from warehouse_sim.api.recipe import Recipe
from warehouse_sim.api.scene import Shot
from warehouse_sim.config import from_mapping
from warehouse_sim.dataset.discard import discard_dataset
from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.dataset.split import SplitConfig
from warehouse_sim.errors import DatasetError, InputError
from warehouse_sim.generation.estimate import Estimate, estimate
from warehouse_sim.generation.generate import generate as make_dataset
from warehouse_sim.generation.hand_made.dataset import HandMadeDataset
from warehouse_sim.generation.plan import GenerateConfig, default_formats
from warehouse_sim.generation.recipe import Recipe as ResolvedRecipe
from warehouse_sim.generation.recipe import changed, load_recipe
from warehouse_sim.one_writer import is_lock, one_writer
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
    outputs: str | Sequence[str] = (),
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
        outputs: What to hold of an observation, such as ``["rgb", "depth", "masks", "poses"]``, in place of what the
            recipe wants (docs/dataset.md).
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
    named = (outputs,) if isinstance(outputs, str) else tuple(outputs)
    write_dataset(with_outputs(resolved(recipe), named), Path(out), config, progress)
    return Dataset(out)


def with_outputs(recipe: ResolvedRecipe, outputs: Sequence[str]) -> ResolvedRecipe:
    """Return a recipe that wants these outputs; itself where none is named.

    Raises:
        RecipeError: There is no such output, it cannot be made with the rig, or poses are not among them.
    """
    return changed(recipe, {"sensors": {"outputs": list(outputs)}}) if outputs else recipe


def plan_cost(recipe: ResolvedRecipe, config: GenerateConfig, out: Path) -> Estimate:
    """Return what ``write_dataset`` with the same arguments would cost; nothing is written to ``out``."""
    return estimate(recipe, complete(recipe, config), out)


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
    return make_dataset(recipe, out, complete(recipe, config), progress or (lambda done, total: None))


def complete(recipe: ResolvedRecipe, config: GenerateConfig) -> GenerateConfig:
    """Return a config that names its formats, with the options of its backend checked."""
    checked_options(config.backend, config.backend_options)
    return config if config.formats else replace(config, formats=default_formats(recipe))


def resolved(recipe: str | Path | Recipe | ResolvedRecipe) -> ResolvedRecipe:
    """Return the recipe that a name, a path or a ``ws.recipe`` stands for."""
    if isinstance(recipe, Recipe):
        return recipe.resolved
    return recipe if isinstance(recipe, ResolvedRecipe) else load_recipe(str(recipe))


class Writer:
    """Store scenes that were put together or changed in Python, with labels, splits, card and manifest.

    The manifest comes last: a folder without one is incomplete.

    Example:
        >>> with ws.Writer("crates", formats=["bop", "coco"]) as out:
        ...     for seed in range(2):
        ...         scene = ws.Scene(seed=seed)
        ...         scene.add("epal1", x=0.2 * seed)
        ...         out.write(scene.settle().render(ws.Camera("kitti"), views=2))
        >>> len(ws.Dataset("crates")), all(check.ok for check in ws.validate("crates"))
        (4, True)

    Args:
        out: Folder to make; it must be empty.
        formats: Formats to write.
        name: Of the dataset; by default that of the folder.
        objects: Names of objects, or files, that will get labels in scenes after the first; only for yolo.
        split: Fractions of the scenes for train, val and test; 0.7, 0.1 and 0.2 by default.
        overwrite: Delete the dataset that is there.

    Raises:
        UnknownNameError: There is no such format.
        DatasetError: The folder is not empty, or a format cannot hold scenes by hand.
        OutputError: Another writer holds the folder.
    """

    @checked
    def __init__(
        self,
        out: str | Path,
        formats: str | Sequence[str] = ("bop", "coco"),
        *,
        name: str | None = None,
        objects: Sequence[str] = (),
        split: Mapping[str, float] | None = None,
        overwrite: bool = False,
    ) -> None:
        self.path = Path(out)
        """The folder."""
        named = (formats,) if isinstance(formats, str) else tuple(formats)
        if not named or len(set(named)) < len(named):
            raise InputError(f"Writer: formats must name one at least, and each once, found {list(named)}")
        fractions = from_mapping(SplitConfig, dict(split or {}), "Writer: split")
        self._dataset = HandMadeDataset(self.path, named, name or self.path.resolve().name, tuple(objects), fractions)
        self._overwrite = overwrite
        self._open: ExitStack | None = None

    def __repr__(self) -> str:
        return f"<Writer of {str(self.path)!r}: {self._dataset.scenes} scenes>"

    def __enter__(self) -> Self:
        if self._open is not None or self._dataset.scenes:
            raise InputError(f"Writer: {self.path} has been opened already; make another ws.Writer")
        if self.path.exists() and not self.path.is_dir():
            raise DatasetError(f"{self.path}: is a file; choose another folder")
        with ExitStack() as stack:
            stack.enter_context(one_writer(self.path))
            if self._overwrite:
                discard_dataset(self.path)
            elif not all(is_lock(path) for path in self.path.iterdir()):
                raise DatasetError(f"{self.path}: the folder is not empty; choose another one, or write overwrite=True")
            self._open = stack.pop_all()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, problem: BaseException | None, trace: TracebackType | None
    ) -> None:
        assert self._open is not None
        with self._open:
            self._open = None
            if kind is None:
                self._dataset.finish()

    @checked
    def write(self, shots: Shot | Sequence[Shot]) -> None:
        """Store one scene.

        Args:
            shots: What was rendered of it: one shot, or several; as many as of every other scene.

        Raises:
            DatasetError: They are of several scenes, of other sensors, or of another number.
        """
        if self._open is None:
            raise InputError("Writer: is not open; write within its block: with ws.Writer(...) as out: out.write(...)")
        several = [shots] if isinstance(shots, Shot) else list(shots)
        if not several:
            raise InputError("Writer.write: there is no shot; render at least one")
        self._dataset.write([shot.take for shot in several])
