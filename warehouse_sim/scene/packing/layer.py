"""One layer of equal pieces on a pallet: where each stands and whether it is turned by a quarter."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float


@dataclass(frozen=True, eq=False)
class Layer:
    """Cells for equal pieces on a level surface, centred on the origin."""

    centres: Float[np.ndarray, "n 2"]
    """Centres of the cells (m)."""
    turned: Bool[np.ndarray, " n"]
    """Whether the piece's long edge lies along y instead of x."""

    def __len__(self) -> int:
        return len(self.centres)

    def rectangles(self, size: Float[np.ndarray, " k"]) -> tuple[Float[np.ndarray, "n 2"], Float[np.ndarray, "n 2"]]:
        """Return the lower and upper corners (m) of the pieces, whose edges along x and y are ``size[:2]`` (m)."""
        half = np.where(self.turned[:, None], size[1::-1], size[:2]) / 2
        return self.centres - half, self.centres + half

    def subset(self, chosen: np.ndarray) -> "Layer":
        """Return the cells that an index or mask array chooses."""
        return Layer(self.centres[chosen], self.turned[chosen])

    def half_turn(self) -> "Layer":
        """Return the layer turned by 180 degrees about the origin."""
        return Layer(-self.centres, self.turned)

    def mirrored(self) -> "Layer":
        """Return the layer mirrored in the plane x = 0."""
        return Layer(self.centres * [-1.0, 1.0], self.turned)


def join(layers: Sequence[Layer]) -> Layer:
    """Return one layer with the cells of all ``layers``."""
    return Layer(np.concatenate([layer.centres for layer in layers]), np.concatenate([x.turned for x in layers]))


def grid(
    size: Float[np.ndarray, " k"], counts: tuple[int, int], gap: float, turned: bool, centre: Sequence[float] = (0, 0)
) -> Layer:
    """Return ``counts`` columns and rows of cells around ``centre`` (m), ``gap`` (m) apart."""
    pitch = np.asarray(size[1::-1] if turned else size[:2]) + gap
    x, y = ((np.arange(count) - (count - 1) / 2) * step for count, step in zip(counts, pitch, strict=True))
    cells = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    return Layer(cells + np.asarray(centre, dtype=float), np.full(len(cells), turned))


def how_many(edge: float, length: float) -> int:
    """Return how many pieces of ``length`` fit side by side on ``edge`` (m)."""
    return int(edge / length + 1e-6)


def carried(
    low: Float[np.ndarray, "n 2"],
    high: Float[np.ndarray, "n 2"],
    below_low: Float[np.ndarray, "m 2"],
    below_high: Float[np.ndarray, "m 2"],
) -> Float[np.ndarray, " n"]:
    """Return the fraction of each upper rectangle's area that rests on the lower ones, 0 where it would tip over.

    A piece tips when what carries it does not reach around its centre by a tenth of its edge on every side.

    Args:
        low: Lower corners of the upper rectangles (m).
        high: Upper corners of the upper rectangles (m).
        below_low: Lower corners of the rectangles below, which do not overlap (m).
        below_high: Upper corners of the rectangles below (m).
    """
    left = np.maximum(low[:, None], below_low[None])
    right = np.minimum(high[:, None], below_high[None])
    touching = np.all(right > left, axis=2)
    area = np.where(touching, np.prod(np.maximum(right - left, 0.0), axis=2), 0.0).sum(axis=1)
    first = np.where(touching[..., None], left, np.inf).min(axis=1, initial=np.inf)
    last = np.where(touching[..., None], right, -np.inf).max(axis=1, initial=-np.inf)
    middle, reach = (low + high) / 2, (high - low) / 10
    steady = np.all((first <= middle - reach) & (last >= middle + reach), axis=1)
    return np.where(steady, area / np.prod(high - low, axis=1), 0.0)
