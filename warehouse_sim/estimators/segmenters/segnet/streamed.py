"""Boxes of observations that no file holds: cut when they come, drawn from a window, dropped when it has passed."""

from collections.abc import Mapping

from jaxtyping import Int
from torch import Tensor

from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.errors import TrainingError
from warehouse_sim.estimators.images.streamed import ObservedAmong
from warehouse_sim.estimators.segmenters.segnet.rows import target_rows, wanted_rows
from warehouse_sim.estimators.segmenters.segnet.settings import BoxCropConfig, SegmenterConfig
from warehouse_sim.estimators.segmenters.segnet.task import BoxRows
from warehouse_sim.learning.samples.array_store import Arrays
from warehouse_sim.learning.samples.order import SampleOrder
from warehouse_sim.learning.samples.stream_window import Arrivals, StreamWindow, seed_since
from warehouse_sim.learning.trainable import OpenStream
from warehouse_sim.schema import Observation

_MOST_BOXES = 1 << 31
"""More boxes than a window shows: what came at a step is numbered from the step times this."""


class StreamedBoxes:
    """The boxes of a stream's window and the order in which steps draw them; both depend on the step alone.

    Args:
        open_stream: Gives the observations.
        config: Settings, which name the stream.
        crop: How boxes are cut out.
        objects: Objects of the data.

    Raises:
        TrainingError: Nothing opens the stream.
    """

    def __init__(
        self,
        open_stream: OpenStream | None,
        config: SegmenterConfig,
        crop: BoxCropConfig,
        objects: Mapping[int, ObjectInfo],
    ) -> None:
        if open_stream is None:
            raise TrainingError(f"nothing here opens the stream of {config.stream.recipe}: give train() one")
        opened, stream = open_stream, config.stream
        self._config, self._crop, self._objects = config, crop, objects
        window = StreamWindow(lambda start: opened(stream, start), self._rows, stream.window, stream.fresh)
        self._arrivals = Arrivals(window, self._gathered)

    def indices(self, step: int) -> Int[Tensor, " b"]:
        """Return the numbers of one step's boxes."""
        arrived, (_, order) = self._arrivals.at(step)
        return order.indices(step - arrived) + arrived * _MOST_BOXES

    def at(self, index: int) -> tuple[Arrays, int]:
        """Return the arrays that hold a box of this step or the one before, and its row there."""
        arrived, row = divmod(index, _MOST_BOXES)
        return self._arrivals.since(arrived)[0].at(row)

    def _gathered(self, shown: list[Arrays | None], arrived: int) -> tuple[BoxRows, SampleOrder]:
        parts = [part for part in shown if part is not None]
        rows = BoxRows(parts, [wanted_rows(part["facts"], self._objects, self._config) for part in parts])
        if not len(rows):
            raise TrainingError("none of the stream's observations, in a window, shows a target well enough")
        return rows, SampleOrder(len(rows), self._config.batch, seed_since(self._config.seed, arrived))

    def _rows(self, observation: Observation) -> Arrays | None:
        image = ObservedAmong(observation, self._objects)
        return target_rows(image, image.record, self._crop)
