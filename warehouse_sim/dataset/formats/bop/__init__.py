"""The BOP format, scenewise: https://github.com/thodan/bop_toolkit/blob/master/docs/bop_datasets_format.md."""

from pathlib import Path

from warehouse_sim.dataset.formats import FormatReader
from warehouse_sim.dataset.formats.bop.layout import NAME
from warehouse_sim.dataset.formats.built_in import BuiltIn
from warehouse_sim.dataset.formats.observation_files import MILLIMETRES, require_depth_fits
from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.schema.outputs import CODINGS


class BopFormat(BuiltIn):
    """Images, masks and JSON tables, scene by scene; what training and scoring read."""

    def reject(self, manifest: Manifest) -> None:
        """Reject depth beyond 16 bits."""
        require_depth_fits(manifest.contents, MILLIMETRES, NAME)

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


FORMAT = BopFormat(
    NAME,
    checks_at="warehouse_sim.dataset.formats.bop.checks:CHECKS",
    writer_at="warehouse_sim.dataset.formats.bop.writer:BopWriter",
    needs=("poses",),
    holds=("rgb", "depth", "masks", "amodal_masks", "poses", "clean", *CODINGS),
    third_party_checks_at="warehouse_sim.dataset.formats.bop.checks.third_party:THIRD_PARTY_CHECKS",
)
