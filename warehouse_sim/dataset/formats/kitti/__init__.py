"""The KITTI object detection format, strict enough for OpenPCDet, mmdet3d, Open3D-ML, torchvision and the devkit."""

from collections.abc import Sequence
from pathlib import Path

from warehouse_sim.dataset.checks.findings import NamedCheck
from warehouse_sim.dataset.formats import DatasetWriter, FormatReader
from warehouse_sim.dataset.formats.kitti.layout import NAME
from warehouse_sim.dataset.formats.observation_files import require_depth_fits
from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.dataset.records import ImageRecord
from warehouse_sim.schema import LidarScan, MountedReading


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

    def reject(self, manifest: Manifest) -> None:
        """Reject views far below the horizon, a rig without LiDAR, long class names, too many frames, far depth."""
        from warehouse_sim.dataset.formats.kitti import layout

        layout.require_numbers(manifest)
        layout.require_words(manifest.targets)
        layout.require_views_near_horizon(manifest.contents)
        layout.require_lidar(manifest.contents)
        require_depth_fits(manifest.contents, layout.STEPS_PER_METRE, NAME)

    def writer(self, root: Path, manifest: Manifest) -> DatasetWriter:
        """Return a writer into ``root/kitti``."""
        from warehouse_sim.dataset.formats.kitti.writer import KittiWriter

        return KittiWriter(root, manifest)

    def reader(self, root: Path) -> FormatReader | None:
        """Return a reader of a folder without a manifest; None of one with it: what leans has no box, nothing a mask.

        To read the KITTI files of such a dataset as third-party ones are read, give the folder ``kitti`` in it.
        """
        if DatasetLayout(root).manifest.is_file():
            return None
        from warehouse_sim.dataset.formats.kitti.external import ExternalKittiReader, external_folder

        folder = external_folder(root)
        return None if folder is None else ExternalKittiReader(folder)

    def sweep(self, root: Path, manifest: Manifest, image: ImageRecord) -> MountedReading[LidarScan]:
        """Read the main LiDAR's sweep of an image of a dataset with a manifest."""
        from warehouse_sim.dataset.formats.kitti.external_frame import stored_sweep

        return stored_sweep(root, manifest, image)

    def recognises(self, root: Path) -> bool:
        """Return whether the folder, or ``kitti`` in it, holds frames of KITTI."""
        from warehouse_sim.dataset.formats.kitti.external import external_folder

        return external_folder(root) is not None


FORMAT = KittiFormat()
