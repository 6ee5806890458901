"""BOP shards ("bop-webdataset"): https://github.com/thodan/bop_toolkit/blob/master/docs/bop_datasets_format.md.

Our own few lines on the standard library write and read them: a tar archive needs no further package, and the
``webdataset`` package reads what they make.
"""

import re
from dataclasses import dataclass
from pathlib import Path

from warehouse_sim.dataset.formats import FormatReader
from warehouse_sim.dataset.formats.bop import COUNTED, BopLayout
from warehouse_sim.dataset.formats.built_in import BuiltIn
from warehouse_sim.dataset.formats.observation_files import MILLIMETRES
from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.schema.outputs import Output

NAME, COMPACT = "bop_webdataset", "bop_compact"
"""Of the formats and of their folders in a dataset."""
MOST_IMAGES = 1000
"""Of one shard, as bop_toolkit's own converter has it."""
KEY_TO_SHARD = "key_to_shard.json"
SHARD = re.compile(r"shard-(\d{6})\.tar")
MEMBER = re.compile(r"(\d{1,9})_(\d{1,9})\.([a-z]+(?:_[a-z]+)?\.[a-z]{2,4})")
"""Scene, image and kind of a member, such as ``000003_000017.mask_visib.json``."""


@dataclass(frozen=True)
class ShardsLayout:
    """Paths of BOP shards; meshes, camera and targets lie as in the scenewise layout."""

    root: Path

    @property
    def bop(self) -> BopLayout:
        """The paths of what is no image."""
        return BopLayout(self.root)

    def split(self, name: str) -> Path:
        """Return the folder of the shards of a split."""
        return self.root / name

    def shard(self, split: str, number: int) -> Path:
        """Return a shard."""
        return self.split(split) / f"shard-{number:06d}.tar"

    def key_to_shard(self, split: str) -> Path:
        """Return the table of which shard holds an image."""
        return self.split(split) / KEY_TO_SHARD

    @property
    def parts(self) -> Path:
        """Folder of scenes that are not in a shard yet; gone when the dataset is complete."""
        return self.root / "parts"

    def part(self, scene_id: int) -> Path:
        """Return the images of one scene on their way into shards."""
        return self.parts / f"{scene_id:06d}.tar"


def shards_layout(root: Path, name: str = NAME) -> ShardsLayout:
    """Return the paths of the shards of a dataset in the format ``name``."""
    return ShardsLayout(DatasetLayout(root).format_folder(name))


class ShardsFormat(BuiltIn):
    """The same images and labels as the format ``bop``, in tar archives of a thousand images, to be streamed.

    Exact, or compact: colours as JPEG, all else exact and small, to be kept.

    Third-party shards are the format ``bop``'s, as all of BOP's folders are, whatever their images lie in.
    """

    needs_meshes = True

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
    counts=COUNTED,
    steps_per_metre=MILLIMETRES,
)
COMPACT_FORMAT = ShardsFormat(
    COMPACT,
    checks_at="warehouse_sim.dataset.formats.bop.shards.checks:COMPACT_CHECKS",
    writer_at="warehouse_sim.dataset.formats.bop.shards.writer:CompactWriter",
    needs=("poses",),
    holds=_HELD,
    counts=COUNTED,
    steps_per_metre=MILLIMETRES,
)
