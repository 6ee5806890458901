"""All crops of a split, resident in memory as tensors: no decoding and no loader while training."""

import logging
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
import torch
from jaxtyping import Float, Int, Int32, UInt8
from torch import Tensor

from warehouse_sim.dataset.reader import DatasetReader, ImageRecord
from warehouse_sim.errors import TrainingError
from warehouse_sim.learning.crops import Crop, CropConfig, image_crops
from warehouse_sim.learning.objects import ObjectShape

log = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class CropSet:
    """K crops with room for P points each; rows beyond ``point_count`` are zero."""

    points: Float[Tensor, "k p 3"]
    """Camera frame (m), float32."""
    border_px: UInt8[Tensor, "k p"]
    pixel: Int32[Tensor, "k p"]
    point_count: Int[Tensor, " k"]
    rgb: UInt8[Tensor, "k s s 3"] | None
    class_index: Int[Tensor, " k"]
    diameter: Float[Tensor, " k"]
    """Metres."""
    T_camera_object: Float[Tensor, "k 4 4"]
    """Float64, so that metres keep their micrometres until the cloud is centred."""

    def __len__(self) -> int:
        return len(self.points)

    def to(self, device: torch.device) -> "CropSet":
        """Return the same crops on ``device``."""
        return CropSet(
            self.points.to(device),
            self.border_px.to(device),
            self.pixel.to(device),
            self.point_count.to(device),
            None if self.rgb is None else self.rgb.to(device),
            self.class_index.to(device),
            self.diameter.to(device),
            self.T_camera_object.to(device),
        )


def stack_crops(crops: Sequence[Crop], shapes: Sequence[ObjectShape], config: CropConfig) -> CropSet:
    """Return ``crops`` as tensors; their objects must be among ``shapes``, whose order numbers the classes."""
    index = {shape.obj_id: i for i, shape in enumerate(shapes)}
    classes = torch.tensor([index[crop.obj_id] for crop in crops])
    diameters = torch.tensor([shape.diameter for shape in shapes], dtype=torch.float32)
    room = config.stored_points
    points = np.zeros((len(crops), room, 3), dtype=np.float32)
    border, pixel = np.zeros((len(crops), room), dtype=np.uint8), np.zeros((len(crops), room), dtype=np.int32)
    for row, crop in enumerate(crops):
        count = len(crop.points)
        points[row, :count], border[row, :count], pixel[row, :count] = crop.points, crop.border_px, crop.pixel
    colours = [crop.rgb for crop in crops if crop.rgb is not None]
    return CropSet(
        torch.from_numpy(points),
        torch.from_numpy(border),
        torch.from_numpy(pixel),
        torch.tensor([len(crop.points) for crop in crops]),
        torch.from_numpy(np.stack(colours)) if config.side_px else None,
        classes,
        diameters[classes],
        torch.from_numpy(np.stack([crop.T_camera_object for crop in crops])),
    )


def read_crops(
    reader: DatasetReader,
    split: str,
    config: CropConfig,
    seed: int,
    workers: int,
    progress: Callable[[float], None] | None = None,
) -> list[Crop]:
    """Cut all wanted targets of a split, decoding images in ``workers`` threads.

    Raises:
        TrainingError: The split is missing or holds no usable target.
    """
    if split not in reader.splits:
        raise TrainingError(f"the dataset has no split {split!r}; it has: {', '.join(reader.splits) or '(none)'}")
    images = reader.images(split)

    def cut(image: ImageRecord) -> list[Crop]:
        return list(image_crops(reader, image, config, seed))

    crops: list[Crop] = []
    with ThreadPoolExecutor(workers) as pool:
        for done, found in enumerate(pool.map(cut, images), start=1):
            crops += found
            if progress:
                progress(done / len(images))
    if not crops:
        raise TrainingError(
            f"the split {split!r} has no target with visible fraction >= {config.min_visible_fraction} and "
            f"{config.min_points} depth readings in its {len(images)} images; generate more scenes"
        )
    log.info("%d crops from %d images of %s", len(crops), len(images), split)
    return crops
