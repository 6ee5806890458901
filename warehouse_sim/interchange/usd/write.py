"""Write a scene as OpenUSD: each geometry once as a class, each object as an instance of it, textures beside it."""

import os
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from warehouse_sim.errors import OutputError
from warehouse_sim.interchange.usd.bindings import bindings, place, prim_names
from warehouse_sim.interchange.usd.colliders import add_friction, add_physics_scene
from warehouse_sim.interchange.usd.lights import add_even_light, add_light
from warehouse_sim.interchange.usd.materials import add_material
from warehouse_sim.interchange.usd.models import ModelClasses
from warehouse_sim.interchange.usd.record import keep
from warehouse_sim.interchange.usd.textures import Textures
from warehouse_sim.interchange.usd.viewpoints import add_viewpoints
from warehouse_sim.output import make_folder, writing
from warehouse_sim.schema import ObjectInstance, SceneSpec
from warehouse_sim.sensors.rig import RigConfig

ROOT, MATERIALS, LIGHTS, VIEWPOINTS = "/World", "/World/Materials", "/World/Lights", "/World/Viewpoints"
EVEN_LIGHT = "even_light"
SUFFIXES = (".usda", ".usdc", ".usd")


def write_usd(scene: SceneSpec, path: Path, rig: RigConfig | None = None) -> Path:
    """Write ``scene`` to ``path`` (.usda or .usdc): z up, metres, kilograms; textures into ``textures/`` beside it.

    ``write_usd(prepared.scene, Path("scene.usda"), recipe.sensors)`` writes what ``prepare_scene`` returned.

    Objects carry their ``instance_id``, ``class_name`` and ``obj_id`` as custom data, and their class as a semantic
    label of the taxonomy ``class``. Of the catalog, the models that the scene places are written.

    Args:
        scene: What to write.
        path: Of the stage; its folder is made.
        rig: Sensors that stand at each viewpoint; None = viewpoints without cameras.

    Raises:
        MissingPackageError: usd-core is not installed.
        OutputError: A file cannot be written.
        RenderError: The scene names a texture that is not shipped.
    """
    pxr, textures = bindings(), Textures()
    stage = pxr.Usd.Stage.CreateInMemory()
    pxr.Geom.SetStageUpAxis(stage, pxr.Geom.Tokens.z)
    pxr.Geom.SetStageMetersPerUnit(stage, 1.0)
    world = pxr.Geom.Xform.Define(stage, ROOT).GetPrim()
    stage.SetDefaultPrim(world)
    pxr.Usd.ModelAPI(world).SetKind("assembly")
    _keep_scene(world, scene)
    add_physics_scene(stage, f"{ROOT}/PhysicsScene")
    bound = _add_materials(stage, scene, textures)
    classes = ModelClasses(stage, f"{ROOT}/Models", scene, bound, f"{ROOT}/friction")
    for instance in scene.instances:
        _add_object(stage, instance, scene.model_of(instance).mass, classes)
    pxr.Geom.Scope.Define(stage, LIGHTS)
    add_even_light(stage, f"{LIGHTS}/{EVEN_LIGHT}", scene.ambient)
    for number, light in enumerate(scene.lights):
        add_light(stage, f"{LIGHTS}/light_{number:03d}", light, textures)
    add_viewpoints(stage, VIEWPOINTS, scene, rig, textures)
    make_folder(path.parent)
    _save(stage, path, textures)
    return path


def _keep_scene(world: Any, scene: SceneSpec) -> None:
    keep(
        world,
        {
            "scene_index": scene.scene_index,
            "seed": scene.seed,
            "targets": scene.targets,
            "exposure": scene.exposure,
            "settled": scene.settled,
            "lighting": scene.lighting,
            "attempt": scene.attempt,
            "aisle": None if scene.aisle is None else np.array(scene.aisle),
        },
    )


def _add_materials(stage: Any, scene: SceneSpec, textures: Textures) -> dict[str, Any]:
    """Add the materials of a scene, and that of its colliders; return them by name."""
    bindings().Geom.Scope.Define(stage, MATERIALS)
    names = prim_names(scene.materials)
    bound = {
        name: add_material(stage, f"{MATERIALS}/{names[name]}", material, textures)
        for name, material in scene.materials.items()
    }
    add_friction(stage, f"{ROOT}/friction")
    return bound


def _add_object(stage: Any, instance: ObjectInstance, mass: float, classes: ModelClasses) -> None:
    """Add an object: a rigid body of its mass (kg) where physics may move it, else colliders that stand still.

    The body lies on the root of the instance, whose inside no simulator can move (NVIDIA, asset requirement RB.005).
    """
    pxr = bindings()
    prim = pxr.Geom.Xform.Define(stage, f"{ROOT}/object_{instance.instance_id:06d}").GetPrim()
    place(prim, instance.T_world_object)
    prim.GetReferences().AddInternalReference(classes.path_of(instance))
    prim.SetInstanceable(True)
    if instance.dynamic:
        pxr.Physics.RigidBodyAPI.Apply(prim)
        pxr.Physics.MassAPI.Apply(prim).CreateMassAttr(mass)
    keep(prim, {"instance_id": instance.instance_id, "group": instance.group or None})


def _save(stage: Any, path: Path, textures: Textures) -> None:
    """Write the textures and then the stage, in one step."""
    if path.suffix.lower() not in SUFFIXES:
        raise OutputError(f"{path}: USD cannot be written there; choose another place, named .usda, .usdc or .usd")
    with writing(path), tempfile.TemporaryDirectory(prefix=f".{path.stem}", dir=path.parent) as folder:
        made = Path(folder) / path.name
        try:
            written = stage.GetRootLayer().Export(str(made))
        except bindings().Tf.ErrorException:
            written = False
        if not written:
            raise OutputError(f"{path}: USD cannot be written there; choose another place, named .usda, .usdc or .usd")
        textures.save(path.parent)
        os.replace(made, path)
