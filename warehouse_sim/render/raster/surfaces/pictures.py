"""The pictures of a scene on the graphics device: one layer each of an array texture with mipmaps."""

from collections.abc import Iterable

import cv2
import moderngl
import numpy as np
from jaxtyping import UInt8

from warehouse_sim.catalog.pictures import HEIGHT_PX, WIDTH_PX, draw_picture
from warehouse_sim.color import linear_from_srgb
from warehouse_sim.errors import RenderError

MAX_PICTURES = 512
"""Most pictures of a scene; each takes 1.1 MB with its mipmaps."""
_LINEAR = linear_from_srgb(np.arange(256) / 255.0).astype(np.float32)
_CLEAR = np.zeros((1, 1, 1, 4), np.uint8)


class PictureLibrary:
    """An array texture of what the loaded scene shows; scenes that name the same pictures share it as it is.

    A texel holds linear albedo, multiplied by the cover of the picture, and that cover: means of texels are right.
    Eight bits are coarse for dark ink, by 0.002 of albedo, which is not seen beside paper.
    """

    def __init__(self, context: moderngl.Context) -> None:
        self._context = context
        self._layers: dict[str, np.ndarray] = {}
        self.array = self._upload()

    def require(self, names: Iterable[str]) -> dict[str, int]:
        """Return the layer of each of ``names``; pictures that are not among them go when a new one comes.

        Raises:
            RenderError: There are too many.
            UnknownNameError: There is no such kind of picture.
        """
        wanted = sorted(set(names))
        if len(wanted) > MAX_PICTURES:
            raise RenderError(f"a scene shows {len(wanted)} pictures; the raster backend draws at most {MAX_PICTURES}")
        if not self._layers.keys() >= set(wanted):
            self._layers = {name: self._layers.get(name, _texels(name)) for name in wanted}
            self.array.release()
            self.array = self._upload()
        numbers = {name: number for number, name in enumerate(self._layers)}
        return {name: numbers[name] for name in wanted}

    def release(self) -> None:
        """Free the device memory."""
        self.array.release()

    def _upload(self) -> moderngl.TextureArray:
        layers = np.stack([*self._layers.values()]) if self._layers else _CLEAR
        size = layers.shape[2], layers.shape[1], layers.shape[0]
        array = self._context.texture_array(size, 4, layers.tobytes())
        array.build_mipmaps()
        array.filter = (moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR)
        array.repeat_x = array.repeat_y = False
        return array


def _texels(name: str) -> UInt8[np.ndarray, "h w 4"]:
    """Return the picture called ``name`` as the device holds it."""
    image = draw_picture(name)
    if image.shape[:2] != (HEIGHT_PX, WIDTH_PX):
        image = cv2.resize(image, (WIDTH_PX, HEIGHT_PX), interpolation=cv2.INTER_AREA)
    cover = image[..., 3:]
    return np.concatenate([np.rint(_LINEAR[image[..., :3]] * cover).astype(np.uint8), cover], axis=-1)
