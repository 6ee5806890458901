"""What a sensor is: settings that can read."""

from typing import Protocol

import numpy as np

from warehouse_sim.schema import Reading
from warehouse_sim.sensors.view import SensorView


class Sensor(Protocol):
    """A frozen dataclass with the settings of a sensor; its fields, or its ``from_plain``, are what a recipe may set.

    Two class attributes may say more of it. With ``reads_light = False`` its reading does not depend on lights,
    exposure and emission: paired variants in another light or with other noise share it. With ``is_camera = True`` its
    frame is that of a camera, x right, y down, z forward; that of any other sensor is x forward, y left, z up.
    """

    def read(self, view: SensorView, rng: np.random.Generator) -> Reading:
        """Return what the sensor reads.

        Args:
            view: The moment, as this sensor sees it.
            rng: Source of all its errors; nothing else is random.
        """


def reads_light(sensor: Sensor) -> bool:
    """Return whether what a sensor reads may depend on light, exposure and noise of cameras; yes if silent."""
    return bool(getattr(sensor, "reads_light", True))


def is_camera(sensor: Sensor) -> bool:
    """Return whether a sensor's frame is that of a camera; no if silent."""
    return bool(getattr(sensor, "is_camera", False))
