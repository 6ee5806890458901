"""MCAP, the container of robots' recordings, with Foxglove's schemas: for playing a scene back in time."""

from warehouse_sim.dataset.formats.built_in import BuiltIn
from warehouse_sim.dataset.formats.mcap.layout import NAME
from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.optional import require_extra


class McapFormat(BuiltIn):
    """One file a scene; it is for looking and playing back, not for training: a recording has no masks."""

    def reject(self, manifest: Manifest) -> None:
        """Reject an installation without the packages that write it.

        Raises:
            MissingPackageError: The extra is not installed.
        """
        require_extra("mcap", "to write the format mcap")


FORMAT = McapFormat(
    NAME,
    checks_at="warehouse_sim.dataset.formats.mcap.checks:CHECKS",
    writer_at="warehouse_sim.dataset.formats.mcap.writer:McapWriter",
    needs=("rgb", "depth", "poses"),
    holds=("rgb", "depth", "poses", "lidar", "right"),
)
