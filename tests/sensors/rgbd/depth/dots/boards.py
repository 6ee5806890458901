"""Flat boards and rays onto them, in closed form; all in the frame of the left infrared camera (x right, y down)."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Bool, Float, Int


@dataclass(frozen=True)
class Board:
    """A rectangle turned about the vertical through its middle."""

    z: float
    """Depth of its middle (m)."""
    angle_deg: float = 0.0
    """By which it is turned."""
    x: float = 0.0
    """Of its middle (m)."""
    half_width: float = 100.0
    """Half its width (m), as wide as everything by default."""
    remission: float = 1.0
    """Diffuse reflectance."""
    roughness: float = 1.0
    """Perceptual roughness."""
    metallic: float = 0.0
    """Fraction of metal."""
    texture: float = 0.0
    """Standard deviation of its albedo, as a fraction of it."""
    grain: float = 0.012
    """Size of its finest texture (m)."""

    @property
    def normal(self) -> Float[np.ndarray, "3"]:
        """Towards the camera."""
        lean = np.deg2rad(self.angle_deg)
        return np.array([np.sin(lean), 0.0, -np.cos(lean)])

    @property
    def along(self) -> Float[np.ndarray, "3"]:
        """Across its width."""
        lean = np.deg2rad(self.angle_deg)
        return np.array([np.cos(lean), 0.0, np.sin(lean)])


@dataclass(frozen=True, eq=False)
class Hits:
    """What rays meet first."""

    distance: Float[np.ndarray, "*s"]
    """In units of the ray's direction; infinite where nothing is met."""
    board: Int[np.ndarray, "*s"]
    """Number of the board; -1 = none."""


@dataclass(frozen=True)
class Place:
    """Boards, and light that falls on them from everywhere."""

    boards: Sequence[Board]
    """What there is."""
    ambient_lux: float = 300.0
    """Illuminance of the hall."""
    seed: int = 0
    """Of textures."""
    _waves: dict[int, Float[np.ndarray, "n 4"]] = field(default_factory=dict, repr=False)

    def cast(self, origin: Float[np.ndarray, "3"], rays: Float[np.ndarray, "*s 3"]) -> Hits:
        """Return what rays from ``origin`` meet first."""
        distance, number = np.full(rays.shape[:-1], np.inf), np.full(rays.shape[:-1], -1)
        for index, board in enumerate(self.boards):
            middle = np.array([board.x, 0.0, board.z])
            facing = rays @ board.normal
            found = (middle - origin) @ board.normal / np.where(np.abs(facing) < 1e-9, 1e-9, facing)
            across = (origin - middle) @ board.along + found * (rays @ board.along)
            nearer = (found > 1e-6) & (facing < 0) & (np.abs(across) <= board.half_width) & (found < distance)
            distance[nearer], number[nearer] = found[nearer], index
        return Hits(distance, number)

    def albedo(self, points: Float[np.ndarray, "*s 3"], board: Int[np.ndarray, "*s"]) -> Float[np.ndarray, "*s"]:
        """Return the reflectance at points of boards: remission and a texture of many waves."""
        found = np.zeros(board.shape)
        for index, item in enumerate(self.boards):
            here = board == index
            found[here] = item.remission
            if item.texture > 0:
                where = np.stack([points[here] @ item.along, points[here][:, 1]], axis=-1)
                found[here] *= np.maximum(1.0 + item.texture * self._pattern(index, item.grain, where), 0.05)
        return found

    def _pattern(self, index: int, grain: float, where: Float[np.ndarray, "n 2"]) -> Float[np.ndarray, " n"]:
        """Return waves of the grain's length to eight times it, of all directions; variance 1."""
        rng, sum_ = np.random.default_rng([self.seed, index]), np.zeros(len(where))
        count = 24
        for length in grain * np.geomspace(1.0, 8.0, count):
            turn, phase = rng.uniform(0, 2 * np.pi, 2)
            sum_ += np.sin(2 * np.pi / length * (where @ [np.cos(turn), np.sin(turn)]) + phase)
        return sum_ * np.sqrt(2.0 / count)

    def seen(self, hits: Hits, other: Hits, slack: float = 1e-3) -> Bool[np.ndarray, "*s"]:
        """Return where two casts met the same board at the same fraction of the way, 1 of ``other``'s rays."""
        return (hits.board >= 0) & (other.board == hits.board) & (np.abs(other.distance - 1.0) < slack)
