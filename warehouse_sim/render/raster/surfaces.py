"""How surfaces look: the materials of a scene on the graphics device, with their baked textures and pictures."""

from collections.abc import Collection, Iterable
from functools import cache

import cv2
import moderngl
import numpy as np
from jaxtyping import Float32, UInt8

from warehouse_sim.catalog.pictures.draw import draw_picture
from warehouse_sim.catalog.pictures.sheet import HEIGHT_PX, WIDTH_PX
from warehouse_sim.catalog.textures import DETAIL_OF, stretch
from warehouse_sim.color import linear_from_srgb
from warehouse_sim.errors import RenderError
from warehouse_sim.render.textures import NO_CHANGE, WOUND, read_texture_set, veil
from warehouse_sim.schema import Material
from warehouse_sim.schema.things import RETROREFLECTIVE

MAX_PICTURES = 512
"""Most pictures of a scene; each takes 1.1 MB with its mipmaps."""
_LINEAR = linear_from_srgb(np.arange(256) / 255.0).astype(np.float32)


class ImageLayers:
    """An array texture, an image in each layer, so that a pixel needs one look-up.

    Args:
        context: Where to upload to.
        empty: The only layer (1, h, w, 4) as long as there is no other.
        repeats: Whether images are laid on like tiles.
    """

    def __init__(self, context: moderngl.Context, empty: UInt8[np.ndarray, "1 h w 4"], repeats: bool) -> None:
        self._context, self._empty, self._repeats = context, empty, repeats
        self._layers: dict[str, UInt8[np.ndarray, "h w 4"]] = {}
        self.array = self._upload()

    def _replace(self, layers: dict[str, UInt8[np.ndarray, "h w 4"]]) -> None:
        self._layers = layers
        self.array = self._upload()

    def _numbers(self, names: Iterable[str]) -> dict[str, int]:
        numbers = {name: number for number, name in enumerate(self._layers)}
        return {name: numbers[name] for name in names}

    def _upload(self) -> moderngl.TextureArray:
        layers = np.stack([*self._layers.values()]) if self._layers else self._empty
        size = layers.shape[2], layers.shape[1], layers.shape[0]
        array = self._context.texture_array(size, 4, layers.tobytes())
        array.build_mipmaps()
        array.filter = (moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR)
        array.repeat_x = array.repeat_y = self._repeats
        return array


class PictureLibrary(ImageLayers):
    """What the loaded scene shows; scenes that name the same pictures share it as it is.

    A texel holds linear albedo, multiplied by the cover of the picture, and that cover: means of texels are right.
    Eight bits are coarse for dark ink, by 0.002 of albedo, which is not seen beside paper.
    """

    def __init__(self, context: moderngl.Context) -> None:
        super().__init__(context, np.zeros((1, 1, 1, 4), np.uint8), repeats=False)

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
            self._replace({name: self._layers[name] if name in self._layers else _texels(name) for name in wanted})
        return self._numbers(wanted)


def _texels(name: str) -> UInt8[np.ndarray, "h w 4"]:
    """Return the picture called ``name`` as the device holds it."""
    image = draw_picture(name)
    if image.shape[:2] != (HEIGHT_PX, WIDTH_PX):
        image = cv2.resize(image, (WIDTH_PX, HEIGHT_PX), interpolation=cv2.INTER_AREA)
    cover = image[..., 3:]
    return np.concatenate([np.rint(_LINEAR[image[..., :3]] * cover).astype(np.uint8), cover], axis=-1)


TEXTURE_EDGE_PX = 1024
"""Edge of every texture on the device; files of another size are resampled to it."""


class TextureLibrary(ImageLayers):
    """Texture sets; grows when a scene names one that is not yet there, and layers never move.

    A texel holds, in this order: the factor on the albedo, the normal along u and along v, the factor on the roughness;
    128 is no change and no tilt.
    """

    def __init__(self, context: moderngl.Context) -> None:
        super().__init__(context, np.full((1, 1, 1, 4), NO_CHANGE, np.uint8), repeats=True)

    def require(self, names: Iterable[str]) -> dict[str, int]:
        """Return the layer of each of ``names``, reading those that are new.

        Raises:
            RenderError: A texture is not shipped, or is no image.
        """
        wanted = sorted(set(names))
        new = {name: _texture_texels(name) for name in wanted if name not in self._layers}
        if new:
            self._replace(self._layers | new)
        return self._numbers(wanted)


@cache
def _texture_texels(name: str) -> UInt8[np.ndarray, "1024 1024 4"]:
    """Return a texture set as the device holds it; the libraries of a process share it."""
    images = read_texture_set(name)
    texels = np.full((TEXTURE_EDGE_PX, TEXTURE_EDGE_PX, 4), NO_CHANGE, np.uint8)
    texels[..., 0] = _resized(images.albedo)
    if images.normal is not None:
        normal = _resized(images.normal)
        texels[..., 1] = normal[..., 0]
        # In the file y points up the image, on the device v grows with the rows, downwards.
        texels[..., 2] = np.clip(256 - normal[..., 1].astype(int), 0, 255)
    if images.roughness is not None:
        texels[..., 3] = _resized(images.roughness)
    texels.flags.writeable = False
    return texels


def _resized(image: UInt8[np.ndarray, "h w *c"]) -> UInt8[np.ndarray, "1024 1024 *c"]:
    if image.shape[:2] == (TEXTURE_EDGE_PX, TEXTURE_EDGE_PX):
        return image
    # Each texel of a small one becomes equal ones: its mipmaps stay, and nothing blends at its edges.
    way = cv2.INTER_AREA if min(image.shape[:2]) >= TEXTURE_EDGE_PX else cv2.INTER_NEAREST
    return cv2.resize(image, (TEXTURE_EDGE_PX, TEXTURE_EDGE_PX), interpolation=way)


_LIMIT = 4096  # the geometry buffer stores a material in twelve bits


_KINDS = {"liner": 1, "kraft": 1, "kraft_worn": 1, "wood": 3, "wood_worn": 3}
"""Texture -> how single things of it differ, as ``fine_detail.glsl`` numbers it; board with a picture is 2."""
_STUCK = {"tape": 4, "label_": 6}
"""Beginning of a material's name -> the same, of what is stuck on cartons."""
_COATS = ("detail_coating", "detail_zinc")
"""Details of things that do not differ, and that are even from afar: 5."""


def _detail_rows(material: Material, layers: dict[str, int]) -> Float32[np.ndarray, "2 4"]:
    """Return the last two columns of a material's row."""
    kind = _KINDS.get(material.texture or "", 0)
    if kind == 1 and material.picture is not None:
        kind = 2
    kind = next((number for word, number in _STUCK.items() if material.name.startswith(word)), kind)
    detail = DETAIL_OF.get(material.texture or "")
    if detail is not None and detail.name in _COATS:
        kind = 5
    if detail is None:
        return np.array([[-1, 0, 0, kind or -1], [0, 0, 0, 0]], np.float32)
    rows = [[layers[detail.name], 1.0 / (detail.size * stretch(detail.name)), 1.0 / detail.size, kind]]
    end = detail.end or detail.name
    rows.append([layers[end], 1.0 / (detail.size * stretch(end)), 1.0 / detail.size, kind])
    return np.array(rows, np.float32)


class MaterialTable:
    """One row a material in a float texture, and the texture sets and pictures that they name.

    Columns: base colour and roughness; metallic, emission, layer of the texture or -1, tiles a metre across the grain;
    tiles a metre along the grain, veil, layer of the picture, or -2 where ribs are painted instead, -3 for wound film,
    else -1, and 1 for retroreflectors; layer of the detail or -1, its tiles a metre along and across the grain, and how
    single things differ (see ``_KINDS``), or -1 where there is neither; the same of faces across the grain.

    Args:
        context: Where to upload to.
        materials: The scene's.
        library: Gains the textures that they name.
        pictures: Holds the pictures that they name from now on.
        ribbed: Names of those that ribbed sheets are made of.

    Raises:
        RenderError: Too many materials, or a texture that is not shipped.
    """

    def __init__(
        self,
        context: moderngl.Context,
        materials: dict[str, Material],
        library: TextureLibrary,
        pictures: PictureLibrary,
        ribbed: Collection[str],
    ) -> None:
        if len(materials) > _LIMIT:
            raise RenderError(f"a scene holds {len(materials)} materials; the raster backend renders at most {_LIMIT}")
        self.row = {name: number for number, name in enumerate(materials)}
        self.library, self.pictures = library, pictures
        textures = {item.texture for item in materials.values() if item.texture is not None}
        details = [DETAIL_OF[name] for name in textures & DETAIL_OF.keys()]
        ends = {item.end for item in details if item.end is not None}
        layers = library.require(textures | ends | {item.name for item in details})  # at once: it uploads what it holds
        shown = pictures.require(item.picture for item in materials.values() if item.picture is not None)
        values = np.zeros((max(len(materials), 1), 5, 4), np.float32)
        for row, item in enumerate(materials.values()):
            layer = layers[item.texture] if item.texture is not None else -1
            along = item.texture_size * (stretch(item.texture) if item.texture is not None else 1)
            values[row, 0] = [*item.base_color, item.roughness]
            values[row, 1] = [item.metallic, item.emission, layer, 1.0 / item.texture_size]
            paint = -2 if item.name in ribbed else -3 if item.texture == WOUND and item.opacity < 1.0 else -1
            picture = shown[item.picture] if item.picture is not None else paint
            values[row, 2] = [1.0 / along, veil(item), picture, item.remission >= RETROREFLECTIVE]
            values[row, 3:] = _detail_rows(item, layers)
        self.retroreflectors = bool((values[:, 2, 3] > 0).any())
        """Whether any of them is one."""
        self.values = context.texture((5, len(values)), 4, values.tobytes(), dtype="f4")
        self.values.filter = (moderngl.NEAREST, moderngl.NEAREST)
