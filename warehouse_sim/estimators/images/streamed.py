"""Images of observations that no file holds: scaled when they come, drawn from a window, dropped when it has passed."""

from collections.abc import Mapping

from jaxtyping import Int
from torch import Tensor

from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.dataset.streamed import ObservedImage
from warehouse_sim.estimators.images.rows import SMALL_ARRAYS, image_rows
from warehouse_sim.estimators.images.settings import ImageConfig
from warehouse_sim.learning.samples.array_store import Arrays
from warehouse_sim.learning.samples.joined import joined_alike
from warehouse_sim.learning.samples.order import GroupedOrder
from warehouse_sim.learning.samples.stream_window import Arrivals, seed_since, window_of
from warehouse_sim.learning.settings import StreamConfig
from warehouse_sim.learning.trainable import OpenStream
from warehouse_sim.schema import Observation

_MOST_GROUPS, _MOST_IMAGES = 1 << 10, 1 << 21
"""More canvases, and images, than a window has: what came at a step is numbered from the step times these."""


class StreamedImages:
    """The images of a stream's window and the order in which steps draw them; both depend on the step alone.

    A step's images are of one canvas. While the window stays, steps draw as from a dataset that holds what it shows.

    Args:
        open_stream: Gives the observations.
        stream: Which stream, and how much of it is kept.
        images: What is read of an observation.
        objects: Objects of the data, for faces.
        batch: Images a step.
        seed: Decides the order.
    """

    def __init__(
        self,
        open_stream: OpenStream | None,
        stream: StreamConfig,
        images: ImageConfig,
        objects: Mapping[int, ObjectInfo],
        batch: int,
        seed: int,
    ) -> None:
        self._images, self._objects, self._batch, self._seed = images, objects, batch, seed
        self._arrivals = Arrivals(window_of(open_stream, stream, self._rows), self._gathered)

    def first(self) -> list[Arrays]:
        """Return the images of the first step's window, those of one canvas together."""
        return self._arrivals.at(0)[1][0]

    def indices(self, step: int) -> Int[Tensor, " b"]:
        """Return the numbers of one step's images."""
        arrived, (_, order) = self._arrivals.at(step)
        return order.indices(step - arrived) + arrived * _MOST_IMAGES

    def group_of(self, index: Int[Tensor, " b"]) -> tuple[int, Int[Tensor, " b"]]:
        """Return the group of a step's images, which this holds by its number, and their rows in it."""
        arrived = int(index[0]) // _MOST_IMAGES
        group, rows = self._arrivals.since(arrived)[1].group_of(index - arrived * _MOST_IMAGES)
        return arrived * _MOST_GROUPS + group, rows

    def __getitem__(self, group: int) -> Arrays:
        """Return the images of a group of this step or the one before."""
        arrived, number = divmod(group, _MOST_GROUPS)
        return self._arrivals.since(arrived)[0][number]

    def _gathered(self, rows: list[Arrays], arrived: int) -> tuple[list[Arrays], GroupedOrder]:
        parts = joined_alike(rows, SMALL_ARRAYS)
        sizes = [len(part["labels"]) for part in parts]
        return parts, GroupedOrder(sizes, self._batch, seed_since(self._seed, arrived))

    def _rows(self, observation: Observation) -> Arrays:
        image = ObservedAmong(observation, self._objects)
        return image_rows(image, image.record, self._images)


class ObservedAmong(ObservedImage):
    """An observation with the objects of the data that it is trained beside.

    Args:
        observation: With depth as it is stored.
        objects: By obj_id.
    """

    has_depth = True

    def __init__(self, observation: Observation, objects: Mapping[int, ObjectInfo]) -> None:
        super().__init__(observation)
        self.objects = objects
