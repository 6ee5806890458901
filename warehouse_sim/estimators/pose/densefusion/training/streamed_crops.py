"""Crops of observations that no file holds: cut when they come, dropped when the window of the stream has passed."""

from collections.abc import Callable, Iterator, Sequence

import torch
from jaxtyping import Int
from torch import Tensor

from warehouse_sim.dataset.observed_image import ObservedImage
from warehouse_sim.errors import TrainingError
from warehouse_sim.estimators.pose.densefusion.crops.config import CropConfig
from warehouse_sim.estimators.pose.densefusion.crops.crop_set import (
    CropSet,
    CropTable,
    join_tables,
    stack_arrays,
    table_of,
)
from warehouse_sim.estimators.pose.densefusion.crops.cut import image_crops
from warehouse_sim.estimators.pose.densefusion.crops.store import CUT_SEED
from warehouse_sim.estimators.pose.densefusion.objects import ObjectShape
from warehouse_sim.estimators.pose.densefusion.settings import Balance
from warehouse_sim.estimators.pose.densefusion.training.balance import sampling_weights
from warehouse_sim.learning.stream_settings import StreamConfig
from warehouse_sim.learning.stream_window import StreamWindow
from warehouse_sim.schema import Observation

OpenStream = Callable[[StreamConfig, int], Iterator[Observation]]
"""Gives the observations of a stream from a number on."""
_ROOM = 1 << 20
"""More crops than an image has: the crop at place p of observation n has the number n * _ROOM + p."""


class StreamedCrops:
    """The crops of a stream's window, by numbers that stay the same while the window moves.

    Args:
        open_stream: Gives the observations.
        config: Which stream, and how much of it is kept.
        crop: How to cut.
        shapes: Objects that are trained on, whose order numbers the classes; crops of others are left out.
    """

    def __init__(
        self, open_stream: OpenStream, config: StreamConfig, crop: CropConfig, shapes: Sequence[ObjectShape]
    ) -> None:
        self._crop, self._shapes = crop, tuple(shapes)
        self._device = torch.device("cpu")
        self._window = StreamWindow(lambda start: open_stream(config, start), self._cut, config.window, config.fresh)
        self._held: dict[int, CropTable] = {}

    def window(self, step: int) -> tuple[Int[Tensor, " k"], CropSet]:
        """Return numbers and crops of the window of a step.

        Raises:
            TrainingError: None of its observations shows an object that is trained on.
        """
        first = self._window.first(step)
        found = {first + place: table for place, table in enumerate(self._window.at(step)) if table is not None}
        if not found:
            raise TrainingError(
                f"none of the stream's observations from {first} on, in a window, shows an object of the data that is "
                "visible enough to train on; take the recipe that the data was made from, or a larger stream.window"
            )
        self._held = found
        numbers = [torch.arange(len(table.points)) + number * _ROOM for number, table in found.items()]
        return torch.cat(numbers), CropSet(list(found.values()))

    def rows(self, index: Int[Tensor, " b"]) -> CropTable:
        """Return copies of the crops of these numbers, which are in the window, in this order."""
        parts = [self._held[number // _ROOM].rows(torch.tensor([number % _ROOM])) for number in index.cpu().tolist()]
        return join_tables(parts).to(self._device)

    def to(self, device: torch.device) -> "StreamedCrops":
        """Give what is drawn on ``device``; the window stays in the memory of the processor."""
        self._device = device
        return self

    def _cut(self, observation: Observation) -> CropTable | None:
        image = ObservedImage(observation)
        known = {shape.obj_id for shape in self._shapes}
        crops = [crop for crop in image_crops(image, image.record, self._crop, CUT_SEED) if crop.obj_id in known]
        return table_of(stack_arrays(crops, self._crop), self._shapes) if crops else None


class StreamOrder:
    """The samples of each step: drawn from the window, with replacement, by a stream of numbers of the step's own.

    Args:
        crops: Where from.
        batch: Samples a step.
        seed: Decides which.
        classes: Class name of each object.
        balance: What is drawn equally often, of what the window holds.
    """

    def __init__(self, crops: StreamedCrops, batch: int, seed: int, classes: Sequence[str], balance: Balance) -> None:
        self._crops, self._batch, self._seed = crops, batch, seed
        self._classes, self._balance = tuple(classes), balance

    def indices(self, step: int) -> Int[Tensor, " b"]:
        """Return the numbers of one step's samples."""
        numbers, window = self._crops.window(step)
        weights = sampling_weights(window.class_index, self._classes, self._balance)
        generator = torch.Generator().manual_seed(self._seed * 1_000_003 + step)
        even = torch.ones(len(numbers)) if weights is None else weights
        return numbers[torch.multinomial(even, self._batch, replacement=True, generator=generator)]
