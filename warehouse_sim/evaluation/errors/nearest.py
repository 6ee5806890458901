"""Mean distances from the places of moved points to the nearest resting ones for very many moves.

ADD-S asks a k-d tree for some hundred million neighbours, most of them in the same few litres of space. Here the space
around the points is cut into cubes, and each cube keeps the few points that can be nearest to anything in it; what lies
in other cubes is evaluated of the tree. In the cubes, numbers have 32 bits, which takes a third off the time: of a
pallet, means are right to a few 1e-9 m.
"""

from dataclasses import dataclass
from threading import Lock

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.spatial import KDTree

from warehouse_sim.evaluation.blocks import in_blocks
from warehouse_sim.geometry.boxes import box_corners
from warehouse_sim.geometry.pose import Transforms, transform_points

_FEW = 1_000_000
"""Places up to which the tree alone is quicker."""
_SAMPLE = 8_000
"""Moves from which the cubes are chosen: with fewer, more places lie in cubes that none of them is in."""
_WORTH = 4
"""Places in a cube from which preparing it is quicker than asking the tree for each."""
_MOST_ALONG = 200
"""Cubes along the longest side of the block."""
_NEAREST = (8, 32, 128, 512)
"""Neighbours of a cube's centre among which its candidates are looked for: 8 in most cubes, more where those are too
few."""
_PREPARED_AT_ONCE = 200_000
"""Neighbours that are looked at in one go."""
_RIVALS = 6
"""Neighbours that a candidate is compared with."""
_AT_ONCE = 150_000
"""Places handled at once, few enough for the processor's cache."""
_ROW = np.complex128
"""Of the size of a cube's row: numpy fetches a number of that size at once, but a row number by number."""
_COUNTED_AT_ONCE = 300_000
"""Places that are counted by cubes in one go, many enough that counting the cubes costs less."""
_ROUNDING = 1e-9
"""Added to what decides between candidates (squared edges): one too many costs time, one too few an error."""


def mean_nearest_distance(T: Transforms, points: Float[np.ndarray, "m 3"], tree: KDTree) -> Float[np.ndarray, " n"]:
    """Return for each move the mean distance (m) from the moved points to the nearest of the points at rest.

    Args:
        T: Moves of the points in their own frame, "n 4 4".
        points: In that frame (m).
        tree: ``KDTree(points)``.
    """
    result = np.empty(len(T))
    at_once = _AT_ONCE // len(points)

    def ask_tree(rows: Int[np.ndarray, " k"]) -> None:
        def work(part: slice) -> None:
            distance, _ = tree.query(transform_points(T[rows[part]], points))
            result[rows[part]] = np.asarray(distance).mean(axis=-1)

        in_blocks(len(rows), at_once, work)

    if len(T) * len(points) <= _FEW:
        ask_tree(np.arange(len(T)))
        return result
    # Neighbours one after the other: what their cubes keep is then still in the processor's cache.
    points = points[tree.indices]
    low, high = points.min(axis=0), points.max(axis=0)
    box = (low + high) / 2.0 + box_corners(high - low)
    sample = T[:: -(-len(T) // _SAMPLE)]
    block = _block(sample, points, box, tree)
    visits = _visited(sample, points, box, block)
    candidates = _prepared(block, points, np.flatnonzero(visits * len(T) >= _WORTH * len(sample)))
    inside = block.holds(T, box)
    ask_tree(np.flatnonzero(~inside))
    held = np.flatnonzero(inside)

    def ask_cubes(part: slice) -> None:
        result[held[part]] = candidates.distances(T[held[part]], points).mean(axis=1, dtype=float)

    in_blocks(len(held), at_once, ask_cubes)
    return result


@dataclass(frozen=True, eq=False)
class _Block:
    """Space cut into cubes, numbered row by row; in it, lengths are in edges of a cube, from the corner."""

    corner: Float[np.ndarray, " 3"]
    """In the frame of the points (m)."""
    edge: float
    """Of a cube (m)."""
    shape: Int[np.ndarray, " 3"]
    """Cubes along the sides."""

    @property
    def size(self) -> int:
        """How many cubes there are."""
        return int(np.prod(self.shape))

    def holds(self, T: Transforms, box: Float[np.ndarray, "8 3"]) -> Bool[np.ndarray, " n"]:
        """Return which moves leave a box, by its corners (m), in the block."""
        corners = (transform_points(T, box) - self.corner) / self.edge
        return ((corners > 1e-6) & (corners < self.shape - 1e-6)).all(axis=(1, 2))

    def places(self, T: Transforms, points: Float[np.ndarray, "m 3"]) -> Float[np.ndarray, "3 p"]:
        """Return where points (m) are moved to, move by move."""
        columns = np.concatenate([points.T, np.ones((1, len(points)))])
        offset = np.concatenate([T[:, :3, :3], T[:, :3, 3:] - self.corner[:, None]], axis=2) / self.edge
        return (offset.transpose(1, 0, 2) @ columns).reshape(3, -1)

    def number(self, places: Float[np.ndarray, "3 p"]) -> Int[np.ndarray, " p"]:
        """Return the cube of each place."""
        x, y, z = places.astype(np.intp)
        return (x * self.shape[1] + y) * self.shape[2] + z

    def centres(self, numbers: Int[np.ndarray, " c"]) -> Float[np.ndarray, "c 3"]:
        """Return the middle of each cube."""
        return np.column_stack(np.unravel_index(numbers, tuple(self.shape))) + 0.5


@dataclass(frozen=True, eq=False)
class _Candidates:
    """Which points can be nearest to anything in a cube, for the cubes of a block."""

    block: _Block
    centre: Float[np.ndarray, "3 1"]
    """Of the points, in the block."""
    points: Float[np.ndarray, "3 k"]
    """From their centre, each once; there, numbers of 32 bits are exact enough."""
    tree: KDTree
    """Of these."""
    cubes: Int[np.ndarray, "c 4"]
    """Of each cube: its first two candidates, how many pairs it has (0 where the tree is evaluated), and the first of
    them. Side by side, since most places need no more, and fetching it is what takes time."""
    pairs: Int[np.ndarray, "2 o"]
    """Candidates, two by two; an odd one stands twice."""

    def distances(self, T: Transforms, points: Float[np.ndarray, "m 3"]) -> Float[np.ndarray, "n m"]:
        """Return the distance (m) of each moved point to the nearest one at rest, for moves that stay in the block."""
        exact = self.block.places(T, points)
        cube = self.cubes.view(_ROW)[:, 0].take(self.block.number(exact))
        one, other, rounds, start = cube.view(self.cubes.dtype).reshape(-1, 4).T
        places = (exact - self.centre).astype(np.float32)
        squared = self._least(places, one, other)
        rows = np.flatnonzero(rounds > 1)
        left, start, there = rounds[rows], start[rows].astype(np.intp), places.take(rows, axis=1)
        for number in range(1, int(left.max(initial=0))):
            if number > 1:
                further = np.flatnonzero(left > number)
                rows, left, start, there = rows[further], left[further], start[further], there.take(further, axis=1)
            pair = start + number
            squared[rows] = np.minimum(squared[rows], self._least(there, *(which.take(pair) for which in self.pairs)))
        distance = np.sqrt(squared, out=squared)
        unknown = np.flatnonzero(rounds == 0)
        if len(unknown):
            distance[unknown] = self.tree.query(exact[:, unknown].T)[0]
        return self.block.edge * distance.reshape(len(T), -1)

    def _least(
        self, places: Float[np.ndarray, "3 p"], one: Int[np.ndarray, " p"], other: Int[np.ndarray, " p"]
    ) -> Float[np.ndarray, " p"]:
        """Return the squared distance of each place to the nearer of two points."""
        first, second = (_squared(places, self.points, which) for which in (one, other))
        return np.minimum(first, second, out=first)


def _squared(places: np.ndarray, points: np.ndarray, which: np.ndarray) -> np.ndarray:
    which = which.astype(np.intp)
    total = places[0] - points[0].take(which)
    total *= total
    for axis in (1, 2):
        offset = places[axis] - points[axis].take(which)
        offset *= offset
        total += offset
    return total


def _block(T: Transforms, points: Float[np.ndarray, "m 3"], box: Float[np.ndarray, "8 3"], tree: KDTree) -> _Block:
    """Choose cubes about half as large as the distances that are requested."""
    few = T[:: max(1, len(T) // 8)]
    near = tree.query(transform_points(few, points).reshape(-1, 3))[0]
    reached = transform_points(T, box)
    # Moves that leave the box far away are few, and would make the block large.
    low, high = np.quantile(reached.min(axis=1), 0.002, axis=0), np.quantile(reached.max(axis=1), 0.998, axis=0)
    edge = max(float(np.median(near)) / 2.0, float((high - low).max()) / _MOST_ALONG, 1e-9)
    return _Block(low, edge, np.ceil((high - low) / edge).astype(int) + 1)


def _visited(
    T: Transforms, points: Float[np.ndarray, "m 3"], box: Float[np.ndarray, "8 3"], block: _Block
) -> Int[np.ndarray, " c"]:
    """Return how many places are in each cube."""
    inside = T[block.holds(T, box)]
    visits, adding = np.zeros(block.size, dtype=np.int64), Lock()

    def count(part: slice) -> None:
        found = np.bincount(block.number(block.places(inside[part], points)), minlength=block.size)
        with adding:
            np.add(visits, found, out=visits)

    in_blocks(len(inside), _COUNTED_AT_ONCE // len(points), count)
    return visits


def _prepared(block: _Block, points: Float[np.ndarray, "m 3"], numbers: Int[np.ndarray, " c"]) -> _Candidates:
    """Find the candidates of some cubes; of the others, and of those with very many, the tree will be asked."""
    alone = np.unique((points - block.corner) / block.edge, axis=0)
    tree = KDTree(alone)
    rounds, start = np.zeros(block.size, np.uint16), np.zeros(block.size, np.intp)
    found, filled = [np.zeros((1, 2), dtype=np.intp)], 1
    for count in sorted({min(count, len(alone)) for count in _NEAREST}):
        open_ones = [numbers[:0]]
        parts: dict[int, tuple[Int[np.ndarray, " c"], Int[np.ndarray, "p 2"], Int[np.ndarray, " c"]]] = {}

        def look(
            part: slice, count: int = count, numbers: Int[np.ndarray, " c"] = numbers, parts: dict = parts
        ) -> None:
            mine = numbers[part]
            row, which, sure = _candidates(block.centres(mine), alone, tree, count)
            parts[part.start] = mine[~sure], *_in_pairs(row, which, len(mine))

        step = _PREPARED_AT_ONCE // count
        in_blocks(len(numbers), step, look)
        for first in sorted(parts):
            mine = numbers[first : first + step]
            still_open, pairs, half = parts[first]
            open_ones.append(still_open)
            # A cube without pairs may be the last one: what it begins with is looked at before it is left to the tree.
            rounds[mine], start[mine] = half, np.where(half > 0, filled + np.cumsum(half) - half, 0)
            found.append(pairs)
            filled += len(pairs)
        numbers = np.concatenate(open_ones)
    pairs = np.concatenate(found)
    cubes = np.column_stack([pairs[start], rounds, start]).astype(np.int32)
    centre = alone.mean(axis=0)
    columns = np.ascontiguousarray((alone - centre).T, dtype=np.float32)
    return _Candidates(block, centre[:, None], columns, tree, cubes, np.ascontiguousarray(pairs.T))


def _candidates(
    centres: Float[np.ndarray, "c 3"], points: Float[np.ndarray, "k 3"], tree: KDTree, count: int
) -> tuple[Int[np.ndarray, " o"], Int[np.ndarray, " o"], Bool[np.ndarray, " c"]]:
    """Return the points that can be nearest to something in some cubes, looking at ``count`` neighbours of each centre.

    A point that is farther from the centre than the nearest one by more than the diagonal is out; so is one that some
    rival is nearer than in all corners of the cube, as the difference of squared distances is linear.

    Returns:
        Cube and point of each candidate, by cube, and which cubes have all of theirs; the others have none.
    """
    near, which = (np.reshape(part, (len(centres), -1)) for part in tree.query(centres, k=count))
    possible = near <= near[:, :1] + np.sqrt(3.0) + _ROUNDING
    sure = ~possible[:, -1] | (count == len(points))
    row, column = np.nonzero(possible & sure[:, None])
    for rival in range(min(_RIVALS, count)):
        apart = np.abs(points[which[row, column]] - points[which[row, rival]]).sum(axis=1)
        kept = near[row, column] ** 2 - near[row, rival] ** 2 <= apart + _ROUNDING
        row, column = row[kept], column[kept]
    return row, which[row, column], sure


def _in_pairs(
    row: Int[np.ndarray, " o"], which: Int[np.ndarray, " o"], rows: int
) -> tuple[Int[np.ndarray, "p 2"], Int[np.ndarray, " rows"]]:
    """Return the candidates two by two, and how many pairs each row has; the last of an odd number stands twice."""
    amount = np.bincount(row, minlength=rows)
    half = (amount + 1) // 2
    pairs = np.zeros((int(half.sum()), 2), dtype=np.intp)
    place = np.arange(len(row)) - np.repeat(np.cumsum(amount) - amount, amount)
    pair = np.repeat(np.cumsum(half) - half, amount) + place // 2
    pairs[pair, 1] = which
    pairs[pair, place % 2] = which
    return pairs, half
