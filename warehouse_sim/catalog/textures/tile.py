"""One tile of a surface as its painter describes it, and as files hold it: albedo, normal and roughness."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import UInt8

from warehouse_sim.catalog.noise import Texels

SIZE = 512
"""Edge of a fresh texture in texels."""
NEUTRAL = 128
"""Grey level that leaves albedo or roughness as it is."""


@dataclass(frozen=True, eq=False)
class Tile:
    """What a painter returns: factors about 1, and the relief that bends the light."""

    albedo: Texels
    """Factor on the albedo; its mean is moved to 1."""
    height: Texels
    """Relief in texels across the grain, so that a step of one texel by one texel is a slope of 45 degrees."""
    roughness: Texels
    """Factor on the roughness; its mean is moved to 1."""
    stretch: int = 1
    """Length of a texel along u over its width along v."""


@dataclass(frozen=True, eq=False)
class TextureSet:
    """The images of one texture; rows are v, columns are u, and all tile without seams."""

    albedo: UInt8[np.ndarray, "n n"]
    """Grey factors of which ``NEUTRAL`` means no change."""
    normal: UInt8[np.ndarray, "n n 3"]
    """RGB of the unit normal in tangent space, OpenGL's way: x to the right, y up the image, z outwards; 128 = 0."""
    roughness: UInt8[np.ndarray, "n n"]
    """Grey factors of which ``NEUTRAL`` means no change."""

    def images(self) -> dict[str, np.ndarray]:
        """Return the images by the names of their files."""
        return {"albedo": self.albedo, "normal": self.normal, "roughness": self.roughness}


def quantised(tile: Tile) -> TextureSet:
    """Return ``tile`` in eight bits."""
    return TextureSet(_levels(tile.albedo), normals(tile.height, tile.stretch), _levels(tile.roughness))


def normals(height: Texels, stretch: int = 1) -> UInt8[np.ndarray, "n n 3"]:
    """Return the normals of a relief by central differences around the edges."""
    to_right = (np.roll(height, -1, 1) - np.roll(height, 1, 1)) / (2.0 * stretch)
    to_top = (np.roll(height, 1, 0) - np.roll(height, -1, 0)) / 2.0
    length = np.sqrt(to_right * to_right + to_top * to_top + 1.0)
    unit = np.stack([-to_right / length, -to_top / length, 1.0 / length], axis=-1)
    return (np.round(unit * 127.0) + 128.0).astype(np.uint8)


def _levels(factors: Texels) -> UInt8[np.ndarray, "n n"]:
    """Return factors as grey levels whose mean is ``NEUTRAL`` to within half a level."""
    # The mean is taken of whole numbers: sums of floats may differ in the last bit between processors.
    levels = np.round(factors * (NEUTRAL * 64)).astype(np.int64)
    mean = int(levels.sum()) // levels.size
    return np.clip((levels - mean + NEUTRAL * 64 + 32) // 64, 0, 255).astype(np.uint8)
