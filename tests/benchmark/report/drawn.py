"""Read a chart back from its SVG by its ticks and paths, with none of the code that drew it."""

import math
import re
from collections.abc import Callable
from xml.etree import ElementTree

Point = tuple[float, float]
_NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e-?\d+)?")


class Drawn:
    """A chart: where its ticks are, and the points of each named element in pixels."""

    def __init__(self, svg: str, prefix: str = "") -> None:
        self.root = ElementTree.fromstring(svg)
        self.named = {node.attrib["id"].removeprefix(prefix): node for node in self.root.iter() if "id" in node.attrib}
        self.x_ticks, self.y_ticks = (self._ticks(f"{letter}tick_", letter) for letter in "xy")

    def _ticks(self, start: str, axis: str) -> list[tuple[str, float]]:
        found = []
        for name, node in self.named.items():
            if name.startswith(start):
                (mark,) = [part for part in node.iter() if part.tag.endswith("}use")]
                words = [part.text or "" for part in node.iter() if part.tag.endswith("}text")]
                found.append((" ".join(words), float(mark.attrib[axis])))
        return found

    def marks(self, name: str) -> list[Point]:
        """Return where the marks of an element are (px)."""
        return [
            (float(part.attrib["x"]), float(part.attrib["y"]))
            for part in self.named[name].iter()
            if part.tag.endswith("}use")
        ]

    def paths(self, name: str) -> list[list[Point]]:
        """Return the corners of the paths of an element (px), without definitions of marks."""
        node = self.named[name]
        own = [part for part in node.iter() if part.tag.endswith("}path") and "id" not in part.attrib]
        return [_corners(part.attrib["d"]) for part in own]

    def x(self, logarithmic: bool = False) -> Callable[[float], float]:
        """Return what turns a pixel into what the horizontal axis shows there, by two of its ticks."""
        return _scale(self.x_ticks, logarithmic)

    def y(self) -> Callable[[float], float]:
        """Return the same of the vertical axis."""
        return _scale(self.y_ticks, False)

    def level(self, y_px: float) -> str:
        """Return the name of the nearest vertical tick."""
        return min(self.y_ticks, key=lambda tick: abs(tick[1] - y_px))[0]

    def category(self, x_px: float) -> str:
        """Return the name of the nearest horizontal tick."""
        return min(self.x_ticks, key=lambda tick: abs(tick[1] - x_px))[0]

    def is_hollow(self, name: str) -> bool:
        """Return whether the mark of an element is not filled."""
        (mark,) = [part for part in self.named[name].iter() if part.tag.endswith("}use")]
        return "fill-opacity: 0" in mark.attrib["style"] or "fill: none" in mark.attrib["style"]


def _corners(path: str) -> list[Point]:
    numbers = [float(item) for item in _NUMBER.findall(path)]
    return list(zip(numbers[::2], numbers[1::2], strict=True))


def _scale(ticks: list[tuple[str, float]], logarithmic: bool) -> Callable[[float], float]:
    known = [(float(label.lstrip("≤ ").replace("−", "-")), at) for label, at in ticks if label]
    if logarithmic:
        known = [(math.log10(value), at) for value, at in known]
    (first, at_first), (last, at_last) = known[0], known[-1]

    def value(at: float) -> float:
        fraction = first + (at - at_first) / (at_last - at_first) * (last - first)
        return 10.0**fraction if logarithmic else fraction

    return value
