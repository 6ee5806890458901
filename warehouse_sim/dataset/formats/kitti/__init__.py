"""The KITTI object detection format, strict enough for OpenPCDet, mmdet3d, Open3D-ML, torchvision and the devkit."""

from collections.abc import Sequence
from pathlib import Path

from warehouse_sim.dataset.checks.findings import NamedCheck
from warehouse_sim.dataset.formats import DatasetWriter
from warehouse_sim.dataset.formats.depth_limit import require_depth_fits
from warehouse_sim.dataset.formats.kitti.layout import NAME
from warehouse_sim.dataset.manifest import Manifest


class KittiFormat:
    """One file a frame of every kind: image, sweep, calibration, upright 3D boxes.

    Each part is imported on use.
    """

    name = NAME
    needs_level_camera = True

    @property
    def checks(self) -> Sequence[NamedCheck]:
        """Checks of its files, and of those of BOP against them."""
        from warehouse_sim.dataset.formats.kitti.checks import CHECKS

        return CHECKS

    def refuse(self, manifest: Manifest) -> None:
        """Refuse views far below the horizon, a leaning LiDAR or none, long class names, too many frames, far depth."""
        from warehouse_sim.dataset.formats.kitti import limits

        limits.require_numbers(manifest)
        limits.require_words(manifest.targets)
        limits.require_views_near_horizon(manifest.contents)
        limits.require_level_lidar(manifest)
        require_depth_fits(manifest.contents, limits.STEPS_PER_METRE, NAME)

    def writer(self, root: Path, manifest: Manifest) -> DatasetWriter:
        """Return a writer into ``root/kitti``."""
        from warehouse_sim.dataset.formats.kitti.writer import KittiWriter

        return KittiWriter(root, manifest)

    def reader(self, root: Path) -> None:
        """Return nothing: its labels have no masks, and boxes only for what stands."""

    def recognises(self, root: Path) -> bool:
        """Return that no folder is read."""
        return False


FORMAT = KittiFormat()
