"""What is done with whole dataset folders: check one, write one in further formats."""

from collections.abc import Callable, Sequence
from pathlib import Path

from warehouse_sim.api.arguments import checked
from warehouse_sim.api.dataset import Dataset
from warehouse_sim.dataset.checks.findings import Check
from warehouse_sim.dataset.convert.run import convert as write_formats
from warehouse_sim.dataset.validate import validate as run_checks
from warehouse_sim.errors import DatasetError, InputError


class Checks(tuple[Check, ...]):
    """The outcomes of all checks of a dataset, in order; true if all hold."""

    @property
    def ok(self) -> bool:
        """Whether all checks hold."""
        return all(check.ok for check in self)

    def __bool__(self) -> bool:
        return self.ok

    def __repr__(self) -> str:
        words = ("--  " if not check.checked else "ok  " if check.ok else "FAIL" for check in self)
        return "\n".join(f"{word}  {check.name}: {check.detail}" for word, check in zip(words, self, strict=True))


@checked
def validate(data: Dataset | str | Path, progress: Callable[[float, str], None] | None = None) -> Checks:
    """Check a dataset folder from its manifest down to single pixels.

    Example:
        >>> checks = ws.validate("out")
        >>> checks.ok, checks[0].name
        (True, 'manifest')

    Args:
        data: The dataset, of this package or a third-party one.
        progress: Called with the fraction that is done and the name of the check that runs.

    Returns:
        One ``Check`` each, with ``name``, ``ok``, ``detail``; the whole is true if all hold.

    Raises:
        DatasetError: There is no such folder.
    """
    root = data.path if isinstance(data, Dataset) else Path(data)
    if not root.is_dir():
        raise DatasetError(f"{root}: is not a folder; name the folder of a dataset, or generate one")
    return Checks(run_checks(root, progress or (lambda fraction, note: None)))


@checked
def convert(
    data: Dataset | str | Path,
    out: str | Path,
    formats: str | Sequence[str],
    resume: bool = False,
    overwrite: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> Path:
    """Write a dataset in other formats; images are linked where the disk can, not copied.

    Example:
        >>> len(ws.Dataset(ws.convert("out", "out-linemod", "linemod")).objects)
        1

    Args:
        data: The dataset, of this package or a third-party one.
        out: Folder to make.
        formats: Formats to write, such as "coco" or ["bop", "coco"].
        resume: Go on with a run that was interrupted; finished scenes are kept.
        overwrite: Delete the dataset that is there.
        progress: Called with the number of finished scenes and of all scenes.

    Returns:
        The folder.

    Raises:
        UnknownNameError: There is no such format.
        DatasetError: The dataset cannot be read, or a format cannot hold it.
        OutputError: The folder cannot be written.
    """
    root, made = data.path if isinstance(data, Dataset) else Path(data), Path(out)
    if overwrite and resume:
        raise InputError("overwrite begins again and resume goes on; give one of them")
    names = [formats] if isinstance(formats, str) else list(formats)
    write_formats(root, made, names, resume, progress or (lambda done, total: None), overwrite)
    return made
