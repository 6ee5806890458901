"""A slow referee of what stands on what: bases and tops drawn on a grid of 1 cm, one piece after the other."""

from collections.abc import Iterable, Mapping

import numpy as np
from jaxtyping import Bool, Float

from warehouse_sim.schema import ObjectInstance, ObjectModel

STEP = 0.01
_TOUCH = 0.004
_KG_PER_LB, _M_PER_INCH = 0.45359237, 0.0254


class Pile:
    """Pieces of one scene or load, drawn from above.

    Args:
        models: By name.
        instances: Those with a body; what moves with them, such as film, is left out.
    """

    def __init__(self, models: Mapping[str, ObjectModel], instances: Iterable[ObjectInstance]) -> None:
        self.items = [item for item in instances if models[item.model].collision]
        self.models = [models[item.model] for item in self.items]
        self.low = np.array([self._heights(i)[0] for i in range(len(self.items))])
        self.top = np.array([self._heights(i)[1] for i in range(len(self.items))])

    def pallets(self) -> list[int]:
        """Return the numbers of the pallets, the lowest first."""
        numbers = [i for i, model in enumerate(self.models) if model.class_name == "pallet"]
        return sorted(numbers, key=lambda i: float(self.low[i]))

    def supported(self, number: int) -> tuple[float, bool]:
        """Return the fraction of a piece's base that rests on bodies, and whether its load's centre is over them."""
        points = self._base(number)
        rests = np.zeros(len(points), bool)
        for below in self._under(number):
            for box in self.models[below].collision:
                T = self.items[below].T_world_object @ box.T_parent_box
                rests |= _inside(points, T, box.size)
        load = [i for i, item in enumerate(self.items) if item.group == self.items[number].group]
        masses = np.array([self.models[i].mass for i in load])
        centre = masses @ np.array([self.items[i].T_world_object[:2, 3] for i in load]) / masses.sum()
        return float(rests.mean()), _in_hull(points[rests], centre)

    def carried(self) -> Float[np.ndarray, " n"]:
        """Return what stands on each piece (kg): a weight goes to those below by the cells that they share."""
        burden = np.zeros(len(self.items))
        for number in np.argsort(-self.low):
            points = self._base(int(number))
            under = self._under(int(number))
            cells = np.array([self._covers(i, points).sum() for i in under], float)
            weight = self.models[number].mass + burden[number]
            for below, count in zip(under, cells, strict=True):
                burden[below] += weight * count / max(cells.sum(), 1.0)
        return burden

    def across(self, number: int) -> bool:
        """Return whether goods stand on a piece that are not in line with it."""
        points = self._base(number)
        for above in range(len(self.items)):
            if abs(self.low[above] - self.top[number]) > _TOUCH or self.models[above].class_name == "pallet":
                continue
            there = self._base(above)
            shared = self._covers(above, points).sum()
            if 0 < shared < 0.9 * max(len(points), len(there)):
                return True
        return False

    def _under(self, number: int) -> list[int]:
        near = np.abs(self.top - self.low[number]) < _TOUCH
        return [int(i) for i in np.flatnonzero(near) if i != number]

    def _heights(self, number: int) -> tuple[float, float]:
        z, half = self.items[number].T_world_object[2, 3], self.models[number].size[2] / 2
        return float(z - half), float(z + half)

    def _base(self, number: int) -> Float[np.ndarray, "n 2"]:
        """Return the middles of the cells under a piece in the world (m)."""
        size, T = self.models[number].size, self.items[number].T_world_object
        axes = [(np.arange(round(edge / STEP)) + 0.5) / round(edge / STEP) * edge - edge / 2 for edge in size[:2]]
        cells = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
        return cells @ T[:2, :2].T + T[:2, 3]

    def _covers(self, number: int, points: Float[np.ndarray, "n 2"]) -> Bool[np.ndarray, " n"]:
        return _inside(points, self.items[number].T_world_object, self.models[number].size)


def may_carry(model: ObjectModel, across: bool) -> float:
    """Return what a carton may carry (kg) by McKee in pounds and inches, as its authors give it, and what is left.

    32 lb/in board of 0.157 in, for dense goods (obj_id 371-376) 61 lb/in of 0.256 in;
    0.60 for a month, 0.80 for 70 % humidity, 0.90 for a pallet's gaps, 0.90 or 0.50 for
    the pattern (Fibre Box Association).
    """
    perimeter = 2 * float(model.size[0] + model.size[1]) / _M_PER_INCH
    edge_crush, caliper = (61.0, 0.0065) if 371 <= model.obj_id <= 376 else (32.0, 0.004)
    pounds = 5.87 * edge_crush * (caliper / _M_PER_INCH * perimeter) ** 0.5
    return pounds * _KG_PER_LB * 0.60 * 0.80 * 0.90 * (0.50 if across else 0.90)


def _inside(points: Float[np.ndarray, "n 2"], T: np.ndarray, size: np.ndarray) -> Bool[np.ndarray, " n"]:
    local = (points - T[:2, 3]) @ T[:2, :2]
    return np.all(np.abs(local) <= size[:2] / 2, axis=1)


def _in_hull(points: Float[np.ndarray, "n 2"], centre: Float[np.ndarray, " 2"]) -> bool:
    """Return whether no line through ``centre`` has all points on one side."""
    if not len(points):
        return False
    angles = np.sort(np.arctan2(*(points - centre).T[::-1]))
    gaps = np.diff(np.append(angles, angles[0] + 2 * np.pi))
    return bool(gaps.max() < np.pi)
