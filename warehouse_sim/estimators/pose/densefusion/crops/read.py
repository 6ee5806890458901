"""Read all wanted targets of a split, several images at once."""

import logging
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor

from warehouse_sim.dataset.reader import DatasetReader, ImageRecord
from warehouse_sim.errors import TrainingError
from warehouse_sim.estimators.pose.densefusion.crops.config import CropConfig
from warehouse_sim.estimators.pose.densefusion.crops.cut import Crop, image_crops

log = logging.getLogger(__name__)


def read_crops(
    reader: DatasetReader,
    split: str,
    config: CropConfig,
    seed: int,
    workers: int,
    progress: Callable[[float], None] | None = None,
) -> Iterator[list[Crop]]:
    """Yield the crops of each image of a split that has any, in their order, decoding in ``workers`` threads.

    Raises:
        TrainingError: The dataset has no such split.
    """
    if split not in reader.splits:
        raise TrainingError(f"{reader.root}: has no split {split!r}; it has: {', '.join(reader.splits) or '(none)'}")
    images = reader.images(split)

    def cut(image: ImageRecord) -> list[Crop]:
        return list(image_crops(reader, image, config, seed))

    count = 0
    with ThreadPoolExecutor(workers) as pool:
        for done, found in enumerate(pool.map(cut, images), start=1):
            count += len(found)
            if found:
                yield found
            if progress:
                progress(done / len(images))
    log.info("%d crops from %d images of %s", count, len(images), split)
