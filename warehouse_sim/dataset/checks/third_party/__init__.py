"""The checks of every dataset made by third parties."""

from warehouse_sim.dataset.checks.findings import NamedCheck
from warehouse_sim.dataset.checks.subject import ThirdPartySubject
from warehouse_sim.dataset.checks.third_party import images, labels, poses
from warehouse_sim.dataset.formats import dataset_format, third_party_checks

_CHECKS = (
    NamedCheck("objects", labels.objects),
    NamedCheck("cameras", labels.cameras),
    NamedCheck("labels", labels.labels),
    NamedCheck("images", images.images),
    NamedCheck("masks", images.masks),
    NamedCheck("poses on images", poses.poses),
)


def checks_of(subject: ThirdPartySubject) -> tuple[NamedCheck, ...]:
    """Return what is requested of a dataset, in order: of every one, then of one in its format."""
    return (*_CHECKS, *third_party_checks(dataset_format(subject.format_name)))
