"""What sensors gave that are neither camera nor LiDAR: a row of the page's table for each of their channels."""

from collections.abc import Iterable, Mapping
from typing import Protocol

import numpy as np

from warehouse_sim.evaluation.report.numbers import NOTHING
from warehouse_sim.schema import MountedReading, Reading


class DescribedChannel(Protocol):
    """What the manifest says of one array."""

    @property
    def dtype(self) -> str:
        """As numpy writes it."""

    @property
    def shape(self) -> tuple[int | None, ...]:
        """Length along each axis; None where it differs from observation to observation."""

    @property
    def unit(self) -> str:
        """What the numbers are in; empty where the sensor does not say."""


class DescribedReading(Protocol):
    """What the manifest says of one sensor."""

    @property
    def kind(self) -> str:
        """Kind of the sensor."""

    @property
    def channels(self) -> Mapping[str, DescribedChannel]:
        """Its arrays by name."""


def reading_rows(
    described: Mapping[str, DescribedReading], readings: Iterable[Mapping[str, MountedReading[Reading]]]
) -> list[dict[str, str]]:
    """Return a row for each channel of each sensor, with the range of all its values.

    Args:
        described: Sensors by name, as the manifest has them.
        readings: What they gave at each observation, by the name of the sensor.
    """
    ranges: dict[tuple[str, str], tuple[float, float]] = {}
    for given in readings:
        for name, item in given.items():
            for channel, values in item.reading.channels.items():
                if values.size:
                    low, high = ranges.get((name, channel), (np.inf, -np.inf))
                    ranges[name, channel] = min(low, float(values.min())), max(high, float(values.max()))
    return [
        {
            "sensor": name,
            "kind": sensor.kind,
            "channel": channel,
            "shape": " x ".join("any" if length is None else str(length) for length in told.shape) or "one number",
            "type": np.dtype(told.dtype).name,
            "unit": told.unit or NOTHING,
            "range": "{:.4g} to {:.4g}".format(*ranges[name, channel]) if (name, channel) in ranges else NOTHING,
        }
        for name, sensor in described.items()
        for channel, told in sensor.channels.items()
    ]
