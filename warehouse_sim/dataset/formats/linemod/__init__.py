"""DenseFusion's LINEMOD layout, "LINEMOD_preprocessed": https://github.com/j96w/DenseFusion (datasets/linemod)."""

from collections.abc import Sequence
from pathlib import Path

from warehouse_sim.dataset.checks.findings import NamedCheck
from warehouse_sim.dataset.formats import DatasetWriter, FormatReader
from warehouse_sim.dataset.formats.linemod.layout import NAME
from warehouse_sim.dataset.formats.observation_files import MILLIMETRES, require_depth_fits
from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.errors import DatasetError


class LinemodFormat:
    """A folder of each object with frames in which it is labelled; tables in YAML."""

    name = NAME

    @property
    def checks(self) -> Sequence[NamedCheck]:
        """Checks of its files."""
        from warehouse_sim.dataset.formats.linemod.checks import CHECKS

        return CHECKS

    def reject(self, manifest: Manifest) -> None:
        """Reject depth beyond 16 bits and cameras with a lens."""
        require_depth_fits(manifest.contents, MILLIMETRES, NAME)
        if manifest.contents.distortion is not None:
            raise DatasetError(
                "LINEMOD: has no place for a lens, sensors.camera has one; remove it, or leave linemod out of --formats"
            )

    def writer(self, root: Path, manifest: Manifest) -> DatasetWriter:
        """Return a writer into ``root/linemod``."""
        from warehouse_sim.dataset.formats.linemod.writer import LinemodWriter

        return LinemodWriter(root, manifest)

    def reader(self, root: Path) -> FormatReader:
        """Return a reader of ``root/linemod``, or of a third-party folder."""
        from warehouse_sim.dataset.formats.linemod.layout import linemod_layout
        from warehouse_sim.dataset.formats.linemod.reader import LinemodReader, dataset_of, third_party_folder

        dataset = dataset_of(root)
        folder = linemod_layout(root).root if dataset is not None else third_party_folder(root) or root
        return LinemodReader(folder, dataset)

    def recognises(self, root: Path) -> bool:
        """Return whether the folder, or one in it, has ``data/01/gt.yml`` or the like."""
        from warehouse_sim.dataset.formats.linemod.reader import third_party_folder

        return third_party_folder(root) is not None


FORMAT = LinemodFormat()
