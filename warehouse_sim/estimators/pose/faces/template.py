"""A front fitted to what a plane shows: material on the plane, and two openings, which are as all that is no face.

The log likelihood of a face is a sum over rectangles, and with the image's integral a rectangle costs four look-ups:
tens of thousands of faces are compared at once. They are drawn by the cross-entropy method (Rubinstein 1999); how sure
the best is follows from the weights of all that were drawn about it (importance sampling).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from warehouse_sim.estimators.pose.faces.planes import PlaneView
from warehouse_sim.estimators.pose.faces.shape import (
    BOARD,
    FOOT,
    HEIGHT,
    MIDDLE,
    WIDTH,
    FacePrior,
    pocket_borders,
)

_CLAIMED = {"material": 0.9, "opening": 0.4, "other": 0.1}
"""Part of its places that a mask holds, near an outline: the pallet's inside, seen through an opening, is the pallet's,
too."""
_START, _SAMPLED, _ROUNDS, _BEST = 6000, 800, 7, 60
_WEIGHED = 4000
_SMALLEST = np.full(8, 2e-3)
"""Steps of the search, and errors that nothing can be surer than (m)."""


@dataclass(frozen=True, eq=False)
class FrontFit:
    """The most likely face of a plane."""

    shape: Float[np.ndarray, " 8"]
    covariance: Float[np.ndarray, "8 8"]
    score: float
    """Log likelihood against an empty plane, with the prior."""
    openings: float
    """What the two pockets add to it against a face that is closed."""


class _Integral:
    """Sums over rectangles of a grid whose borders lie between cells, by linear interpolation."""

    def __init__(self, values: Float[np.ndarray, "r c"], view: PlaneView) -> None:
        self._sums = np.zeros((values.shape[0] + 1, values.shape[1] + 1))
        self._sums[1:, 1:] = values.cumsum(axis=0).cumsum(axis=1)
        self._low, self._cell = view.low, view.cell

    def total(
        self,
        right: Float[np.ndarray, " n"],
        left: Float[np.ndarray, " n"],
        bottom: Float[np.ndarray, " n"],
        top: Float[np.ndarray, " n"],
    ) -> Float[np.ndarray, " n"]:
        """Return the sums over n rectangles (m, in the plane); what is outside the grid counts nothing."""
        corners = self._at(left, top) - self._at(right, top) - self._at(left, bottom) + self._at(right, bottom)
        return np.asarray(corners)

    def _at(self, y: Float[np.ndarray, " n"], z: Float[np.ndarray, " n"]) -> Float[np.ndarray, " n"]:
        rows, columns = np.array(self._sums.shape) - 1
        column = np.clip((y - self._low[0]) / self._cell, 0.0, columns)
        row = np.clip((z - self._low[1]) / self._cell, 0.0, rows)
        c, r = np.minimum(column.astype(int), columns - 1), np.minimum(row.astype(int), rows - 1)
        s, t = column - c, row - r
        below = self._sums[r, c] * (1.0 - s) + self._sums[r, c + 1] * s
        above = self._sums[r + 1, c] * (1.0 - s) + self._sums[r + 1, c + 1] * s
        return np.asarray(below * (1.0 - t) + above * t)


class FaceLikelihood:
    """How well faces explain what a plane shows.

    Args:
        view: The plane.
        sigma: Error of readings across the plane (m).
        dependent: How many neighbouring pixels are worth one independent reading.
        masked: Whether the detection has a mask, and not only a box.
    """

    def __init__(self, view: PlaneView, sigma: float, dependent: float, masked: bool) -> None:
        fraction = view.pixels_a_cell / dependent
        material, opening = view.log_odds(sigma)
        if masked:
            material = material + view.claim(_CLAIMED["material"], _CLAIMED["other"])
            opening = opening + view.claim(_CLAIMED["opening"], _CLAIMED["other"])
        self._face = _Integral(material * fraction, view)
        self._open = _Integral(opening * fraction, view)
        self._closed = _Integral(np.where(np.isnan(view.behind), 0.0, opening - material) * fraction, view)

    def openings(self, q: Float[np.ndarray, "n 8"]) -> Float[np.ndarray, " n"]:
        """Return by how much n faces are likelier with their pockets than closed."""
        right, left = (self._closed.total(*pocket) for pocket in pocket_borders(q))
        return np.asarray(right + left)

    def log(self, q: Float[np.ndarray, "n 8"]) -> Float[np.ndarray, " n"]:
        """Return the log likelihood of n faces against an empty plane."""
        right, left = q[:, MIDDLE] - q[:, WIDTH] / 2.0, q[:, MIDDLE] + q[:, WIDTH] / 2.0
        bottom, top = q[:, FOOT], q[:, FOOT] + q[:, HEIGHT]
        total = self._face.total(right, left, bottom, top)
        for pocket in pocket_borders(q):
            total += self._open.total(*pocket) - self._face.total(*pocket)
        return np.asarray(total)


def fit_face(
    likelihood: FaceLikelihood,
    prior: FacePrior,
    seen: tuple[Float[np.ndarray, " 2"], Float[np.ndarray, " 2"]],
    rng: np.random.Generator,
    starts: int,
) -> FrontFit | None:
    """Return the most likely face, or None where none fits at all.

    Args:
        likelihood: Of the plane.
        prior: What is known of the face.
        seen: Least and greatest y and z of the points on the plane (m); where to look.
        rng: Source of randomness.
        starts: From how many of the first faces, that are apart, the search goes on.
    """

    def log(q: Float[np.ndarray, "n 8"]) -> Float[np.ndarray, " n"]:
        return likelihood.log(q) + prior.log_density(q)

    sampled = _first_draw(prior, seen, rng)
    sampled = sampled[np.isfinite(prior.log_density(sampled))]
    if len(sampled) < _BEST:
        return None
    value = log(sampled)
    all_sampled, all_values = [sampled], [value]
    for start in _apart(sampled, value, starts):
        near = np.argsort(np.linalg.norm((sampled - start) / 0.1, axis=1) - 0.3 * value / max(np.ptp(value), 1e-9))
        mean, spread = start, np.maximum(sampled[near[:_BEST]].std(axis=0), 0.01)
        for _ in range(_ROUNDS):
            q = np.concatenate([mean[None], rng.normal(mean, spread, (_SAMPLED, 8))])
            q[:, BOARD] = np.abs(q[:, BOARD])
            worth = log(q)
            best = q[np.argsort(-worth)[:_BEST]]
            mean, spread = best.mean(axis=0), np.maximum(best.std(axis=0) * 1.2, _SMALLEST)
            all_sampled.append(q)
            all_values.append(worth)
    q, worth = np.concatenate(all_sampled), np.concatenate(all_values)
    best = q[worth.argmax()]
    shape, covariance = _moments(q, worth, best, log, rng)
    score = float(worth.max())
    return FrontFit(shape, covariance, score, float(likelihood.openings(shape[None])[0]))


def _first_draw(
    prior: FacePrior, seen: tuple[Float[np.ndarray, " 2"], Float[np.ndarray, " 2"]], rng: np.random.Generator
) -> Float[np.ndarray, "n 8"]:
    """Return faces as the prior has them, half of them between the ends of what is seen, the others anywhere."""
    (right, foot), (left, top) = seen
    spread = np.where(np.isfinite(prior.spread), prior.spread, 0.0)
    q = rng.normal(np.nan_to_num(prior.usual), spread, (_START, 8))
    q[:, BOARD] = np.abs(q[:, BOARD])
    half = _START // 2
    q[:, MIDDLE] = rng.uniform(right, left, _START)
    q[:, FOOT] = rng.uniform(foot - 0.02, max(top - 0.08, foot), _START)
    if not np.isfinite(prior.spread[WIDTH]) or prior.spread[WIDTH] > 0.1:
        q[:half, WIDTH] = np.clip(left - right + rng.normal(0.0, 0.02, half), 0.4, 2.2)
    q[:half, MIDDLE] = (right + left) / 2.0 + rng.normal(0.0, 0.02, half)
    q[:half, FOOT] = foot + rng.normal(0.0, 0.015, half)
    return q


def _apart(
    sampled: Float[np.ndarray, "n 8"], value: Float[np.ndarray, " n"], most: int
) -> list[Float[np.ndarray, " 8"]]:
    """Return the best of what was drawn, and the best of what is elsewhere."""
    found: list[Float[np.ndarray, " 8"]] = []
    for index in np.argsort(-value):
        if all(np.abs(sampled[index] - other)[[MIDDLE, FOOT, WIDTH]].max() > 0.06 for other in found):
            found.append(sampled[index])
        if len(found) == most:
            break
    return found


def _moments(
    q: Float[np.ndarray, "n 8"],
    worth: Float[np.ndarray, " n"],
    best: Float[np.ndarray, " 8"],
    log: Callable[[Float[np.ndarray, "m 8"]], Float[np.ndarray, " m"]],
    rng: np.random.Generator,
) -> tuple[Float[np.ndarray, " 8"], Float[np.ndarray, "8 8"]]:
    """Return mean and covariance of the faces that are about as likely as the best one."""
    near = worth >= worth.max() - 12.0
    weight = np.exp(worth[near] - worth.max())
    spread = np.maximum(np.sqrt((weight @ (q[near] - best) ** 2) / weight.sum()), _SMALLEST)
    again = np.concatenate([best[None], rng.normal(best, 1.5 * spread, (_WEIGHED, 8))])
    again[:, BOARD] = np.abs(again[:, BOARD])
    density = -0.5 * (((again - best) / (1.5 * spread)) ** 2).sum(axis=1)
    found = log(again)
    weight = np.exp(np.clip(found - found.max() - density + density.max(), -700, 20.0)) * (found > found.max() - 14.0)
    weight /= weight.sum()
    mean = weight @ again
    away = again - mean
    return mean, (away * weight[:, None]).T @ away + np.diag(_SMALLEST**2 / 4.0)
