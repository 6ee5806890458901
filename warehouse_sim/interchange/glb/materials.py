"""Materials as glTF's metallic-roughness model has them, with textures that are stored once."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from warehouse_sim.interchange.glb.container import GlbContainer
from warehouse_sim.interchange.surfaces import Surface, SurfaceImage, encode_png, render_surface_image, surface_of
from warehouse_sim.schema import Material

_CLAMP, _REPEAT, _LINEAR, _MIPMAPS = 33071, 10497, 9729, 9987
STRENGTH = "KHR_materials_emissive_strength"


class GlbMaterials:
    """The materials of a scene in a file, each added when it is first requested."""

    def __init__(self, container: GlbContainer, materials: Mapping[str, Material]) -> None:
        self._container, self._materials = container, materials
        self._made: dict[str, int] = {}
        self._textures: dict[SurfaceImage, int] = {}
        self._samplers: dict[bool, int] = {}
        self._surfaces: dict[str, Surface] = {}

    def surface(self, name: str) -> Surface:
        """Return how the material called ``name`` looks."""
        if name not in self._surfaces:
            self._surfaces[name] = surface_of(self._materials[name])
        return self._surfaces[name]

    def index(self, name: str) -> int:
        """Return the index in the file of the material called ``name``."""
        if name not in self._made:
            self._made[name] = self._container.add("materials", self._describe(name))
        return self._made[name]

    def _describe(self, name: str) -> dict[str, Any]:
        surface, material = self.surface(name), self._materials[name]
        shading: dict[str, Any] = {
            "baseColorFactor": [*surface.color, surface.opacity],
            "metallicFactor": surface.metallic,
            "roughnessFactor": surface.roughness,
        }
        item: dict[str, Any] = {"name": name, "pbrMetallicRoughness": shading}
        if surface.albedo is not None:
            shading["baseColorTexture"] = {"index": self._texture(surface.albedo, material)}
        if surface.bumps is not None:
            shading["metallicRoughnessTexture"] = {"index": self._texture(surface.bumps, material)}
        if surface.normal is not None:
            item["normalTexture"] = {"index": self._texture(surface.normal, material)}
        peak = max(surface.emitted)
        if peak > 0.0:
            item["emissiveFactor"] = [channel / peak for channel in surface.emitted]
            item["extensions"] = {STRENGTH: {"emissiveStrength": peak}}
        if surface.opacity < 1.0:
            item["alphaMode"] = "BLEND"
        return item

    def _texture(self, image: SurfaceImage, material: Material) -> int:
        if image not in self._textures:
            pixels = render_surface_image(image, material)
            if image.kind == "roughness":
                # Green is roughness and blue a factor on the metalness, which the material alone decides.
                white = np.full_like(pixels, 255)
                pixels = np.stack([white, pixels, white], axis=-1)
            source = self._container.add_png(encode_png(pixels), f"{image.source}/{image.kind}")
            item = {"source": source, "sampler": self._sampler(image.repeats)}
            self._textures[image] = self._container.add("textures", item)
        return self._textures[image]

    def _sampler(self, repeats: bool) -> int:
        if repeats not in self._samplers:
            wrap = _REPEAT if repeats else _CLAMP
            item = {"magFilter": _LINEAR, "minFilter": _MIPMAPS, "wrapS": wrap, "wrapT": wrap}
            self._samplers[repeats] = self._container.add("samplers", item)
        return self._samplers[repeats]
