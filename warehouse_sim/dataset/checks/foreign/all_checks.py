"""The checks of every dataset that others made."""

from warehouse_sim.dataset.checks.findings import NamedCheck
from warehouse_sim.dataset.checks.foreign import images, labels, masks, objects, poses

CHECKS = (
    NamedCheck("objects", objects.objects),
    NamedCheck("cameras", labels.cameras),
    NamedCheck("labels", labels.labels),
    NamedCheck("images", images.images),
    NamedCheck("masks", masks.masks),
    NamedCheck("poses on images", poses.poses),
)
