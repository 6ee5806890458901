"""One observation of a scene by hand, in memory."""

from typing import cast

from warehouse_sim.api.observation import Observation
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.streamed import ObservedDataset
from warehouse_sim.generation.hand_made import Take, labelled_models


class Shot(Observation):
    """What ``Scene.render`` returns: all that ``ws.Dataset`` yields, before it is stored.

    Args:
        take: What was observed, and in which scene.
    """

    def __init__(self, take: Take) -> None:
        self.take = take
        """What ``ws.Writer`` stores."""
        dataset = ObservedDataset(take.observation, labelled_models(take))
        # It has all of a reader that an observation requires.
        self._reader = cast(DatasetReader, dataset)
        self._image = dataset.record

    def __repr__(self) -> str:
        camera, count = self.camera, len(self._image.targets)
        return f"<Shot {camera.width} x {camera.height} px, {count} object{'' if count == 1 else 's'}>"
