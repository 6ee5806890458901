"""Textures and pictures: as they are shipped, and how they lie on parts.

How they lie: see the raster backend's ``box_projection.glsl`` and ``picture.vert.glsl``; under a picture the detail
texture is left out.
"""

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from jaxtyping import Bool, Float, Float32, Int, UInt8

from warehouse_sim.color import linear_from_srgb
from warehouse_sim.errors import RenderError
from warehouse_sim.resources import texture_folder
from warehouse_sim.schema import Material

NO_CHANGE = 128
"""Value of an albedo or roughness texture where it leaves the material's own as it is, and of a normal without tilt."""


@dataclass(frozen=True, eq=False)
class TextureImages:
    """The images of a texture set; row 0 is at v = 0."""

    albedo: UInt8[np.ndarray, "h w"]
    """What the base colour is multiplied by, in units of 1 / ``NO_CHANGE``."""
    normal: UInt8[np.ndarray, "h w 3"] | None
    """Unit normals; red along u, green up the image, which is against v."""
    roughness: UInt8[np.ndarray, "h w"] | None
    """What the roughness is multiplied by, in units of 1 / ``NO_CHANGE``."""


def read_texture_set(name: str) -> TextureImages:
    """Read a texture set's folder: ``albedo.png``, and ``normal.png`` and ``roughness.png`` where they exist.

    Raises:
        RenderError: The albedo is missing, or a file is no image.
    """
    folder = texture_folder(name)
    normal, roughness = folder / "normal.png", folder / "roughness.png"
    return TextureImages(
        albedo_factor(name),
        cv2.cvtColor(_read(name, normal, cv2.IMREAD_COLOR), cv2.COLOR_BGR2RGB) if normal.is_file() else None,
        _read(name, roughness, cv2.IMREAD_GRAYSCALE) if roughness.is_file() else None,
    )


def albedo_factor(name: str) -> UInt8[np.ndarray, "h w"]:
    """Return the albedo of the texture called ``name`` alone.

    Raises:
        RenderError: The texture is not shipped, or is no image.
    """
    path = texture_folder(name) / "albedo.png"
    if not path.is_file():
        known = ", ".join(sorted(item.name for item in path.parent.parent.glob("*") if item.is_dir())) or "(none)"
        raise RenderError(f"texture {name!r}: {path} does not exist; textures there: {known}")
    return _read(name, path, cv2.IMREAD_GRAYSCALE)


def _read(name: str, path: Path, mode: int) -> np.ndarray:
    image = cv2.imread(str(path), mode)
    if image is None:
        raise RenderError(f"texture {name!r}: {path} is not a readable image; bake the assets again")
    return image


_CORNER = 0.003
"""Place in the picture that faces without one show: paper, or bare board."""


WOUND = "film"
"""Texture that is pulled level around what stands in it, however high that is."""


def edge_order(
    extent: Float[np.ndarray, "*p 3"], wound: bool | Bool[np.ndarray, "*p"] = False
) -> Int[np.ndarray, "*p 3"]:
    """Return the axes from the longest edge (m) to the shortest; ties keep x, y, z.

    Edges that are equal to the centimetre tie: the skin of a carton must not turn its board.

    Args:
        extent: Edges along the part's axes (m).
        wound: Where the texture is ``WOUND``: z comes last.
    """
    level = np.where(np.asarray(wound)[..., None], extent * [1.0, 1.0, 0.0], extent)
    return np.argsort(-np.round(level, 2), axis=-1, kind="stable")


_CLEAR_LAYERS = 0.5
"""Opacity up to which film is layers of clear film; what is denser is dyed."""


def veil(material: Material) -> float:
    """Return the fraction of what lies behind that is covered by what ``material`` scatters, seen straight on, 0-1.

    Of the light that clear film stops, it scatters a third and mirrors the rest: the goods keep their colours behind
    it. Dye and all that is not film scatter or swallow what they stop. The third is a prior, without a source.
    """
    if material.texture != WOUND:
        return material.opacity
    clear = min(material.opacity, _CLEAR_LAYERS)
    return 1.0 - (1.0 - clear / 3.0) * (1.0 - material.opacity) / (1.0 - clear)


def texture_shift(instance_ids: Int[np.ndarray, "*p"], numbers: Int[np.ndarray, "*p"]) -> Float[np.ndarray, "*p 2"]:
    """Return where in its tile each part starts, so that no two boards show the same grain.

    The R2 low-discrepancy sequence (Roberts 2018) over object and part number.
    """
    step = np.array([0.7548776662466927, 0.5698402909980532])
    return (np.asarray(instance_ids * 131 + numbers)[..., None] * step) % 1.0


def box_projection(
    metres: Float[np.ndarray, "*c 3"], normals: Float[np.ndarray, "*#c 3"], order: Int[np.ndarray, "*#c 3"]
) -> Float[np.ndarray, "*c 2"]:
    """Return how far along u and v (m) each corner lies: on the axis that its face looks at most, x before y before z.

    Args:
        metres: Corners in the frame of their part (m).
        normals: Unit normals of their faces in that frame.
        order: ``edge_order`` of the part; u runs along its longest edge.
    """
    facing = np.abs(normals).argmax(axis=-1)
    u = np.where(order[..., 0] == facing, order[..., 1], order[..., 0])
    v = 3 - u - facing
    handed = np.where((u + 1) % 3 == v, 1.0, -1.0)
    towards = np.take_along_axis(normals, facing[..., None], axis=-1)[..., 0]
    along_u, along_v = (np.take_along_axis(metres, axis[..., None], axis=-1)[..., 0] for axis in (u, v))
    return np.stack([along_u, along_v * np.where(towards < 0, -handed, handed)], axis=-1)


def picture_coordinates(
    metres: Float[np.ndarray, "*c 3"], normals: Float[np.ndarray, "*c 3"]
) -> Float[np.ndarray, "*c 2"]:
    """Return u to the right and v downwards, 0-1 over the largest faces of one part, of each corner.

    Args:
        metres: Corners in the part's own frame (m).
        normals: Unit normals of their faces there.
    """
    flat = metres.reshape(-1, 3)
    low, extent = flat.min(axis=0), np.ptp(flat, axis=0)
    facing = int(np.argmin(extent))
    up = 1 if facing == 2 else 2
    across = 3 - facing - up
    at = (metres - low) / np.maximum(extent, 1e-6)
    mirrored = (normals[..., facing] < 0.0) != (facing == 1)
    laid = np.stack([np.where(mirrored, 1.0 - at[..., across], at[..., across]), 1.0 - at[..., up]], axis=-1)
    return np.where((np.abs(normals[..., facing]) > 0.7)[..., None], laid, _CORNER)


def picture_albedo(material: Material) -> Float32[np.ndarray, "h w 3"]:
    """Return the linear albedo of ``material`` under its picture; row 0 is the picture's upper edge.

    Raises:
        ValueError: It has no picture.
    """
    if material.picture is None:
        raise ValueError(f"material {material.name!r} has no picture")
    from warehouse_sim.catalog.pictures.draw import draw_picture  # recipes and lists need none

    image = draw_picture(material.picture)
    cover = image[..., 3:].astype(np.float32) / 255.0
    ink = linear_from_srgb(image[..., :3] / 255.0).astype(np.float32)
    return np.array(material.base_color, np.float32) * (1.0 - cover) + ink * cover
