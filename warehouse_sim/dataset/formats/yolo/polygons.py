"""The outline of a mask as one polygon, holes and separate parts included, that tools fill to the same mask.

A row of YOLO's labels has one polygon. Outlines of all parts and holes are therefore joined by bridges, there and back,
of which the shortest tree is taken. Filled as tools do (OpenCV's fillPoly: odd crossings are inside, and so are the
pixels of the outline), bridges to holes lie inside the mask; those between parts add a line of one pixel. Parts that
have fewer pixels than their bridge are left out. Lines and parts left out are all that is lost.
"""

from collections.abc import Iterator
from itertools import combinations

import cv2
import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.spatial import Delaunay, QhullError

from warehouse_sim.geometry.boxes import mask_box_xyxy

_INSIDE = 0.25
"""Where in a pixel a corner lies (px from its first edge): tools that cut and tools that round both find the pixel."""
_SPREAD = 0.2
"""Half the width (px) of what is thinner than a pixel."""


def mask_polygon(mask: Bool[np.ndarray, "h w"]) -> Float[np.ndarray, "n 2"]:
    """Return corners (x, y), in pixels from the image's outer corner, of one polygon around a mask that is not empty.

    It has three corners at least; at 0.25 px into their pixels.
    """
    box = mask_box_xyxy(mask)
    assert box is not None
    left, top, right, bottom = box
    window = np.ascontiguousarray(mask[top : bottom + 1, left : right + 1]).view(np.uint8)
    found, relations = cv2.findContours(window, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
    pixels = _straightened(_joined([contour[:, 0] for contour in found], relations[0][:, 3]))
    corners = pixels + np.array([left + _INSIDE, top + _INSIDE])
    if len(corners) >= 3:
        return corners
    # A pixel or a line of them: given a width that is lost in the pixels again.
    first, last = corners[0], corners[-1]
    sides = [[-_SPREAD, -_SPREAD], [_SPREAD, -_SPREAD], [_SPREAD, _SPREAD], [-_SPREAD, _SPREAD]]
    thin: Float[np.ndarray, "n 2"] = np.array([first, first, last, last]) + sides
    return thin


def _joined(contours: list[Int[np.ndarray, "n 2"]], around: Int[np.ndarray, " c"]) -> Int[np.ndarray, "m 2"]:
    """Return one closed way along all contours that are worth their bridges, and along the bridges.

    Args:
        contours: Outlines of parts, and of holes along the part's pixels.
        around: For the outline of a hole the number of its part's; -1 for parts.
    """
    if len(contours) == 1:
        return contours[0]
    points = np.concatenate(contours)
    owner = np.repeat(np.arange(len(contours)), [len(contour) for contour in contours])
    starts = np.concatenate([[0], np.cumsum([len(contour) for contour in contours])])
    pixels = _pixels(contours, around)
    root = int(np.argmax(np.where(around < 0, pixels, -1.0)))
    bridges = list(_outwards(_shortest_tree(points, owner), owner, root))
    part = np.where(around < 0, np.arange(len(contours)), around)
    way, reached = list(range(starts[root], starts[root + 1])), {root}
    for here, there in _worth(bridges, points, owner, part, pixels):
        number = int(owner[there])
        if int(owner[here]) not in reached:
            continue
        reached.add(number)
        first, after = int(starts[number]), int(starts[number + 1])
        at = way.index(here) + 1
        way[at:at] = [*range(there, after), *range(first, there), there, here]
    return points[way]


def _pixels(contours: list[Int[np.ndarray, "n 2"]], around: Int[np.ndarray, " c"]) -> Float[np.ndarray, " c"]:
    """Return the pixels of each part without its holes, and of each hole, by Pick's theorem (1899)."""
    areas = np.array([cv2.contourArea(contour.astype(np.int32)) for contour in contours])
    # Steps around a contour; a lone pixel has none.
    halves = np.array([len(contour) / 2.0 if len(contour) > 1 else 0.0 for contour in contours])
    pixels = np.where(around < 0, areas + halves + 1.0, areas - halves + 1.0)
    np.subtract.at(pixels, around[around >= 0], pixels[around >= 0])
    return pixels


def _worth(
    bridges: list[tuple[int, int]],
    points: Int[np.ndarray, "n 2"],
    owner: Int[np.ndarray, " n"],
    part: Int[np.ndarray, " c"],
    pixels: Float[np.ndarray, " c"],
) -> list[tuple[int, int]]:
    """Return those bridges, outwards, over which more pixels are reached than they add themselves."""
    gain, worth = pixels.copy(), []
    for here, there in reversed(bridges):
        near, far = owner[here], owner[there]
        added = 0 if part[near] == part[far] else int(np.abs(points[here] - points[there]).max()) - 1
        if gain[far] > added:
            gain[near] += gain[far] - added
            worth.append((here, there))
    return worth[::-1]


def _shortest_tree(points: Int[np.ndarray, "n 2"], owner: Int[np.ndarray, " n"]) -> list[tuple[int, int]]:
    """Return pairs of points that join all contours and are shortest together (Kruskal, over Delaunay's edges)."""
    edges = _neighbours(points)
    edges = edges[owner[edges[:, 0]] != owner[edges[:, 1]]]
    lengths = np.sum((points[edges[:, 0]] - points[edges[:, 1]]) ** 2, axis=1)
    group, bridges = np.arange(owner.max() + 1), []
    for a, b in edges[np.argsort(lengths, kind="stable")].tolist():
        mine, theirs = group[owner[a]], group[owner[b]]
        if mine != theirs:
            group[group == theirs] = mine
            bridges.append((a, b))
    return bridges


def _neighbours(points: Int[np.ndarray, "n 2"]) -> Int[np.ndarray, "m 2"]:
    """Return pairs of points among which the shortest bridges are; the same place may belong to two contours."""
    places, which = np.unique(points, axis=0, return_inverse=True)
    which = which.ravel()
    order = np.argsort(which, kind="stable")
    same = which[order][1:] == which[order][:-1]
    pairs = [np.stack([order[:-1][same], order[1:][same]], axis=1)]
    first = order[np.concatenate([[True], ~same])]
    try:
        corners = Delaunay(places).simplices
        pairs += [first[corners[:, [a, b]]] for a, b in combinations(range(3), 2)]
    except (QhullError, ValueError):  # all in one line, or too few: sorted, neighbours follow each other
        pairs.append(np.stack([first[:-1], first[1:]], axis=1))
    return np.concatenate(pairs)


def _outwards(bridges: list[tuple[int, int]], owner: Int[np.ndarray, " n"], root: int) -> Iterator[tuple[int, int]]:
    """Yield the bridges of a tree so that each begins at a contour that is reached already; ``root`` is."""
    reached, left = {root}, list(bridges)
    while left:
        rest = []
        for a, b in left:
            near, far = (a, b) if owner[a] in reached else (b, a)
            if owner[near] in reached:
                reached.add(int(owner[far]))
                yield near, far
            else:
                rest.append((a, b))
        assert len(rest) < len(left)
        left = rest


def _straightened(way: Int[np.ndarray, "n 2"]) -> Int[np.ndarray, "m 2"]:
    """Return a closed way without repeated points and without those that lie straight between their neighbours."""
    way = way[(way != np.roll(way, 1, axis=0)).any(axis=1)] if len(np.unique(way, axis=0)) > 1 else way[:1]
    steps = np.roll(way, -1, axis=0) - way
    turns = (steps != np.roll(steps, 1, axis=0)).any(axis=1)
    return way[turns] if turns.any() else way[:1]
