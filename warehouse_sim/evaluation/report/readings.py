"""What sensors gave that are neither camera nor LiDAR: a row of the page's table for each of their channels."""

from collections.abc import Iterable, Mapping

import numpy as np

from warehouse_sim.dataset.stored.contents import ReadingContents
from warehouse_sim.evaluation.report.numbers import NOTHING
from warehouse_sim.schema import MountedReading, Reading


def reading_rows(
    contents: Mapping[str, ReadingContents], readings: Iterable[Mapping[str, MountedReading[Reading]]]
) -> list[dict[str, str]]:
    """Return a row for each channel of each sensor, with the range of all its values.

    Args:
        contents: Sensors by name, as the manifest has them.
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
            "shape": " x ".join("any" if length is None else str(length) for length in array.shape) or "one number",
            "type": np.dtype(array.dtype).name,
            "unit": array.unit or NOTHING,
            "range": "{:.4g} to {:.4g}".format(*ranges[name, channel]) if (name, channel) in ranges else NOTHING,
        }
        for name, sensor in contents.items()
        for channel, array in sensor.channels.items()
    ]
