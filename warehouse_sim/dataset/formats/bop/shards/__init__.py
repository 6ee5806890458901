"""BOP shards ("bop-webdataset"): https://github.com/thodan/bop_toolkit/blob/master/docs/bop_datasets_format.md.

Our own few lines on the standard library write and read them: a tar archive needs no further package, and the
``webdataset`` package reads what they make.
"""

from collections.abc import Sequence
from pathlib import Path

from warehouse_sim.dataset.checks.findings import NamedCheck
from warehouse_sim.dataset.formats import DatasetWriter, FormatReader
from warehouse_sim.dataset.formats.bop.shards.layout import NAME
from warehouse_sim.dataset.formats.observation_files import MILLIMETRES, require_depth_fits
from warehouse_sim.dataset.manifest import Manifest


class ShardsFormat:
    """The same images and labels as the format ``bop``, in tar archives of a thousand images, to be streamed."""

    name = NAME

    @property
    def checks(self) -> Sequence[NamedCheck]:
        """Checks of its files."""
        from warehouse_sim.dataset.formats.bop.shards.checks import CHECKS

        return CHECKS

    def reject(self, manifest: Manifest) -> None:
        """Reject depth beyond 16 bits."""
        require_depth_fits(manifest.contents, MILLIMETRES, NAME)

    def writer(self, root: Path, manifest: Manifest) -> DatasetWriter:
        """Return a writer into ``root/bop_webdataset``."""
        from warehouse_sim.dataset.formats.bop.shards.writer import ShardsWriter

        return ShardsWriter(root, manifest)

    def reader(self, root: Path) -> FormatReader:
        """Return a reader of ``root/bop_webdataset``; third-party shards are read as the format ``bop``."""
        from warehouse_sim.dataset.formats.bop.shards.reader import ShardsReader

        return ShardsReader(root)

    def recognises(self, root: Path) -> bool:
        """Return no: third-party folders are the format ``bop``'s, whatever their images lie in."""
        return False


FORMAT = ShardsFormat()
