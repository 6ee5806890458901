"""The BOP format, scenewise: https://github.com/thodan/bop_toolkit/blob/master/docs/bop_datasets_format.md."""

from collections.abc import Sequence
from pathlib import Path

from warehouse_sim.dataset.checks.findings import NamedCheck
from warehouse_sim.dataset.formats import DatasetWriter, FormatReader
from warehouse_sim.dataset.formats.bop.layout import NAME
from warehouse_sim.dataset.formats.observation_files import require_depth_fits
from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.dataset.manifest import Manifest


class BopFormat:
    """Images, masks and JSON tables, scene by scene; what training and scoring read.

    Each part is imported on use: to read a dataset needs no check, to write one no reader.
    """

    name = NAME

    @property
    def checks(self) -> Sequence[NamedCheck]:
        """Checks of its files."""
        from warehouse_sim.dataset.formats.bop.checks import CHECKS

        return CHECKS

    @property
    def third_party_checks(self) -> Sequence[NamedCheck]:
        """Checks of third-party folders only."""
        from warehouse_sim.dataset.formats.bop.checks.third_party import THIRD_PARTY_CHECKS

        return THIRD_PARTY_CHECKS

    def reject(self, manifest: Manifest) -> None:
        """Reject depth beyond 16 bits."""
        from warehouse_sim.dataset.formats.observation_files import MILLIMETRES

        require_depth_fits(manifest.contents, MILLIMETRES, NAME)

    def writer(self, root: Path, manifest: Manifest) -> DatasetWriter:
        """Return a writer into ``root/bop``."""
        from warehouse_sim.dataset.formats.bop.writer import BopWriter

        return BopWriter(root, manifest)

    def reader(self, root: Path) -> FormatReader:
        """Return a reader of ``root/bop``, or of a third-party folder."""
        if DatasetLayout(root).manifest.is_file():
            from warehouse_sim.dataset.formats.bop.reader import BopReader

            return BopReader(root)
        from warehouse_sim.dataset.formats.bop.external import ExternalReader, external_folder

        return ExternalReader(external_folder(root) or root)

    def recognises(self, root: Path) -> bool:
        """Return whether the folder, or ``bop`` in it, holds models of BOP."""
        from warehouse_sim.dataset.formats.bop.external import external_folder

        return external_folder(root) is not None


FORMAT = BopFormat()
