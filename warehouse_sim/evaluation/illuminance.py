"""How brightly each ground truth was lit, from the scene records of the dataset."""

from collections.abc import Sequence

from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.dataset.reader import DatasetReader, ImageRecord
from warehouse_sim.dataset.stored.scene_record import read_scene_record

Place = tuple[int, int, int]
"""Scene id, image id, instance id."""


def target_illuminance(reader: DatasetReader, images: Sequence[ImageRecord]) -> dict[Place, float]:
    """Return the mean illuminance (lx) of the visible surface of each target that the dataset holds it for.

    A dataset made elsewhere has no scene records; its targets are left out.
    """
    layout, found = DatasetLayout(reader.root), dict[Place, float]()
    for scene_id in sorted({image.scene_id for image in images}):
        if not layout.scene_record(scene_id).is_file():
            continue
        for image_id, observation in enumerate(read_scene_record(reader.root, scene_id).observations):
            for target in observation.targets:
                if target.illuminance is not None:
                    found[scene_id, image_id, target.instance_id] = target.illuminance
    return found
