"""A scene as a MuJoCo model that is only looked at: meshes, materials and lights, nothing that collides or moves."""

from dataclasses import dataclass

import mujoco
import numpy as np
from jaxtyping import Int

from warehouse_sim.geometry.pose import quat_wxyz_from_matrix
from warehouse_sim.render.light_selection import reference_points, strongest_lights
from warehouse_sim.render.mujoco.appearance import add_background, add_light, add_material, measure_level
from warehouse_sim.render.painted_mesh import PaintedMesh, painted_meshes
from warehouse_sim.scene.lighting.photometry import as_cone
from warehouse_sim.schema import ObjectInstance, SceneSpec

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
