"""The KITTI object detection format, strict enough for OpenPCDet, mmdet3d, Open3D-ML, torchvision and the devkit."""

from pathlib import Path

from warehouse_sim.dataset.formats import FormatReader
from warehouse_sim.dataset.formats.built_in import BuiltIn
from warehouse_sim.dataset.formats.kitti import layout
from warehouse_sim.dataset.formats.observation_files import require_depth_fits
from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.dataset.manifest import Manifest
from warehouse_sim.dataset.records import ImageRecord
from warehouse_sim.errors import DatasetError
from warehouse_sim.schema import LidarScan, MountedReading


class KittiFormat(BuiltIn):
    """One file a frame of every kind: image, sweep, calibration, upright 3D boxes."""

    needs_level_camera = True

    def reject(self, manifest: Manifest) -> None:
        """Reject views far below the horizon, a rig without LiDAR, long class names, too many frames, far depth."""
        for problem in layout.misfits(manifest):
            raise DatasetError(f"KITTI: {problem}, or leave kitti out of --formats")
        require_depth_fits(manifest.contents, layout.STEPS_PER_METRE, self.name)

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


FORMAT = KittiFormat(
    layout.NAME,
    checks_at="warehouse_sim.dataset.formats.kitti.checks:CHECKS",
    writer_at="warehouse_sim.dataset.formats.kitti.writer:KittiWriter",
    needs=("rgb", "depth", "poses", "lidar"),
    holds=("rgb", "depth", "poses", "lidar", "right", "clean"),
)
