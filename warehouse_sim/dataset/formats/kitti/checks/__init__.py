"""Checks of KITTI files; one file a subject, one function a check."""

from warehouse_sim.dataset.checks.findings import NamedCheck
from warehouse_sim.dataset.formats.kitti.checks import agreement, files, labels, points

CHECKS = (
    NamedCheck("kitti files", files.files),
    NamedCheck("kitti labels", labels.labels),
    NamedCheck("kitti labels on images", labels.shown),
    NamedCheck("kitti calib", files.calib),
    NamedCheck("kitti images", files.images),
    NamedCheck("kitti points in boxes", points.points),
    NamedCheck("kitti points on depth", labels.points_on_depth),
    NamedCheck("kitti sweeps", points.sweeps),
    NamedCheck("kitti and bop labels", agreement.labels, agreement.OTHER),
    NamedCheck("kitti and bop images", agreement.images, agreement.OTHER),
)
