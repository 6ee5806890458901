"""MCAP, the container of robots' recordings, with Foxglove's schemas: for playing a scene back in time."""

from collections.abc import Sequence
from pathlib import Path

from warehouse_sim.dataset.checks.findings import NamedCheck
from warehouse_sim.dataset.formats import DatasetWriter
from warehouse_sim.dataset.formats.mcap.layout import NAME
from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.optional import require_extra


class McapFormat:
    """One file a scene; it is for looking and playing back, not for training. Each part is imported on use."""

    name = NAME

    @property
    def checks(self) -> Sequence[NamedCheck]:
        """Checks of its files against the scene records."""
        from warehouse_sim.dataset.formats.mcap.checks import CHECKS

        return CHECKS

    def reject(self, manifest: Manifest) -> None:
        """Reject an installation without the packages that write it.

        Raises:
            MissingPackageError: The extra is not installed.
        """
        require_extra("mcap", "to write the format mcap")

    def writer(self, root: Path, manifest: Manifest) -> DatasetWriter:
        """Return a writer into ``root/mcap``."""
        from warehouse_sim.dataset.formats.mcap.writer import McapWriter

        return McapWriter(root, manifest)

    def reader(self, root: Path) -> None:
        """Return nothing: a recording has no masks."""

    def recognises(self, root: Path) -> bool:
        """Return that no folder is read."""
        return False


FORMAT = McapFormat()
