"""Targets of images as crops: points and a square window of each, cut, stacked as tensors, kept on disk."""

from warehouse_sim.estimators.pose.densefusion.crops.config import CropConfig
from warehouse_sim.estimators.pose.densefusion.crops.crop_set import CropSet, CropTable, stack_crops
from warehouse_sim.estimators.pose.densefusion.crops.cut import (
    Crop,
    CropLabel,
    cut_mask,
    image_crops,
    label_of,
    wanted_targets,
)

__all__ = [
    "Crop",
    "CropConfig",
    "CropLabel",
    "CropSet",
    "CropTable",
    "cut_mask",
    "image_crops",
    "label_of",
    "stack_crops",
    "wanted_targets",
]
