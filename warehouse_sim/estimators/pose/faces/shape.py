"""A pallet's face as eight numbers, and how likely such numbers are before anything is seen."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from warehouse_sim.geometry.pose import Transform, invert, make_transform
from warehouse_sim.schema import Pocket

NAMES = ("middle", "foot", "width", "height", "post", "pocket_width", "pocket_height", "board")
"""Of a face in its plane (m): where its middle and its foot are, its width and height, the width of the middle post,
the size of a pocket, and the height of what lies under the pockets."""
MIDDLE, FOOT, WIDTH, HEIGHT, POST, POCKET_WIDTH, POCKET_HEIGHT, BOARD = range(len(NAMES))

_USUAL = np.array([np.nan, np.nan, 1.05, 0.150, 0.145, 0.32, 0.098, 0.010])
_SPREAD = np.array([np.inf, np.inf, 0.30, 0.030, 0.060, 0.12, 0.025, 0.020])
"""Of the pallets of this project's catalog (600-1300 mm wide, half pallets to stringer pallets), widened by about half;
no figure is taken from a recorded pallet."""
_SLAB = (0.040, 0.020)
"""Height of what lies over the pockets (m), and its spread: a deck with or without a stringer under it."""
_LEAST = np.array([-np.inf, -np.inf, 0.4, 0.07, 0.03, 0.12, 0.045, 0.0])
_MOST = np.array([np.inf, np.inf, 2.2, 0.30, 0.40, 0.75, 0.20, 0.07])
_LEAST_POST, _MOST_POST, _LEAST_SLAB = 0.02, 0.40, 0.008


@dataclass(frozen=True, eq=False)
class FacePrior:
    """What is known of a face before it is seen."""

    usual: Float[np.ndarray, " 8"]
    """Most likely numbers; nan where nothing is known."""
    spread: Float[np.ndarray, " 8"]
    """Their standard deviations; inf where nothing is known."""
    slab: tuple[float, float] | None = _SLAB
    """Height over the pockets and its standard deviation (m); None where the others say it."""

    def log_density(self, shapes: Float[np.ndarray, "n 8"]) -> Float[np.ndarray, " n"]:
        """Return how likely faces are, up to a constant; -inf where the parts do not fit together."""
        known = np.isfinite(self.spread)
        away = (shapes[:, known] - self.usual[known]) / self.spread[known]
        density = -0.5 * (away**2).sum(axis=1)
        slab = over_pockets(shapes)
        side = side_post(shapes)
        if self.slab is not None:
            density -= 0.5 * ((slab - self.slab[0]) / self.slab[1]) ** 2
        fits = (slab >= _LEAST_SLAB) & (side >= _LEAST_POST) & (side <= _MOST_POST)
        fits &= ((shapes >= _LEAST) & (shapes <= _MOST)).all(axis=1)
        return np.where(fits, density, -np.inf)


ANY_PALLET = FacePrior(_USUAL, _SPREAD)
"""What is known of a pallet that is in no catalog."""


def over_pockets(shapes: Float[np.ndarray, "n 8"]) -> Float[np.ndarray, " n"]:
    """Return the height of what lies over the pockets (m)."""
    return shapes[:, HEIGHT] - shapes[:, POCKET_HEIGHT] - shapes[:, BOARD]


def side_post(shapes: Float[np.ndarray, "n 8"]) -> Float[np.ndarray, " n"]:
    """Return the width of the outer posts (m)."""
    return (shapes[:, WIDTH] - shapes[:, POST]) / 2.0 - shapes[:, POCKET_WIDTH]


def pocket_borders(q: Float[np.ndarray, "n 8"]) -> list[tuple[Float[np.ndarray, " n"], ...]]:
    """Return right, left, bottom and top (m) of the right and of the left pocket of n faces."""
    bottom = q[:, FOOT] + q[:, BOARD]
    top = bottom + q[:, POCKET_HEIGHT]
    near, far = q[:, POST] / 2.0, q[:, POST] / 2.0 + q[:, POCKET_WIDTH]
    middle = q[:, MIDDLE]
    return [(middle - far, middle - near, bottom, top), (middle + near, middle + far, bottom, top)]


@dataclass(frozen=True, eq=False)
class CatalogFace:
    """A side with two pockets of an object whose CAD is known."""

    T_object_dock: Transform
    prior: FacePrior


def catalog_faces(size: Float[np.ndarray, " 3"], pockets: Sequence[Pocket], spread: float) -> list[CatalogFace]:
    """Return the sides of an object that have two pockets of one size, each with its numbers for a prior.

    Args:
        size: Outer edge lengths of the object (m), its origin at the centre.
        pockets: All of its pockets.
        spread: How far objects are from their CAD (m, standard deviation).
    """
    found = []
    for name in sorted({pocket.face for pocket in pockets}):
        pair = [pocket for pocket in pockets if pocket.face == name]
        if len(pair) != 2 or not np.allclose(pair[0].size[1:], pair[1].size[1:], atol=2e-3):
            continue
        middle = (pair[0].T_object_pocket[:3, 3] + pair[1].T_object_pocket[:3, 3]) / 2.0
        T_object_dock = make_transform(pair[0].T_object_pocket[:3, :3], middle)
        aside = abs((invert(T_object_dock) @ pair[0].T_object_pocket)[1, 3])
        clear_width, clear_height = pair[0].size[1:]
        board = size[2] / 2.0 + middle[2] - clear_height / 2.0
        width = float(np.abs(T_object_dock[:3, 1]) @ size)
        usual = [np.nan, np.nan, width, size[2], 2.0 * aside - clear_width, clear_width, clear_height, board]
        spreads = np.array([np.inf, np.inf, *[spread] * 6])
        found.append(CatalogFace(T_object_dock, FacePrior(np.array(usual), spreads, None)))
    return found
