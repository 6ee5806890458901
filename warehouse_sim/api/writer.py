"""Scenes by hand become a dataset folder."""

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import Self

from warehouse_sim.api.arguments import checked
from warehouse_sim.api.scene import Shot
from warehouse_sim.config import from_mapping
from warehouse_sim.dataset.discard import discard_dataset
from warehouse_sim.dataset.split import SplitConfig
from warehouse_sim.errors import DatasetError, InputError
from warehouse_sim.generation.hand_made_dataset import HandMadeDataset
from warehouse_sim.one_writer import is_lock, one_writer


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
