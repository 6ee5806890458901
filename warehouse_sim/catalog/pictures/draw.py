"""Draw a picture by its name."""

import zlib
from collections.abc import Callable
from functools import lru_cache

import numpy as np
from jaxtyping import UInt8

from warehouse_sim.catalog.pictures.labels import article_label, location_label, shipping_label
from warehouse_sim.catalog.pictures.prints import carton_print
from warehouse_sim.catalog.pictures.sheet import Sheet
from warehouse_sim.errors import UnknownNameError

PICTURES: dict[str, Callable[[str, np.random.Generator], Sheet]] = {
    painter.__name__: painter for painter in (shipping_label, article_label, location_label, carton_print)
}
"""Kind -> the function that draws it from its key and a random stream of its name."""


@lru_cache(maxsize=256)
def draw_picture(name: str) -> UInt8[np.ndarray, "h w 4"]:
    """Return the picture called ``name``: sRGB and cover, the first row on top; it must not be written to.

    Raises:
        UnknownNameError: There is no such kind.
    """
    kind, _, key = name.partition(":")
    if kind not in PICTURES:
        raise UnknownNameError("kind of picture", kind, list(PICTURES))
    image = PICTURES[kind](key, np.random.default_rng([2026, zlib.crc32(name.encode())])).picture()
    image.setflags(write=False)
    return image
