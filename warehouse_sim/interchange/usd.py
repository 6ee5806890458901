"""Write a scene as OpenUSD: each geometry once as a class, each object as a reference to it."""

from pathlib import Path
from typing import Any

import numpy as np

from warehouse_sim.errors import OutputError
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.optional import require
from warehouse_sim.output import make_folder
from warehouse_sim.schema import Material, ObjectModel, SceneSpec


def write_usd(scene: SceneSpec, path: Path) -> Path:
    """Write ``scene`` to ``path`` (.usda or .usdc), z up, metres, with UsdPreviewSurface materials.

    ``write_usd(prepared.scene, Path("scene.usda"))`` writes what ``prepare_scene`` returned.

    Materials are plain: textures and pictures of labels and prints are left out.

    Objects carry their ``instance_id``, ``class_name`` and ``obj_id`` as custom data, so labels can be made elsewhere.

    Raises:
        MissingPackageError: usd-core is not installed.
        OutputError: The file cannot be written.
    """
    usd = require("pxr.Usd", "interchange", "to write USD")
    geom = require("pxr.UsdGeom", "interchange", "to write USD")
    tf = require("pxr.Tf", "interchange", "to write USD")
    make_folder(path.parent)
    stage = usd.Stage.CreateInMemory()
    geom.SetStageUpAxis(stage, geom.Tokens.z)
    geom.SetStageMetersPerUnit(stage, 1.0)
    stage.SetDefaultPrim(geom.Xform.Define(stage, "/World").GetPrim())
    materials = {name: _add_material(stage, material) for name, material in scene.materials.items()}
    used = {instance.model for instance in scene.instances}
    for name in sorted(used):
        _add_model(stage, scene.models[name], materials)
    classes = _add_looks(stage, scene, materials)
    for instance in scene.instances:
        xform = geom.Xform.Define(stage, f"/World/object_{instance.instance_id:06d}")
        xform.AddTransformOp().Set(_matrix(instance.T_world_object))
        prim, model = xform.GetPrim(), scene.model_of(instance)
        prim.GetReferences().AddInternalReference(classes[instance.look])
        prim.SetInstanceable(True)
        for key, value in (
            ("instance_id", instance.instance_id),
            ("class_name", model.class_name),
            ("obj_id", model.obj_id),
        ):
            prim.SetCustomDataByKey(key, value)
    try:
        written = stage.GetRootLayer().Export(str(path))
    except tf.ErrorException:
        written = False
    if not written:
        raise OutputError(f"{path}: USD cannot be written there; choose another place, named .usda, .usdc or .usd")
    return path


def _add_model(stage: Any, model: ObjectModel, materials: dict[str, Any]) -> None:
    geom, shade = (
        require("pxr.UsdGeom", "interchange", "to write USD"),
        require("pxr.UsdShade", "interchange", "to write USD"),
    )
    root = f"/Models/{_identifier(model.name)}"
    stage.CreateClassPrim("/Models")
    geom.Xform.Define(stage, root)
    for index, part in enumerate(model.parts):
        mesh = geom.Mesh.Define(stage, f"{root}/part_{index:03d}")
        placed = part.placed()
        mesh.CreatePointsAttr(placed.vertices.astype(np.float32))
        mesh.CreateFaceVertexCountsAttr(np.full(len(placed.faces), 3, dtype=np.int32))
        mesh.CreateFaceVertexIndicesAttr(placed.faces.ravel().astype(np.int32))
        mesh.CreateSubdivisionSchemeAttr(geom.Tokens.none)
        shade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(materials[part.material])


def _add_looks(stage: Any, scene: SceneSpec, materials: dict[str, Any]) -> dict[object, str]:
    """Add a class for each paint of each model, which refers to the bare one; return the class of each look."""
    geom, shade = (
        require("pxr.UsdGeom", "interchange", "to write USD"),
        require("pxr.UsdShade", "interchange", "to write USD"),
    )
    classes: dict[object, str] = {}
    for instance in scene.instances:
        if instance.look in classes:
            continue
        bare = f"/Models/{_identifier(instance.model)}"
        classes[instance.look] = path = f"{bare}_paint_{len(classes):04d}" if instance.paint else bare
        if path == bare:
            continue
        geom.Xform.Define(stage, path).GetPrim().GetReferences().AddInternalReference(bare)
        for index, part in enumerate(scene.model_of(instance).parts):
            if part.material in instance.paint:
                over = stage.OverridePrim(f"{path}/part_{index:03d}")
                shade.MaterialBindingAPI.Apply(over).Bind(materials[instance.material_of(part)])
    return classes


def _add_material(stage: Any, material: Material) -> Any:
    shade, sdf = (
        require("pxr.UsdShade", "interchange", "to write USD"),
        require("pxr.Sdf", "interchange", "to write USD"),
    )
    bound = shade.Material.Define(stage, f"/Materials/{_identifier(material.name)}")
    surface = shade.Shader.Define(stage, f"{bound.GetPath()}/surface")
    surface.CreateIdAttr("UsdPreviewSurface")
    surface.CreateInput("diffuseColor", sdf.ValueTypeNames.Color3f).Set(material.base_color)
    surface.CreateInput("roughness", sdf.ValueTypeNames.Float).Set(material.roughness)
    surface.CreateInput("metallic", sdf.ValueTypeNames.Float).Set(material.metallic)
    bound.CreateSurfaceOutput().ConnectToSource(surface.ConnectableAPI(), "surface")
    return bound


def _matrix(T_world_object: Transform) -> Any:
    # USD multiplies row vectors from the left, so its matrices are the transpose of ours.
    return require("pxr.Gf", "interchange", "to write USD").Matrix4d(T_world_object.T.tolist())


def _identifier(name: str) -> str:
    return require("pxr.Tf", "interchange", "to write USD").MakeValidIdentifier(name)
