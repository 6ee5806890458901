"""What ``validate`` asks of BOP files; one file a subject, one function a check."""

from warehouse_sim.dataset.checks import poses
from warehouse_sim.dataset.checks.findings import NamedCheck
from warehouse_sim.dataset.formats.bop.checks import cameras, images, models, tables

CHECKS = (
    NamedCheck("bop files", tables.files),
    NamedCheck("bop models", models.models),
    NamedCheck("bop tables", tables.tables),
    NamedCheck("bop cameras", cameras.cameras),
    NamedCheck("bop coco", tables.coco),
    NamedCheck("bop targets", tables.targets),
    NamedCheck("bop images", images.images),
    NamedCheck("bop masks", images.masks),
    NamedCheck("bop poses on images", poses.projection),
)
