"""Lights as UsdLux: intensity 1 is a luminance of 1 cd/m^2 (openusd.org, "LightAPI", quantities and units).

A light of ours has the same intensity in all directions of its cone, as a ball of even luminance L and radius r has:
I = L pi r^2. Spots are balls with ``ShapingAPI``; they shine along their own -z, and a distribution begins at their x.
Between the angles of a cone ours fades as the square of a line in the cosine, USD's as a smoothstep in the angle.
"""

from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from warehouse_sim.errors import ConfigError, DatasetError
from warehouse_sim.geometry.pose import Transform, make_transform
from warehouse_sim.interchange.usd.bindings import bindings, place, world_pose
from warehouse_sim.interchange.usd.record import Record, keep
from warehouse_sim.interchange.usd.textures import Textures
from warehouse_sim.scene.lighting.ies_file import load_distribution
from warehouse_sim.scene.lighting.photometry import luminous_flux
from warehouse_sim.schema import IntensityDistribution, Light
from warehouse_sim.schema.intensity import ANGLES, PLANES


def ies_text(distribution: IntensityDistribution) -> str:
    """Return the file of a distribution whose candela are fractions of the greatest.

    A light's luminance is multiplied by what the file says (openusd.org, "ShapingAPI", shaping:ies:file), so that 1 is
    the light's own. Nine digits keep single precision.
    """
    angles = " ".join(f"{angle:g}" for angle in np.linspace(0.0, 180.0, ANGLES))
    planes = " ".join(f"{plane:g}" for plane in np.arange(PLANES + 1) * (360.0 / PLANES))
    fraction = np.concatenate([distribution.fraction, distribution.fraction[:1]])
    rows = [_wrapped(" ".join(f"{value:.9g}" for value in row)) for row in fraction]
    head = ["IESNA:LM-63-2002", "[TEST] none: candela relative to the greatest", "[MANUFAC] none", "TILT=NONE"]
    numbers = f"1 -1 1 {ANGLES} {PLANES + 1} 1 2 0 0 0"
    return "\n".join([*head, numbers, "1 1 0", _wrapped(angles), _wrapped(planes), *rows]) + "\n"


def _wrapped(text: str) -> str:
    """Break lines after at most 132 characters, which LM-63 allows."""
    lines, line = list[str](), ""
    for word in text.split():
        if len(line) + len(word) > 130:
            lines.append(line)
            line = ""
        line = f"{line} {word}" if line else word
    return "\n".join([*lines, line])


_POINT = 0.001
"""Radius (m) of what has none: luminance needs a surface."""


def add_light(stage: Any, path: str, light: Light, textures: Textures) -> Any:
    """Define ``light`` and return its prim."""
    pxr = bindings()
    radius = max(light.radius, _POINT)
    ball = pxr.Lux.SphereLight.Define(stage, path)
    prim = ball.GetPrim()
    ball.CreateRadiusAttr(radius)
    ball.CreateExtentAttr([pxr.Gf.Vec3f(-radius), pxr.Gf.Vec3f(radius)])
    ball.CreateTreatAsPointAttr(light.radius == 0.0)
    ball.CreateIntensityAttr(light.intensity / (np.pi * radius**2))
    ball.CreateColorAttr(pxr.Gf.Vec3f(*map(float, light.color)))
    pxr.Lux.ShadowAPI.Apply(prim).CreateShadowEnableAttr(light.casts_shadow)
    place(prim, _frame(light))
    if light.kind == "spot":
        shaping = pxr.Lux.ShapingAPI.Apply(prim)
        shaping.CreateShapingConeAngleAttr(np.degrees(light.cone_outer))
        softness = 1.0 - light.cone_inner / light.cone_outer if light.cone_outer > 0.0 else 0.0
        shaping.CreateShapingConeSoftnessAttr(softness)
        if light.distribution is not None:
            file = textures.add(light.distribution.name, ".ies", ies_text(light.distribution).encode())
            shaping.CreateShapingIesFileAttr(pxr.Sdf.AssetPath(file))
    keep(
        prim,
        {
            "candela": light.intensity,
            "lumen": luminous_flux(light),
            "fill": light.fill or None,
            "distribution": None if light.distribution is None else light.distribution.name,
            "distribution_peak": None if light.distribution is None else light.distribution.peak,
            "along": np.array(light.along) if light.distribution is None and light.along != Light.along else None,
        },
    )
    return prim


def _frame(light: Light) -> Transform:
    """Return the pose of a light: z against its direction, x along its length as far as that is across."""
    z = -np.asarray(light.direction, float) if light.kind == "spot" else np.array([0.0, 0.0, 1.0])
    z = z / np.linalg.norm(z)
    x = np.asarray(light.along, float)
    x = x - z * (x @ z)
    if np.linalg.norm(x) < 1e-6:
        x = np.cross(np.eye(3)[np.abs(z).argmin()], z)
    x = x / np.linalg.norm(x)
    return make_transform(np.stack([x, np.cross(z, x), z], axis=1), np.asarray(light.position, float))


def read_light(path: Path, prim: Any, cache: Any) -> Light:
    """Return the light of a prim, where a ``UsdGeom.XformCache`` has it.

    Raises:
        DatasetError: A value or its IES file cannot be used.
    """
    pxr, record = bindings(), Record(path, prim)
    ball = pxr.Lux.SphereLight(prim)
    is_point = bool(ball.GetTreatAsPointAttr().Get())
    area = np.pi * float(ball.GetRadiusAttr().Get()) ** 2
    luminance = float(ball.GetIntensityAttr().Get()) * 2.0 ** float(ball.GetExposureAttr().Get())
    color = tuple(map(float, ball.GetColorAttr().Get()))
    shadow = pxr.Lux.ShadowAPI(prim).GetShadowEnableAttr().Get() if prim.HasAPI(pxr.Lux.ShadowAPI) else True
    T_world_light = world_pose(cache, prim)
    if not np.isfinite([luminance, area, *color]).all() or min(luminance, area, *color) < 0.0:
        record.reject("intensity, radius and color", (luminance, area, color), "finite and not negative")
    kind: Literal["spot", "point"] = "spot" if prim.HasAPI(pxr.Lux.ShapingAPI) else "point"
    light = Light(
        kind=kind,
        position=T_world_light[:3, 3],
        direction=-T_world_light[:3, 2],
        intensity=luminance * area,
        color=(color[0], color[1], color[2]),
        casts_shadow=bool(shadow),
        radius=0.0 if is_point else float(ball.GetRadiusAttr().Get()),
        fill=record.get("fill", bool, False),
    )
    return light if kind == "point" else _shaped(path, light, prim, record, T_world_light)


def _shaped(path: Path, light: Light, prim: Any, record: Record, T_world_light: Transform) -> Light:
    shaping = bindings().Lux.ShapingAPI(prim)
    outer = float(np.radians(shaping.GetShapingConeAngleAttr().Get()))
    inner = outer * (1.0 - float(shaping.GetShapingConeSoftnessAttr().Get()))
    light = replace(light, cone_inner=inner, cone_outer=outer)
    if "along" in record:
        x, y, z = map(float, record.numbers("along", 3))
        light = replace(light, along=(x, y, z))
    asset = shaping.GetShapingIesFileAttr().Get()
    if asset is None or not asset.path:
        return light
    file = Path(asset.resolvedPath or path.parent / asset.path)
    if not file.resolve().is_relative_to(path.parent.resolve()):
        raise DatasetError(f"{path}: {prim.GetPath()} names {asset.path}, outside the scene's folder; copy it there")
    try:
        distribution = load_distribution(file)
    except ConfigError as problem:
        raise DatasetError(f"{path}: {prim.GetPath()}: {problem}") from problem
    named = replace(
        distribution,
        name=record.get("distribution", str, distribution.name),
        peak=record.get("distribution_peak", float, distribution.peak),
    )
    x, y, z = map(float, T_world_light[:3, 0])
    return replace(light, distribution=named, along=(x, y, z))


def add_even_light(stage: Any, path: str, ambient: float) -> None:
    """Define the light from everywhere above: E = pi L on what lies level (lx)."""
    bindings().Lux.DomeLight.Define(stage, path).CreateIntensityAttr(ambient / np.pi)


def read_even_light(prim: Any) -> float:
    """Return the illuminance (lx) of what ``add_even_light`` defined; 0 where there is none."""
    dome = bindings().Lux.DomeLight(prim) if prim else None
    return float(dome.GetIntensityAttr().Get()) * np.pi if dome else 0.0
