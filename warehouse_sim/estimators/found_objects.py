"""Between detections of an image and those that files of detections hold."""

from collections.abc import Sequence
from pathlib import Path

from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.results.detections import FoundObject, is_label_folder, read_labels, read_results
from warehouse_sim.errors import DatasetError
from warehouse_sim.estimators.rgbd_image import Detection, RgbdImage


def found_object(item: Detection, image: RgbdImage) -> FoundObject:
    """Return a detection of an image as files hold it."""
    edges = None
    if item.box_xyxy is not None:
        left, top, right, bottom = item.box_xyxy
        # A box holds pixel centres, which lie half a pixel within its edges.
        edges = (left + 0.5, top + 0.5, right + 0.5, bottom + 0.5)
    return FoundObject(image.scene_id, image.image_id, item.score, item.class_name, item.model, edges, item.mask)


def detection(item: FoundObject) -> Detection:
    """Return what a file holds as a detection."""
    box = None
    if item.edges is not None:
        left, top, right, bottom = item.edges
        box = (left - 0.5, top - 0.5, right - 0.5, bottom - 0.5)
    return Detection(item.mask, item.model, item.score, box_xyxy=box, class_name=item.class_name)


class StoredDetections:
    """What a file says of the images of a dataset; a stage like a detector.

    Args:
        path: COCO's or BOP's results, or a folder of YOLO's label files.
        reader: The dataset.

    Raises:
        DatasetError: The file is malformed, or was made for another dataset.
    """

    def __init__(self, path: Path, reader: DatasetReader) -> None:
        self._by_image: dict[tuple[int, int], list[Detection]] = {}
        parts = [_read(path, reader, split) for split in reader.splits]
        for item in (item for part in parts for item in part):
            self._by_image.setdefault((item.scene_id, item.image_id), []).append(detection(item))

    def detect(self, image: RgbdImage) -> Sequence[Detection]:
        """Return what the file says of an image."""
        return self._by_image.get((image.scene_id, image.image_id), [])


def is_detections(path: str | Path) -> bool:
    """Return whether a path is a file of detections or a folder of them."""
    found = Path(path)
    return found.is_file() or (found.is_dir() and is_label_folder(found))


def _read(path: Path, reader: DatasetReader, split: str) -> list[FoundObject]:
    if path.is_file():
        return read_results(path, reader, split)
    try:
        return read_labels(path, reader, split)
    except DatasetError:
        # Mostly a folder holds one split; it is wrong only where it holds none.
        if any(path.rglob("*_*.txt")) or any(path.rglob("[0-9]*.txt")):
            return []
        raise
