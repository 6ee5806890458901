"""Point clouds as files that every viewer opens: PLY and PCD, with poses and calibration beside."""

from collections.abc import Sequence
from pathlib import Path

from warehouse_sim.dataset.checks.findings import NamedCheck
from warehouse_sim.dataset.formats import DatasetWriter
from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.dataset.records import ImageRecord
from warehouse_sim.schema import LidarScan, MountedReading
from warehouse_sim.schema.outputs import Output


class CloudFormat:
    """One cloud a sensor and observation, in the sensor's own frame; it is for looking and measuring, not for training.

    Args:
        name: "ply" or "pcd", which is the ending of its files, too.
    """

    needs: tuple[Output, ...] = ("rgb", "depth", "poses")
    holds: tuple[Output, ...] = (*needs, "lidar")

    def __init__(self, name: str) -> None:
        self._name = name

    @property
    def name(self) -> str:
        """As in ``--formats``."""
        return self._name

    @property
    def checks(self) -> Sequence[NamedCheck]:
        """Checks of its files against the scene records."""
        from warehouse_sim.dataset.formats.clouds.checks import checks_of

        return checks_of(self._name)

    def reject(self, manifest: Manifest) -> None:
        """Reject nothing: each sensor of a rig has a cloud or none."""

    def writer(self, root: Path, manifest: Manifest) -> DatasetWriter:
        """Return a writer into the folder of the format's name."""
        from warehouse_sim.dataset.formats.clouds.writer import CloudWriter

        return CloudWriter(root, manifest, self._name)

    def reader(self, root: Path) -> None:
        """Return nothing: clouds have neither images nor masks."""

    def sweep(self, root: Path, manifest: Manifest, image: ImageRecord) -> MountedReading[LidarScan] | None:
        """Read the main LiDAR's sweep of an image of a dataset with a manifest; None where the rig has none."""
        from warehouse_sim.dataset.formats.clouds.layout import stored_sweep

        return stored_sweep(root, self._name, image)

    def recognises(self, root: Path) -> bool:
        """Return that no folder is read."""
        return False


PLY, PCD = CloudFormat("ply"), CloudFormat("pcd")
"""Stanford's format of polygons, and that of the Point Cloud Library."""
