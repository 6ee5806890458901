"""A whole scene as binary glTF: objects, lights in candela, cameras, and what else of it a reader may need."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float

from warehouse_sim.errors import OutputError
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform, make_transform, quat_wxyz_from_matrix, rotation_x
from warehouse_sim.interchange.glb.container import GlbContainer
from warehouse_sim.interchange.rig_cameras import rig_cameras
from warehouse_sim.interchange.surfaces import Surface, SurfaceImage, encode_png, render_surface_image, surface_of
from warehouse_sim.output import make_folder, write_bytes
from warehouse_sim.render.painted_mesh import PaintedMesh, painted_meshes, require_renderable
from warehouse_sim.scene.lighting.photometry import as_cone
from warehouse_sim.schema import Light, Material, ObjectInstance, SceneSpec
from warehouse_sim.sensors.rig import RigConfig

_CLAMP, _REPEAT, _LINEAR, _MIPMAPS = 33071, 10497, 9729, 9987
_STRENGTH = "KHR_materials_emissive_strength"


class GlbMaterials:
    """The materials of a scene in a file, each added when it is first requested.

    They are glTF's metallic-roughness model, with textures that are stored once.
    """

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
            item["extensions"] = {_STRENGTH: {"emissiveStrength": peak}}
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


class GlbMeshes:
    """The meshes of a scene in a file, each added when it is first requested."""

    def __init__(self, container: GlbContainer, scene: SceneSpec, materials: GlbMaterials) -> None:
        self._container, self._scene, self._materials = container, scene, materials
        self._made: dict[object, int | None] = {}

    def index(self, instance: ObjectInstance) -> int | None:
        """Return the index in the file of what ``instance`` looks like; None where nothing is to be seen of it."""
        if instance.look not in self._made:
            self._made[instance.look] = self._add(instance)
        return self._made[instance.look]

    def _add(self, instance: ObjectInstance) -> int | None:
        model = self._scene.model_of(instance)
        # Grouped by the model's own materials and laid out by the painted ones: positions are the same in any paint.
        painted = {part.material: instance.material_of(part) for part in model.parts}
        looks = {own: self._scene.materials[name] for own, name in painted.items()}
        pieces = painted_meshes(model, looks)
        primitives = [self._primitive(_renderable(mesh), painted[own]) for own, mesh in pieces.items()]
        present = [item for item in primitives if item is not None]
        return self._container.add("meshes", {"name": instance.model, "primitives": present}) if present else None

    def _primitive(self, mesh: PaintedMesh, name: str) -> dict[str, object] | None:
        if len(mesh.faces) == 0:
            return None
        surface, container = self._materials.surface(name), self._container
        attributes = {
            "POSITION": container.add_vectors(mesh.positions, bounds=True),
            "NORMAL": container.add_vectors(mesh.normals),
        }
        if surface.normal is not None:
            attributes["TANGENT"] = container.add_vectors(tangents(mesh))
        if surface.albedo is not None:
            attributes["TEXCOORD_0"] = container.add_vectors(mesh.tiles)
        indices, material = container.add_indices(mesh.faces), self._materials.index(name)
        return {"attributes": attributes, "indices": indices, "material": material}


def tangents(mesh: PaintedMesh) -> Float[np.ndarray, "n 4"]:
    """Return unit tangents along growing u, and -1: the third axis, up the image, points against v.

    The gradient of u over each triangle, from its edges e and their steps in u:
    (du1 e2 x n + du2 n x e1) / (n . e1 x e2).
    """
    a, b, c = (mesh.positions[mesh.faces[:, corner]] for corner in range(3))
    u = mesh.tiles[mesh.faces, 0]
    normal = mesh.normals[mesh.faces[:, 0]]
    first, second = (u[:, 1] - u[:, 0])[:, None], (u[:, 2] - u[:, 0])[:, None]
    gradient = first * np.cross(c - a, normal) + second * np.cross(normal, b - a)
    found = np.zeros_like(mesh.positions)
    for corner in range(3):
        np.add.at(found, mesh.faces[:, corner], gradient)  # weighted by area; all of a vertex point the same way
    length = np.linalg.norm(found, axis=1, keepdims=True)
    # Where the picture lies with one texel on a face, u does not grow: any direction across the normal will do.
    spare = np.cross(mesh.normals, np.eye(3)[np.abs(mesh.normals).argmin(axis=1)])
    spare /= np.linalg.norm(spare, axis=1, keepdims=True)
    along = np.where(length > 1e-12, found / np.maximum(length, 1e-12), spare)
    return np.concatenate([along, np.full((len(along), 1), -1.0)], axis=1)


def _renderable(mesh: PaintedMesh) -> PaintedMesh:
    """Return ``mesh`` with unit normals: triangles without area, which have none, are left out."""
    length = np.linalg.norm(mesh.normals, axis=1)
    faces = mesh.faces[length[mesh.faces].min(axis=1) > 0.5]
    used, renumbered = np.unique(faces, return_inverse=True)
    if len(used) == len(mesh.positions):
        return mesh
    numbers = renumbered.reshape(-1, 3).astype(np.int32)
    return PaintedMesh(mesh.positions[used], mesh.normals[used], mesh.tiles[used], numbers)


# glTF is y up; its cameras and spots look along -z with y up.
_T_GLTF_WORLD = make_transform(rotation_x(-np.pi / 2), np.zeros(3))
_T_CAMERA_EYE = np.diag([1.0, -1.0, -1.0, 1.0])
_LIGHTS = "KHR_lights_punctual"
_NEAR, _FAR = 0.05, 1000.0
_WIDEST = np.pi / 2


def write_glb(scene: SceneSpec, path: Path, rig: RigConfig | None = None) -> Path:
    """Write ``scene`` to ``path``: each geometry once, an object a node, textures, lights and cameras.

    ``write_glb(prepared.scene, Path("scene.glb"), recipe.sensors)`` writes what ``prepare_scene`` returned.

    Objects are named by instance id and class, and carry ``instance_id``, ``class_name`` and ``obj_id`` as extras.
    Lights are in candela, surfaces that glow in cd/m^2. The scene's extras hold what glTF has no place for: its even
    light (lx) and its exposure.

    Args:
        scene: Settled or not, lit or not.
        path: File to write, usually .glb.
        rig: Whose cameras stand at the viewpoints; None = no cameras.

    Raises:
        RenderError: The scene is empty, or an object of it cannot be drawn.
        OutputError: The file cannot be written, or is larger than 4 GiB.
    """
    require_renderable(scene)
    container = GlbContainer({"version": "2.0", "generator": "warehouse-sim"})
    materials = GlbMaterials(container, scene.materials)
    meshes = GlbMeshes(container, scene, materials)
    nodes = [_object_node(container, scene, item, meshes.index(item)) for item in scene.instances]
    nodes += _light_nodes(container, scene)
    nodes += _camera_nodes(container, scene, rig)
    turned = container.add("nodes", {"name": "world", **_placed(_T_GLTF_WORLD), "children": nodes})
    extras = {"scene_index": scene.scene_index, "seed": scene.seed, "lighting": scene.lighting}
    extras |= {"ambient_lux": scene.ambient, "exposure": scene.exposure}
    root = container.add("scenes", {"name": f"scene_{scene.scene_index:06d}", "nodes": [turned], "extras": extras})
    container.set("scene", root)
    glows = any(max(materials.surface(name).emitted) > 0.0 for name in _used(scene))
    used = [name for name, present in ((_STRENGTH, glows), (_LIGHTS, bool(scene.lights))) if present]
    if used:
        container.set("extensionsUsed", used)
    make_folder(path.parent)
    try:
        data = container.to_bytes()
    except OverflowError as problem:
        raise OutputError(f"{path}: GLB holds at most 4 GiB, found {problem}; write USD instead") from problem
    write_bytes(path, data)
    return path


def _object_node(container: GlbContainer, scene: SceneSpec, item: ObjectInstance, mesh: int | None) -> int:
    model = scene.model_of(item)
    extras: dict[str, Any] = {"instance_id": item.instance_id, "class_name": model.class_name, "obj_id": model.obj_id}
    extras |= {"model": item.model, "dynamic": item.dynamic, "group": item.group, "mass": model.mass}
    node: dict[str, Any] = {"name": f"{item.instance_id:06d}_{model.class_name}", **_placed(item.T_world_object)}
    if mesh is not None:
        node["mesh"] = mesh
    return container.add("nodes", node | {"extras": extras})


def _light_nodes(container: GlbContainer, scene: SceneSpec) -> list[int]:
    """Add the lights of the hall; what a vehicle carries shines for its viewpoint only and is left out."""
    if not scene.lights:
        return []
    described = [_described(number, light) for number, light in enumerate(scene.lights)]
    container.set("extensions", {_LIGHTS: {"lights": described}})
    nodes = []
    for number, light in enumerate(scene.lights):
        name = {"name": f"light_{number:03d}", "extensions": {_LIGHTS: {"light": number}}}
        nodes.append(container.add("nodes", name | _placed(_light_pose(light))))
    return nodes


def _described(number: int, light: Light) -> dict[str, Any]:
    """Return a light of KHR_lights_punctual, whose cone falls off as ours does; colours there are at most one."""
    cone, peak = as_cone(light), max(light.color)
    extras: dict[str, Any] = {"radius": light.radius, "casts_shadow": light.casts_shadow, "fill": light.fill}
    if light.distribution is not None:
        extras["photometry"] = light.distribution.name
    item: dict[str, Any] = {
        "name": f"light_{number:03d}",
        "type": light.kind,
        "color": [channel / peak for channel in light.color] if peak > 0.0 else [0.0, 0.0, 0.0],
        "intensity": cone.intensity * peak,
        "extras": extras,
    }
    if light.kind == "spot":
        outer = min(float(cone.cone_outer), _WIDEST)
        item["spot"] = {"innerConeAngle": min(float(cone.cone_inner), 0.999 * outer), "outerConeAngle": outer}
    return item


def _light_pose(light: Light) -> Transform:
    T = make_transform(None, np.asarray(light.position, float))
    if light.kind == "spot":
        back = -np.asarray(light.direction, float)
        side = np.cross(np.eye(3)[np.abs(back).argmin()], back)
        side /= np.linalg.norm(side)
        T[:3, :3] = np.stack([side, np.cross(back, side), back], axis=1)
    return T


def _camera_nodes(container: GlbContainer, scene: SceneSpec, rig: RigConfig | None) -> list[int]:
    nodes, known = [], {}
    for item in rig_cameras(scene, rig):
        if item.camera not in known:
            known[item.camera] = container.add("cameras", _perspective(item.camera))
        node = {"name": item.name, "camera": known[item.camera], **_placed(item.T_world_camera @ _T_CAMERA_EYE)}
        nodes.append(container.add("nodes", node | {"extras": item.to_plain()}))
    return nodes


def _perspective(camera: PinholeCamera) -> dict[str, Any]:
    """Return glTF's camera: its axis goes through the middle of the image, and it has no lens."""
    high, wide = camera.height / camera.fy, camera.width / camera.fx
    view = {"yfov": 2.0 * float(np.arctan(high / 2.0)), "aspectRatio": wide / high, "znear": _NEAR, "zfar": _FAR}
    return {"type": "perspective", "perspective": view}


def _placed(T: Transform) -> dict[str, list[float]]:
    w, x, y, z = quat_wxyz_from_matrix(T[:3, :3]).tolist()
    return {"translation": T[:3, 3].tolist(), "rotation": [x, y, z, w]}


def _used(scene: SceneSpec) -> set[str]:
    return {item.material_of(part) for item in scene.instances for part in scene.model_of(item).parts}
