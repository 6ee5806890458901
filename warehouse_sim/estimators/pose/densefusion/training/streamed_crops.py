"""Crops of observations that no file holds: cut when they come, drawn in balance, dropped when a window has passed."""

from collections.abc import Sequence

import torch
from jaxtyping import Float, Int
from torch import Tensor

from warehouse_sim.dataset.streamed import ObservedImage
from warehouse_sim.errors import TrainingError
from warehouse_sim.estimators.pose.densefusion.crops.crop_set import (
    CUT_SEED,
    CropSet,
    CropTable,
    join_tables,
    stack_arrays,
    table_of,
)
from warehouse_sim.estimators.pose.densefusion.crops.cut import image_crops
from warehouse_sim.estimators.pose.densefusion.objects import ObjectShape
from warehouse_sim.estimators.pose.densefusion.settings import Balance, CropConfig
from warehouse_sim.learning.samples.order import SampleOrder
from warehouse_sim.learning.samples.stream_window import seed_since, window_of
from warehouse_sim.learning.settings import StreamConfig
from warehouse_sim.learning.trainable import OpenStream
from warehouse_sim.schema import Observation


def sampling_weights(
    object_index: Int[Tensor, " k"], classes: Sequence[str], balance: Balance
) -> Float[Tensor, " k"] | None:
    """Return how often each crop is drawn; the mean is 1. None stands for equal weights.

    Args:
        object_index: Object of each crop, 0 to the number of ``classes``.
        classes: Class name of each object.
        balance: What is to be drawn equally often. Within a class, an object is drawn with the square root of its
            number of crops, which lies between equal objects and equal crops.
    """
    if balance == "crops":
        return None
    counts = torch.bincount(object_index, minlength=len(classes)).double()
    fractions = torch.zeros_like(counts)
    for name in set(classes):
        members = torch.tensor([other == name for other in classes])
        if balance == "objects":
            fractions[members] = (counts[members] > 0).double()
        elif counts[members].sum() > 0:
            fractions[members] = counts[members].sqrt() / counts[members].sqrt().sum()
    weights = (fractions / counts.clamp(min=1.0))[object_index]
    return (weights / weights.mean()).float()


_MOST = 1 << 20
"""More crops than an image has: the crop at place p of observation n has the number n * _MOST + p."""


class StreamedCrops:
    """The crops of a stream's window, by numbers that stay the same while the window moves.

    Args:
        open_stream: Gives the observations.
        config: Which stream, and how much of it is kept.
        crop: How to cut.
        shapes: Objects that are trained on, whose order numbers the classes; crops of others are left out.
    """

    def __init__(
        self, open_stream: OpenStream | None, config: StreamConfig, crop: CropConfig, shapes: Sequence[ObjectShape]
    ) -> None:
        self._crop, self._shapes = crop, tuple(shapes)
        self._device = torch.device("cpu")
        self._window = window_of(open_stream, config, self._cut)
        self._held: dict[int, CropTable] = {}
        self._shown: tuple[int, Int[Tensor, " k"], CropSet] | None = None

    def arrived(self, step: int) -> int:
        """Return the step at which the window came to where it is at a step."""
        return self._window.arrived(step)

    def window(self, step: int) -> tuple[Int[Tensor, " k"], CropSet]:
        """Return numbers and crops of the window of a step.

        Raises:
            TrainingError: None of its observations shows an object that is trained on.
        """
        first, tables = self._window.first(step), self._window.at(step)
        if self._shown is None or self._shown[0] != first:
            self._held = {first + place: table for place, table in enumerate(tables) if table is not None}
            self._shown = (first, *self._numbered(first))
        return self._shown[1:]

    def _numbered(self, first: int) -> tuple[Int[Tensor, " k"], CropSet]:
        if not self._held:
            raise TrainingError(
                f"none of the stream's observations from {first} on, in a window, shows an object of the data that is "
                "visible enough to train on; take the recipe that the data was made from, or a larger stream.window"
            )
        numbers = [torch.arange(len(table.points)) + number * _MOST for number, table in self._held.items()]
        return torch.cat(numbers), CropSet(list(self._held.values()))

    def rows(self, index: Int[Tensor, " b"]) -> CropTable:
        """Return copies of the crops of these numbers, which are in the window, in this order."""
        parts = [self._held[number // _MOST].rows(torch.tensor([number % _MOST])) for number in index.cpu().tolist()]
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
    """The samples of each step: while the window stays, those of a dataset that holds what it shows.

    Args:
        crops: Where from.
        batch: Samples a step.
        seed: Decides the order.
        classes: Class name of each object.
        balance: What is drawn equally often, of what the window holds.
    """

    def __init__(self, crops: StreamedCrops, batch: int, seed: int, classes: Sequence[str], balance: Balance) -> None:
        self._crops, self._batch, self._seed = crops, batch, seed
        self._classes, self._balance = tuple(classes), balance
        self._order: tuple[int, SampleOrder] | None = None

    def indices(self, step: int) -> Int[Tensor, " b"]:
        """Return the numbers of one step's samples."""
        (numbers, window), arrived = self._crops.window(step), self._crops.arrived(step)
        if self._order is None or self._order[0] != arrived:
            weights = sampling_weights(window.class_index, self._classes, self._balance)
            self._order = (arrived, SampleOrder(len(numbers), self._batch, seed_since(self._seed, arrived), weights))
        return numbers[self._order[1].indices(step - arrived)]
