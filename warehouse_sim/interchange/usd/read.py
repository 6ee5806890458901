"""Read a scene back from OpenUSD, as ``write_usd`` wrote it or as another program has changed it since.

What USD has schemas for is read from those: poses, points, colours, lights, masses, cameras' places. What it has none
for comes from custom data.
"""

from pathlib import Path
from typing import Any

import numpy as np

from warehouse_sim.errors import DatasetError
from warehouse_sim.interchange.usd.bindings import bindings, world_pose
from warehouse_sim.interchange.usd.lights import read_even_light, read_light
from warehouse_sim.interchange.usd.materials import read_material
from warehouse_sim.interchange.usd.meshes import MeshReader
from warehouse_sim.interchange.usd.models import ReadModel, read_model
from warehouse_sim.interchange.usd.record import Record
from warehouse_sim.interchange.usd.viewpoints import read_viewpoint
from warehouse_sim.interchange.usd.write import EVEN_LIGHT, LIGHTS, MATERIALS, VIEWPOINTS
from warehouse_sim.schema import Material, ObjectInstance, ObjectModel, SceneSpec


def read_usd(path: Path) -> SceneSpec:
    """Return the scene that ``path`` holds.

    Textures and pictures are named, not read: renderers take them from this installation, as for any scene.

    Raises:
        MissingPackageError: usd-core is not installed.
        DatasetError: The file cannot be read, holds no scene of ours, or a value cannot be used; named with its prim.
    """
    stage = _open(path)
    pxr, world = bindings(), stage.GetDefaultPrim()
    record, cache = Record(path, world), pxr.Geom.XformCache()
    materials = {
        str(child.GetPath()): read_material(path, child) for child in _children(stage, MATERIALS, pxr.Shade.Material)
    }
    models, instances = _read_objects(path, world, cache, materials)
    lights = [read_light(path, child, cache) for child in _children(stage, LIGHTS, pxr.Lux.SphereLight)]
    viewpoints = [read_viewpoint(path, child, cache) for child in _children(stage, VIEWPOINTS, pxr.Geom.Xform)]
    aisle = [float(edge) for edge in record.numbers("aisle", 4)] if "aisle" in record else None
    return SceneSpec(
        scene_index=record.get("scene_index", int),
        seed=record.get("seed", int),
        models=models,
        materials={item.name: item for item in materials.values()},
        instances=tuple(instances),
        lights=tuple(lights),
        viewpoints=tuple(viewpoints),
        targets=record.get("targets", tuple[str, ...], ()),
        ambient=read_even_light(stage.GetPrimAtPath(f"{LIGHTS}/{EVEN_LIGHT}")),
        exposure=record.get("exposure", float),
        settled=record.get("settled", bool, False),
        lighting=record.get("lighting", str),
        attempt=record.get("attempt", int),
        aisle=None if aisle is None else (aisle[0], aisle[1], aisle[2], aisle[3]),
    )


def _open(path: Path) -> Any:
    pxr = bindings()
    if not path.is_file():
        raise DatasetError(f"{path}: there is no such file; name a scene that write_usd wrote")
    try:
        stage = pxr.Usd.Stage.Open(str(path))
    except pxr.Tf.ErrorException as problem:
        raise DatasetError(f"{path}: cannot be read as USD ({' '.join(str(problem).split())[:200]})") from problem
    for layer in stage.GetUsedLayers():
        if layer.realPath and not Path(layer.realPath).resolve().is_relative_to(path.parent.resolve()):
            raise DatasetError(
                f"{path}: refers to {layer.realPath}, outside its folder; flatten the stage into one file"
            )
    world = stage.GetDefaultPrim()
    if not world or "scene_index" not in Record(path, world):
        raise DatasetError(f"{path}: holds no scene of warehouse-sim; read its meshes as objects of your own instead")
    if pxr.Geom.GetStageUpAxis(stage) != pxr.Geom.Tokens.z or pxr.Geom.GetStageMetersPerUnit(stage) != 1.0:
        raise DatasetError(f"{path}: must be z up in metres; set upAxis and metersPerUnit back")
    return stage


def _children(stage: Any, path: str, kind: Any) -> list[Any]:
    prim = stage.GetPrimAtPath(path)
    return [child for child in prim.GetChildren() if child.IsA(kind)] if prim else []


def _read_objects(
    path: Path, world: Any, cache: Any, materials: dict[str, Material]
) -> tuple[dict[str, ObjectModel], list[ObjectInstance]]:
    """Return models by name and objects; each prototype is read once."""
    meshes, models = MeshReader(path), dict[str, ObjectModel]()
    known: dict[str, ReadModel] = {}
    instances, seen = list[ObjectInstance](), set[int]()
    for prim in world.GetChildren():
        record = Record(path, prim)
        if "instance_id" not in record:
            continue
        prototype = prim.GetPrototype() if prim.IsInstance() else prim
        key = str(prototype.GetPath())
        if key not in known:
            known[key] = read_model(path, prototype, prim, meshes, materials)
        look, number = known[key], record.get("instance_id", int)
        if number < 1 or number in seen:
            record.reject("instance_id", number, "above 0 and the object's own")
        seen.add(number)
        T_world_object = world_pose(cache, prim)
        if not np.isfinite(T_world_object).all():
            record.reject("its pose", T_world_object.tolist(), "finite")
        instances.append(
            ObjectInstance(
                instance_id=number,
                model=models.setdefault(look.model.name, look.model).name,
                T_world_object=T_world_object,
                dynamic=prim.HasAPI(bindings().Physics.RigidBodyAPI),
                group=record.get("group", int, 0),
                paint=look.paint,
            )
        )
    return models, instances
