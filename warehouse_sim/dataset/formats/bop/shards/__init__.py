"""BOP shards ("bop-webdataset"): https://github.com/thodan/bop_toolkit/blob/master/docs/bop_datasets_format.md.

Our own few lines on the standard library write and read them: a tar archive needs no further package, and the
``webdataset`` package reads what they make.
"""

from pathlib import Path

from warehouse_sim.dataset.formats import FormatReader
from warehouse_sim.dataset.formats.bop.shards.layout import COMPACT, NAME
from warehouse_sim.dataset.formats.built_in import BuiltIn
from warehouse_sim.dataset.formats.observation_files import MILLIMETRES, require_depth_fits
from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.schema.outputs import Output


class ShardsFormat(BuiltIn):
    """The same images and labels as the format ``bop``, in tar archives of a thousand images, to be streamed.

    Exact, or compact: colours as JPEG, all else exact and small, to be kept.

    Third-party shards are the format ``bop``'s, as all of BOP's folders are, whatever their images lie in.
    """

    def reject(self, manifest: Manifest) -> None:
        """Reject depth beyond 16 bits."""
        require_depth_fits(manifest.contents, MILLIMETRES, self.name)

    def reader(self, root: Path) -> FormatReader:
        """Return a reader of ``root/bop_webdataset`` or ``root/bop_compact``."""
        from warehouse_sim.dataset.formats.bop.shards.coding import LOSSLESS, SMALL
        from warehouse_sim.dataset.formats.bop.shards.reader import ShardsReader

        return ShardsReader(root, SMALL if self.name == SMALL.name else LOSSLESS)


_HELD: tuple[Output, ...] = ("rgb", "depth", "masks", "amodal_masks", "poses", "clean")
FORMAT = ShardsFormat(
    NAME,
    checks_at="warehouse_sim.dataset.formats.bop.shards.checks:CHECKS",
    writer_at="warehouse_sim.dataset.formats.bop.shards.writer:ShardsWriter",
    needs=("poses",),
    holds=_HELD,
)
COMPACT_FORMAT = ShardsFormat(
    COMPACT,
    checks_at="warehouse_sim.dataset.formats.bop.shards.checks:COMPACT_CHECKS",
    writer_at="warehouse_sim.dataset.formats.bop.shards.writer:CompactWriter",
    needs=("poses",),
    holds=_HELD,
)
