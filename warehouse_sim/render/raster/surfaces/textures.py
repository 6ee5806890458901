"""Textures and pictures on the graphics device: each set in one layer, so that a pixel needs one look-up."""

from collections.abc import Iterable
from pathlib import Path

import cv2
import moderngl
import numpy as np
from jaxtyping import UInt8

from warehouse_sim.catalog.pictures import HEIGHT_PX, WIDTH_PX, draw_picture
from warehouse_sim.color import linear_from_srgb
from warehouse_sim.errors import RenderError
from warehouse_sim.render.albedo import NO_CHANGE
from warehouse_sim.resources import texture_folder

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
            raise RenderError(f"{len(wanted)} pictures in a scene; the raster backend renders at most {MAX_PICTURES}")
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


TEXTURE_EDGE_PX = 1024
"""Edge of every texture on the device; files of another size are resampled to it."""


class TextureLibrary:
    """An array texture that grows when a scene names a set that is not yet there; layers never move.

    A texel holds, in this order: the factor on the albedo, the normal along u and along v, the factor on the roughness;
    128 is no change and no tilt.
    """

    def __init__(self, context: moderngl.Context) -> None:
        self._context = context
        self._layers: dict[str, np.ndarray] = {}
        self.array = self._upload()

    def require(self, names: Iterable[str]) -> dict[str, int]:
        """Return the layer of each of ``names``, reading those that are new.

        Raises:
            RenderError: A texture is not shipped, or is no image.
        """
        wanted = sorted(set(names))
        new = {name: load_texture_set(name) for name in wanted if name not in self._layers}
        if new:
            self._layers |= new
            self.array.release()
            self.array = self._upload()
        numbers = {name: number for number, name in enumerate(self._layers)}
        return {name: numbers[name] for name in wanted}

    def release(self) -> None:
        """Free the device memory."""
        self.array.release()

    def _upload(self) -> moderngl.TextureArray:
        layers = np.stack([*self._layers.values()]) if self._layers else np.full((1, 1, 1, 4), NO_CHANGE, np.uint8)
        size = layers.shape[2], layers.shape[1], layers.shape[0]
        array = self._context.texture_array(size, 4, layers.tobytes())
        array.build_mipmaps()
        array.filter = (moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR)
        return array


def load_texture_set(name: str) -> UInt8[np.ndarray, "1024 1024 4"]:
    """Read a texture set's folder: ``albedo.png``, and ``normal.png`` and ``roughness.png`` where they exist.

    Raises:
        RenderError: The albedo is missing, or a file is no image.
    """
    folder = texture_folder(name)
    if not (folder / "albedo.png").is_file():
        known = ", ".join(sorted(item.name for item in folder.parent.glob("*") if item.is_dir())) or "(none)"
        raise RenderError(f"texture {name!r}: {folder / 'albedo.png'} does not exist; textures there: {known}")
    texels = np.full((TEXTURE_EDGE_PX, TEXTURE_EDGE_PX, 4), NO_CHANGE, np.uint8)
    texels[..., 0] = _read(name, folder / "albedo.png", cv2.IMREAD_GRAYSCALE)
    if (folder / "normal.png").is_file():
        blue_green_red = _read(name, folder / "normal.png", cv2.IMREAD_COLOR)
        texels[..., 1] = blue_green_red[..., 2]
        # In the file y points up the image, on the device v grows with the rows, downwards.
        texels[..., 2] = np.clip(256 - blue_green_red[..., 1].astype(int), 0, 255)
    if (folder / "roughness.png").is_file():
        texels[..., 3] = _read(name, folder / "roughness.png", cv2.IMREAD_GRAYSCALE)
    return texels


def _read(name: str, path: Path, mode: int) -> np.ndarray:
    image = cv2.imread(str(path), mode)
    if image is None:
        raise RenderError(f"texture {name!r}: {path} is not a readable image; bake the assets again")
    if image.shape[:2] != (TEXTURE_EDGE_PX, TEXTURE_EDGE_PX):
        # Each texel of a small one becomes equal ones: its mipmaps stay, and nothing blends at its edges.
        way = cv2.INTER_AREA if min(image.shape[:2]) >= TEXTURE_EDGE_PX else cv2.INTER_NEAREST
        image = cv2.resize(image, (TEXTURE_EDGE_PX, TEXTURE_EDGE_PX), interpolation=way)
    return image
