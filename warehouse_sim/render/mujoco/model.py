"""A scene as a MuJoCo model that is only looked at: meshes, materials and lights, nothing that collides or moves.

There is no exposure and no tone curve behind it, so both are put into the colours. At the reference illuminance, that
of surfaces before the viewpoints that face the lights, a material has the colour that the display transform gives it
there, and all lights and the even light together add up to one. Below it, display values follow the square root of
light, close to what sRGB does of it: a light's share falls with the distance, not with its square.
"""

from dataclasses import dataclass

import mujoco
import numpy as np
from jaxtyping import Float64, Int, UInt8

from warehouse_sim.geometry.pose import quat_wxyz_from_matrix
from warehouse_sim.render.display import to_display
from warehouse_sim.render.light_selection import (
    GROUND,
    even_illuminance,
    facing_illuminance,
    reference_points,
    strongest_lights,
)
from warehouse_sim.render.painted_mesh import PaintedMesh, painted_meshes
from warehouse_sim.render.textures import NO_CHANGE, albedo_factor, picture_albedo, veil
from warehouse_sim.scene.lighting.photometry import as_cone
from warehouse_sim.schema import Light, Material, ObjectInstance, SceneSpec

_TYPICAL_COSINE = 0.4
"""Of the incidence at which OpenGL's shading by the cosine meets the square root of light that displays show."""


@dataclass(frozen=True, eq=False)
class Level:
    """How a scene's light is turned into display values."""

    white: float
    """Linear image value of a white surface at the reference illuminance."""
    even: float
    """Display value of the even light, 0-1."""
    lights: Float64[np.ndarray, " n"]
    """Display value of each light on its axis at a metre's distance."""


def measure_level(scene: SceneSpec, lights: list[Light]) -> Level:
    """Return the level of ``scene`` under ``lights``."""
    even, points = even_illuminance(scene), reference_points(scene)
    lit = np.array([facing_illuminance(light, points) for light in lights]).reshape(len(lights), len(points))
    total = even + float(lit.sum(axis=0).mean()) if lights else even
    roots = float(np.sqrt(lit).sum(axis=0).mean()) if lights else 0.0
    even_level = float(np.sqrt(even / total)) if total > 0 else 1.0
    scale = (1.0 - even_level) / (np.sqrt(_TYPICAL_COSINE) * roots) if roots > 0 else 0.0
    white = scene.exposure * total / np.pi
    return Level(white, even_level, scale * np.sqrt([light.intensity for light in lights]))


def add_background(spec: mujoco.MjSpec, scene: SceneSpec) -> None:
    """Fill the image where nothing stands with the lower half of the even light."""
    linear = scene.ambient / np.pi * GROUND * scene.exposure
    color = to_display(np.full((1, 1, 3), linear))[0, 0] / 255.0
    kind, fill = mujoco.mjtTexture.mjTEXTURE_SKYBOX, mujoco.mjtBuiltin.mjBUILTIN_FLAT
    spec.add_texture(name="background", type=kind, builtin=fill, rgb1=color, rgb2=color, width=8, height=48)


def add_material(spec: mujoco.MjSpec, name: str, material: Material, white: float, exposure: float) -> None:
    """Add ``material``; a texture set contributes its albedo, and is added when it is first named.

    Blinn's exponent for a GGX lobe of width a is 2 / a^2 - 2 (Karis 2013), its peak (exponent + 8) / 8 * F0.
    """
    base = np.array(material.base_color)
    brightest, texture = 1.0, None
    if material.texture is not None:
        brightest = albedo_factor(material.texture).max() / NO_CHANGE
        texture = _texture(spec, material.texture)
    if material.picture is not None:
        base, brightest = np.ones(3), 1.0
        texture = _picture(spec, name, to_display(picture_albedo(material) * white))
    shown = np.full(3, 1.0) if material.picture else to_display((base * brightest * white)[None, None])[0, 0] / 255.0
    glow = to_display((base * material.emission * exposure)[None, None])[0, 0] / 255.0
    exponent = 2.0 / max(material.roughness, 0.1) ** 4 - 2.0
    f0 = float(np.mean(0.04 * (1.0 - material.metallic) + base * material.metallic))
    item = spec.add_material(
        name=name,
        rgba=[*(glow if material.emission > 0 else shown), veil(material)],
        emission=1.0 if material.emission > 0 else 0.0,
        specular=min((exponent + 8.0) / 8.0 * f0, 1.0),
        shininess=float(np.clip(exponent / 128.0, 0.0, 1.0)),
    )
    if texture is not None:
        names = [""] * mujoco.mjtTextureRole.mjNTEXROLE
        names[mujoco.mjtTextureRole.mjTEXROLE_RGB] = texture
        item.textures = names


def add_light(spec: mujoco.MjSpec, light: Light, level: float, casts_shadow: bool) -> None:
    """Add ``light`` with ``level``, its display value on the axis at a metre's distance.

    A point light is a spot whose cone is a half space: MuJoCo draws no point lights. The falloff of the cone is met
    where it is half.
    """
    inner, outer = (light.cone_inner, light.cone_outer) if light.kind == "spot" else (1.5, 1.57)
    half = 0.5 * (np.cos(inner) + np.cos(outer))
    spec.worldbody.add_light(
        type=mujoco.mjtLightType.mjLIGHT_SPOT,
        pos=light.position,
        dir=light.direction if light.kind == "spot" else (0.0, 0.0, -1.0),
        diffuse=level * np.array(light.color),
        specular=level * np.array(light.color),
        ambient=(0.0, 0.0, 0.0),
        attenuation=(0.0, 1.0, 0.0),
        cutoff=min(np.degrees(outer), 90.0),
        exponent=float(np.log(0.5) / np.log(max(half, 1e-3))),
        castshadow=casts_shadow,
    )


def _texture(spec: mujoco.MjSpec, name: str) -> str:
    if all(item.name != name for item in spec.textures):
        image = _display_factor(albedo_factor(name))
        item = spec.add_texture(name=name, type=mujoco.mjtTexture.mjTEXTURE_2D)
        item.height, item.width, item.nchannel = (*image.shape[:2], 3)
        item.data = image.tobytes()
    return name


def _picture(spec: mujoco.MjSpec, name: str, shown: UInt8[np.ndarray, "h w 3"]) -> str:
    """Add the texture of one material's picture in display values."""
    item = spec.add_texture(name=f"{name}/picture", type=mujoco.mjtTexture.mjTEXTURE_2D)
    item.height, item.width, item.nchannel = (*shown.shape[:2], 3)
    item.data = shown.tobytes()
    return f"{name}/picture"


def _display_factor(factor: UInt8[np.ndarray, "h w"]) -> UInt8[np.ndarray, "h w 3"]:
    """Return what a factor on the albedo, relative to the largest, does to a display value."""
    relative = np.sqrt(factor / max(int(factor.max()), 1))
    return np.repeat(np.rint(255.0 * relative).astype(np.uint8)[..., None], 3, axis=2)


_AFTER = np.array([1, 2, 0])
_SMALL = 2.0
"""Meshes that are nowhere this wide (m) are lit well enough at their corners."""
_STEPS = 32
"""Triangle edges along the longest side of a wide mesh."""
_MANY_FACES = 1000
"""Meshes of more faces are left alone: they are corrugated or perforated, and would become very many."""


def lit_at_vertices(mesh: PaintedMesh) -> PaintedMesh:
    """Return ``mesh`` with enough vertices that a light over the middle of a floor or a wall lights it."""
    extent = np.sort(np.ptp(mesh.positions, axis=0))
    if extent[1] < _SMALL or len(mesh.faces) > _MANY_FACES:
        return mesh
    return tessellate(mesh, max(float(extent[2]) / _STEPS, 1.0))


def tessellate(mesh: PaintedMesh, longest: float) -> PaintedMesh:
    """Return ``mesh`` with triangles whose edges are at most ``longest`` (m), by bisecting longest edges.

    Whether and where an edge is cut depends on nothing but its ends, so that neighbours stay without gaps.
    """
    positions, normals, tiles, faces = mesh.positions, mesh.normals, mesh.tiles, mesh.faces
    while True:
        corners = positions[faces]
        lengths = np.linalg.norm(corners[:, _AFTER] - corners, axis=2)  # of the edges that start at each corner
        cut = np.flatnonzero(lengths.max(axis=1) > longest)
        if len(cut) == 0:
            return PaintedMesh(positions, normals, tiles, faces)
        start = lengths[cut].argmax(axis=1)
        a, b = faces[cut, start], faces[cut, _AFTER[start]]
        opposite = faces[cut, _AFTER[_AFTER[start]]]
        middle = (len(positions) + np.arange(len(cut))).astype(np.int32)
        positions = np.concatenate([positions, (positions[a] + positions[b]) / 2])
        tiles = np.concatenate([tiles, (tiles[a] + tiles[b]) / 2])
        normals = np.concatenate([normals, normals[a]])  # flat: equal at all three corners
        kept = np.delete(faces, cut, axis=0)
        halves = [np.stack(corners, axis=1) for corners in ((a, middle, opposite), (middle, b, opposite))]
        faces = np.concatenate([kept, *halves])


SOLID, FILM, ALONE = 0, 1, 2
"""Geom groups: what has depth and an id, what only tints the image, what is rendered by itself."""
MAX_LIGHTS = 7
"""The fixed-function pipeline has eight lights, and the even light takes one."""


@dataclass(frozen=True, eq=False)
class VisualModel:
    """The compiled model and who owns its geoms."""

    model: mujoco.MjModel
    owner: Int[np.ndarray, " n"]
    """Instance id of each geom."""
    group: Int[np.ndarray, " n"]
    """``SOLID`` or ``FILM``."""


def build_visual_model(scene: SceneSpec, shadow_px: int) -> VisualModel:
    """Compile ``scene``: one mesh for each model, paint and material, one geom for each instance and material.

    Args:
        scene: What to draw.
        shadow_px: Edge of each light's shadow map; 0 = no light casts a shadow.
    """
    spec = mujoco.MjSpec()
    spec.memory = 1 << 20  # nothing touches: the arena stays empty
    spec.visual.quality.shadowsize = shadow_px
    spec.visual.map.shadowscale = 1.0  # the map covers the whole cone
    add_background(spec, scene)
    lights = [as_cone(light) for light in strongest_lights(scene.lights, MAX_LIGHTS, reference_points(scene))]
    level = measure_level(scene, lights)
    spec.visual.headlight.ambient = [level.even] * 3
    spec.visual.headlight.diffuse = spec.visual.headlight.specular = [0.0] * 3
    for light, value in zip(lights, level.lights, strict=True):
        add_light(spec, light, float(value), shadow_px > 0 and light.casts_shadow and light.kind == "spot")
    owner: list[int] = []
    group: list[int] = []
    known: dict[object, dict[str, str]] = {}
    for instance in scene.instances:
        if instance.look not in known:
            known[instance.look] = _add_meshes(spec, scene, instance, level.white, len(known))
        for material, mesh in known[instance.look].items():
            film = scene.materials[material].opacity < 1.0
            _add_geom(spec, instance, mesh, material, FILM if film else SOLID)
            owner.append(instance.instance_id)
            group.append(FILM if film else SOLID)
    return VisualModel(spec.compile(), np.array(owner, np.int32), np.array(group, np.int32))


def _add_meshes(
    spec: mujoco.MjSpec, scene: SceneSpec, instance: ObjectInstance, white: float, look: int
) -> dict[str, str]:
    """Add the meshes of an object and the materials they name, as look number ``look``; return each material's mesh."""
    meshes, model = {}, scene.painted_model_of(instance)
    for number, (material, painted) in enumerate(painted_meshes(model, scene.materials).items()):
        if spec.material(material) is None:
            add_material(spec, material, scene.materials[material], white, scene.exposure)
        meshes[material] = f"{model.name}:{look}:{number}"
        _add_mesh(spec, meshes[material], lit_at_vertices(painted))
    return meshes


def _add_mesh(spec: mujoco.MjSpec, name: str, painted: PaintedMesh) -> None:
    mesh = spec.add_mesh(name=name)
    mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL  # a sheet has no volume, and needs none to be seen
    mesh.uservert = painted.positions.ravel()
    mesh.usernormal = painted.normals.ravel()
    mesh.usertexcoord = painted.tiles.ravel()
    mesh.userface = painted.faces.ravel()


def _add_geom(spec: mujoco.MjSpec, instance: ObjectInstance, mesh: str, material: str, group: int) -> None:
    spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_MESH,
        meshname=mesh,
        material=material,
        pos=instance.T_world_object[:3, 3],
        quat=quat_wxyz_from_matrix(instance.T_world_object[:3, :3]),
        contype=0,
        conaffinity=0,
        group=group,
        castshadow=group != FILM,
    )
