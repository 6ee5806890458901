"""A bare folder of colour, depth, intrinsics and masks, as anybody's camera leaves it; read, never written."""

from collections.abc import Sequence
from pathlib import Path
from typing import NoReturn

from warehouse_sim.dataset.checks.findings import NamedCheck
from warehouse_sim.dataset.formats import FormatReader
from warehouse_sim.dataset.formats.folder.files import looks_like
from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.errors import DatasetError

NAME = "folder"


class FolderFormat:
    """Images without poses: to look at and to predict on."""

    name = NAME
    checks: Sequence[NamedCheck] = ()
    needs = holds = ()

    def reject(self, manifest: Manifest) -> NoReturn:
        """Reject to be written: it has no place for labels."""
        raise DatasetError(f"{NAME}: bare folders are read only, they have no place for labels; choose another format")

    def writer(self, root: Path, manifest: Manifest) -> NoReturn:
        """Reject, as ``reject`` does."""
        self.reject(manifest)

    def reader(self, root: Path) -> FormatReader | None:
        """Return a reader of a third-party folder."""
        from warehouse_sim.dataset.formats.folder.reader import FolderReader

        return None if DatasetLayout(root).manifest.is_file() else FolderReader(root)

    def recognises(self, root: Path) -> bool:
        """Return whether the folder holds colour and depth images and intrinsics."""
        return looks_like(root)


FORMAT = FolderFormat()
