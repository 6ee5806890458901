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
    stack_arrays,
    table_of,
)
from warehouse_sim.estimators.pose.densefusion.crops.cut import image_crops
from warehouse_sim.estimators.pose.densefusion.objects import ObjectShape
from warehouse_sim.estimators.pose.densefusion.settings import Balance, CropConfig, TrainConfig
from warehouse_sim.learning.samples.order import SampleOrder
from warehouse_sim.learning.samples.stream_window import Arrivals, seed_since, window_of
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


_MOST_CROPS = 1 << 31
"""More crops than a window shows: what came at a step is numbered from the step times this."""


class StreamedCrops:
    """The crops of a stream's window and the order in which steps draw them; both depend on the step alone.

    Args:
        open_stream: Gives the observations.
        config: Settings, which name the stream.
        crop: How to cut.
        shapes: Objects that are trained on, whose order numbers the classes; crops of others are left out.
        classes: Class name of each object.
    """

    def __init__(
        self,
        open_stream: OpenStream | None,
        config: TrainConfig,
        crop: CropConfig,
        shapes: Sequence[ObjectShape],
        classes: Sequence[str],
    ) -> None:
        self._config, self._crop, self._shapes, self._classes = config, crop, tuple(shapes), tuple(classes)
        self._device = torch.device("cpu")
        self._arrivals = Arrivals(window_of(open_stream, config.stream, self._cut), self._gathered)

    def window(self, step: int) -> CropSet:
        """Return the crops of the window of a step.

        Raises:
            TrainingError: None of its observations shows an object that is trained on.
        """
        return self._arrivals.at(step)[1][0]

    def indices(self, step: int) -> Int[Tensor, " b"]:
        """Return the numbers of one step's crops."""
        arrived, (_, order) = self._arrivals.at(step)
        return order.indices(step - arrived) + arrived * _MOST_CROPS

    def rows(self, index: Int[Tensor, " b"]) -> CropTable:
        """Return copies of the crops of these numbers, of this step or the one before, in this order."""
        arrived = int(index[0]) // _MOST_CROPS
        return self._arrivals.since(arrived)[0].rows(index.cpu() - arrived * _MOST_CROPS).to(self._device)

    def to(self, device: torch.device) -> "StreamedCrops":
        """Give what is drawn on ``device``; the window stays in the memory of the processor."""
        self._device = device
        return self

    def _gathered(self, shown: list[CropTable | None], arrived: int) -> tuple[CropSet, SampleOrder]:
        tables = [table for table in shown if table is not None]
        if not tables:
            raise TrainingError(
                f"none of the stream's observations that step {arrived} sees shows an object of the data that is "
                "visible enough to train on; take the recipe that the data was made from, or a larger stream.window"
            )
        crops, seed = CropSet(tables), seed_since(self._config.seed, arrived)
        weights = sampling_weights(crops.class_index, self._classes, self._config.balance)
        return crops, SampleOrder(len(crops), self._config.batch, seed, weights)

    def _cut(self, observation: Observation) -> CropTable | None:
        image = ObservedImage(observation)
        known = {shape.obj_id for shape in self._shapes}
        crops = [crop for crop in image_crops(image, image.record, self._crop, CUT_SEED) if crop.obj_id in known]
        return table_of(stack_arrays(crops, self._crop), self._shapes) if crops else None
