"""Elements of MJCF with all digits of their numbers: MuJoCo's own writer keeps six, 0.1 mm in a hall of 100 m."""

from collections.abc import Iterable
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from warehouse_sim.geometry.pose import Transform, quat_wxyz_from_matrix

Value = str | bool | float | Iterable[float]
"""What an attribute can be; numbers are SI, angles rad."""


def add(parent: Element, tag: str, **attributes: Value | None) -> Element:
    """Append an element with those of ``attributes`` that are not None; a trailing _ of a name is dropped."""
    return SubElement(parent, tag, {k.rstrip("_"): text(v) for k, v in attributes.items() if v is not None})


def text(value: Value) -> str:
    """Return the value as MJCF spells it."""
    if isinstance(value, str):
        return value
    if isinstance(value, bool | np.bool_):
        return "true" if value else "false"
    numbers = [value] if isinstance(value, int | float | np.number) else list(value)
    return " ".join(f"{float(number):.12g}" for number in numbers)


def frame(T: Transform) -> dict[str, Value]:
    """Return the attributes of a pose; no turn is left out."""
    rotation = T[:3, :3]
    turned = {} if np.array_equal(rotation, np.eye(3)) else {"quat": quat_wxyz_from_matrix(rotation)}
    return {"pos": T[:3, 3], **turned}
