"""Checks of BOP files; one file a subject, one function a check."""

from warehouse_sim.dataset.checks import poses
from warehouse_sim.dataset.checks.findings import NamedCheck
from warehouse_sim.dataset.formats.bop.checks import images, tables

CHECKS = (
    NamedCheck("bop files", tables.files),
    NamedCheck("bop models", tables.models),
    NamedCheck("bop tables", tables.tables),
    NamedCheck("bop cameras", tables.cameras),
    NamedCheck("bop coco", tables.coco, needs=(("masks",),)),
    NamedCheck("bop targets", tables.targets),
    NamedCheck("bop images", images.images, needs=(("rgb",), ("depth",), ("clean",))),
    NamedCheck("bop masks", images.masks, needs=(("masks",), ("amodal_masks",))),
    NamedCheck("bop exact images", images.exact_images, needs=(("normals",), ("object_coordinates",), ("class_mask",))),
    NamedCheck("bop poses on images", poses.projection, needs=poses.PROJECTION_NEEDS),
)
