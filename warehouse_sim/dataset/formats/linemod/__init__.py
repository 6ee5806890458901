"""DenseFusion's LINEMOD layout, "LINEMOD_preprocessed": https://github.com/j96w/DenseFusion (datasets/linemod)."""

from pathlib import Path

from warehouse_sim.dataset.formats import FormatReader
from warehouse_sim.dataset.formats.built_in import BuiltIn
from warehouse_sim.dataset.formats.linemod.layout import NAME, NO_LENS, linemod_layout
from warehouse_sim.dataset.formats.observation_files import MILLIMETRES, require_depth_fits
from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.errors import DatasetError


class LinemodFormat(BuiltIn):
    """A folder of each object with frames in which it is labelled; tables in YAML."""

    def reject(self, manifest: Manifest) -> None:
        """Reject depth beyond 16 bits and cameras with a lens."""
        require_depth_fits(manifest.contents, MILLIMETRES, NAME)
        if manifest.contents.distortion is not None:
            raise DatasetError(NO_LENS)

    def reader(self, root: Path) -> FormatReader:
        """Return a reader of ``root/linemod``, or of a third-party folder."""
        from warehouse_sim.dataset.formats.linemod.reader import LinemodReader, third_party_folder

        if DatasetLayout(root).manifest.is_file():
            return LinemodReader(linemod_layout(root).root, root)
        return LinemodReader(third_party_folder(root) or root, None)

    def recognises(self, root: Path) -> bool:
        """Return whether the folder, or one in it, has ``data/01/gt.yml`` or the like."""
        from warehouse_sim.dataset.formats.linemod.reader import third_party_folder

        return third_party_folder(root) is not None


FORMAT = LinemodFormat(
    NAME,
    checks_at="warehouse_sim.dataset.formats.linemod.checks:CHECKS",
    writer_at="warehouse_sim.dataset.formats.linemod.writer:LinemodWriter",
    needs=("rgb", "depth", "masks", "poses"),
    holds=("rgb", "depth", "masks", "poses"),
)
