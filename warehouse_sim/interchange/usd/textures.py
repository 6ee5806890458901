"""The image files beside a stage: shipped texture sets as they are, pictures with the colour behind them."""

import hashlib
from pathlib import Path

import cv2
import numpy as np

from warehouse_sim.color import srgb_from_linear
from warehouse_sim.errors import RenderError
from warehouse_sim.interchange.usd.bindings import bindings
from warehouse_sim.output import make_folder, write_bytes
from warehouse_sim.render.textures import albedo_factor, picture_albedo
from warehouse_sim.resources import texture_folder
from warehouse_sim.schema import Material

FOLDER = "textures"
"""Beside the stage; stages of one folder share it, since a name stands for one content."""


class Textures:
    """What a stage refers to, by its path relative to the stage, until it is saved."""

    def __init__(self) -> None:
        self._content: dict[str, bytes] = {}
        self._pictures: dict[tuple[str, tuple[float, float, float]], str] = {}

    def of_set(self, name: str) -> dict[str, str]:
        """Return the relative path of each map of the texture set called ``name``: albedo, normal, roughness.

        Raises:
            RenderError: The texture is not shipped.
        """
        albedo_factor(name)  # rejects what no renderer could draw
        maps = {}
        for kind in ("albedo", "normal", "roughness"):
            path = texture_folder(name) / f"{kind}.png"
            if path.is_file():
                relative = f"./{FOLDER}/{bindings().Tf.MakeValidIdentifier(name)}_{kind}.png"
                if relative not in self._content:
                    self._content[relative] = path.read_bytes()
                maps[kind] = relative
        return maps

    def of_picture(self, material: Material) -> str:
        """Return the relative path of a material's picture over its base colour, an sRGB image."""
        assert material.picture is not None
        key = material.picture, material.base_color
        if key not in self._pictures:
            code = np.rint(255.0 * srgb_from_linear(np.clip(picture_albedo(material), 0.0, 1.0))).astype(np.uint8)
            done, data = cv2.imencode(".png", code[..., ::-1])
            if not done:
                raise RenderError(f"picture {material.picture!r} cannot be written as PNG")
            kind = bindings().Tf.MakeValidIdentifier(material.picture.partition(":")[0])
            relative = f"./{FOLDER}/{kind}_{_mark(data.tobytes())}.png"
            self._content[relative] = data.tobytes()
            self._pictures[key] = relative
        return self._pictures[key]

    def add(self, stem: str, suffix: str, data: bytes) -> str:
        """Return the relative path of another file, named after its content."""
        relative = f"./{FOLDER}/{bindings().Tf.MakeValidIdentifier(stem)}_{_mark(data)}{suffix}"
        self._content[relative] = data
        return relative

    def save(self, folder: Path) -> None:
        """Write all files below ``folder``, where the stage is.

        Raises:
            OutputError: One cannot be written.
        """
        if self._content:
            make_folder(folder / FOLDER)
        for relative, data in self._content.items():
            write_bytes(folder / relative, data)


def _mark(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()[:12]
