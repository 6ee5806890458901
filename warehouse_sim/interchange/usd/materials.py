"""Materials as UsdPreviewSurface (openusd.org, "UsdPreviewSurface Specification") with the renderers' textures.

A shipped albedo is a factor on the base colour, 128 = 1: it is read raw and scaled by the colour, so that hundreds of
colours share one image. Under a picture there is no detail texture, as in the backends that know textures only.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from warehouse_sim.errors import DatasetError
from warehouse_sim.interchange.usd.bindings import bindings
from warehouse_sim.interchange.usd.record import Record, keep
from warehouse_sim.interchange.usd.textures import Textures
from warehouse_sim.render.textures import NO_CHANGE
from warehouse_sim.schema import Material

_FACTOR = 255.0 / NO_CHANGE
_SURFACE = "surface"


def add_material(stage: Any, path: str, material: Material, textures: Textures) -> Any:
    """Define ``material`` at ``path`` and return its prim.

    Inputs that a texture drives keep their plain value beside the connection: it is what ``read_material`` returns.

    Raises:
        RenderError: Its texture is not shipped.
    """
    pxr = bindings()
    kinds = pxr.Sdf.ValueTypeNames
    bound = pxr.Shade.Material.Define(stage, path)
    surface = pxr.Shade.Shader.Define(stage, f"{path}/{_SURFACE}")
    surface.CreateIdAttr("UsdPreviewSurface")
    base = tuple(map(float, material.base_color))
    glow = tuple(channel * material.emission for channel in base)
    surface.CreateInput("diffuseColor", kinds.Color3f).Set(base)
    surface.CreateInput("roughness", kinds.Float).Set(material.roughness)
    surface.CreateInput("metallic", kinds.Float).Set(material.metallic)
    if material.opacity < 1.0:
        surface.CreateInput("opacity", kinds.Float).Set(material.opacity)
    if material.emission > 0.0:
        surface.CreateInput("emissiveColor", kinds.Color3f).Set(glow)
    bound.CreateSurfaceOutput().ConnectToSource(surface.ConnectableAPI(), "surface")
    _add_textures(stage, path, surface, material, textures)
    keep(
        bound.GetPrim(),
        {
            "name": material.name,
            "texture": material.texture,
            "texture_size": material.texture_size,
            "remission": material.remission,
            "emission": material.emission,
            "picture": material.picture,
        },
    )
    return bound


def _add_textures(stage: Any, path: str, surface: Any, material: Material, textures: Textures) -> None:
    kinds = bindings().Sdf.ValueTypeNames
    if material.picture is not None:
        image = _image(stage, f"{path}/picture", textures.of_picture(material), "sRGB", "clamp")
        _connect(surface.GetInput("diffuseColor"), image, "rgb")
        if material.emission > 0.0:
            lit = _image(stage, f"{path}/glow", textures.of_picture(material), "sRGB", "clamp", [material.emission] * 3)
            _connect(surface.GetInput("emissiveColor"), lit, "rgb")
    elif material.texture is not None:
        maps = textures.of_set(material.texture)
        tint = [_FACTOR * channel for channel in material.base_color]
        _connect(surface.GetInput("diffuseColor"), _image(stage, f"{path}/albedo", maps["albedo"], scale=tint), "rgb")
        if "roughness" in maps:
            gloss = [_FACTOR * material.roughness] * 3
            _connect(surface.GetInput("roughness"), _image(stage, f"{path}/gloss", maps["roughness"], scale=gloss), "r")
        if "normal" in maps:
            bent = _image(stage, f"{path}/normal", maps["normal"], scale=[2.0] * 3, bias=[-1.0] * 3)
            _connect(surface.CreateInput("normal", kinds.Normal3f), bent, "rgb")


def _image(
    stage: Any,
    path: str,
    file: str,
    space: str = "raw",
    wrap: str = "repeat",
    scale: Sequence[float] | None = None,
    bias: Sequence[float] | None = None,
) -> Any:
    """Define a texture reader at ``path``, and beside it, once a material, what gives it the coordinates."""
    pxr = bindings()
    kinds = pxr.Sdf.ValueTypeNames
    place = pxr.Shade.Shader.Define(stage, pxr.Sdf.Path(path).GetParentPath().AppendChild("coordinates"))
    if not place.GetIdAttr().HasAuthoredValue():
        place.CreateIdAttr("UsdPrimvarReader_float2")
        place.CreateInput("varname", kinds.String).Set("st")
        place.CreateOutput("result", kinds.Float2)
    image = pxr.Shade.Shader.Define(stage, path)
    image.CreateIdAttr("UsdUVTexture")
    image.CreateInput("file", kinds.Asset).Set(pxr.Sdf.AssetPath(file))
    image.CreateInput("sourceColorSpace", kinds.Token).Set(space)
    image.CreateInput("wrapS", kinds.Token).Set(wrap)
    image.CreateInput("wrapT", kinds.Token).Set(wrap)
    image.CreateInput("st", kinds.Float2).ConnectToSource(place.ConnectableAPI(), "result")
    if scale is not None:
        image.CreateInput("scale", kinds.Float4).Set(pxr.Gf.Vec4f(*scale, 1.0))
    if bias is not None:
        image.CreateInput("bias", kinds.Float4).Set(pxr.Gf.Vec4f(*bias, 0.0))
    return image


def _connect(target: Any, image: Any, channel: str) -> None:
    kinds = bindings().Sdf.ValueTypeNames
    image.CreateOutput(channel, kinds.Float3 if channel == "rgb" else kinds.Float)
    target.ConnectToSource(image.ConnectableAPI(), channel)


def read_material(path: Path, prim: Any) -> Material:
    """Return the material of a prim that ``add_material`` defined.

    Raises:
        DatasetError: It has no surface, or a value that cannot be used.
    """
    pxr = bindings()
    surface = pxr.Shade.Shader(prim.GetChild(_SURFACE))
    if not surface or surface.GetIdAttr().Get() != "UsdPreviewSurface":
        raise DatasetError(
            f"{path}: {prim.GetPath()} has no UsdPreviewSurface called {_SURFACE}; write the scene again"
        )

    def value(name: str, default: Any) -> Any:
        given = surface.GetInput(name)
        found = given.GetAttr().Get() if given else None
        return default if found is None else found

    record = Record(path, prim)
    base = np.array(value("diffuseColor", (0.18, 0.18, 0.18)), float)  # the specification's own default
    glow = np.array(value("emissiveColor", (0.0, 0.0, 0.0)), float)
    # Black emits nothing that could be seen: what was requested of it stands in the record alone.
    emission = float(glow.max() / base.max()) if base.max() > 0.0 else record.get("emission", float, 0.0)
    numbers = {name: float(value(name, default)) for name, default in (("roughness", 0.5), ("metallic", 0.0))}
    opacity = float(value("opacity", 1.0))
    if not np.isfinite([*base, emission, *numbers.values(), opacity]).all() or min(base.min(), emission) < 0.0:
        record.reject("inputs of the surface", [*base, emission, *numbers.values()], "finite and not negative")
    return Material(
        name=record.get("name", str, prim.GetName()),
        base_color=(float(base[0]), float(base[1]), float(base[2])),
        **numbers,
        texture=record.get("texture", str, None),
        texture_size=record.get("texture_size", float, 1.0),
        remission=record.get("remission", float, 0.5),
        emission=emission,
        opacity=opacity,
        picture=record.get("picture", str, None),
    )
