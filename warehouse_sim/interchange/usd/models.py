"""Models as classes that objects refer to: geometry, colliders, mass, label; and one more for each paint of a model."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.symmetry import SymmetryGroup
from warehouse_sim.interchange.usd.bindings import bindings, place, placed_at, prim_names
from warehouse_sim.interchange.usd.colliders import add_colliders, read_colliders
from warehouse_sim.interchange.usd.meshes import MeshClasses, MeshReader
from warehouse_sim.interchange.usd.record import Record, keep
from warehouse_sim.render.painted_mesh import corner_tiles
from warehouse_sim.schema import LuminousFace, Material, ObjectInstance, ObjectModel, Part, Pocket, SceneSpec

GEOMETRY, COLLIDERS = "Geometry", "Colliders"
_LUMINOUS = ("source", "material", "catalog_material", "inward", "distance", "area")
TAXONOMY = "class"
"""Of semantic labels: what Isaac Sim's annotators require first."""


@dataclass(eq=False)
class ModelClasses:
    """The models of a stage.

    Args:
        stage: Where.
        root: Path of the class prim that they are children of.
        scene: What they are models of.
        bound: Material prim of each material of the scene.
        friction: Path of the material of all colliders.
    """

    stage: Any
    root: str
    scene: SceneSpec
    bound: Mapping[str, Any]
    friction: str
    _looks: dict[object, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.stage.CreateClassPrim(self.root)
        self._meshes = MeshClasses(self.stage, f"{self.root}/Meshes")
        placed = {item.model for item in self.scene.instances}
        used = [name for name in self.scene.models if name in placed]
        self._names = prim_names(["Meshes", *used])
        for name in used:
            self._add(self.scene.models[name])

    def path_of(self, instance: ObjectInstance) -> str:
        """Return the path of the class that looks like ``instance``."""
        bare = f"{self.root}/{self._names[instance.model]}"
        if not instance.paint:
            return bare
        if instance.look not in self._looks:
            self._looks[instance.look] = f"{bare}_paint_{len(self._looks):04d}"
            self._add_look(self._looks[instance.look], bare, instance)
        return self._looks[instance.look]

    def _add(self, model: ObjectModel) -> None:
        pxr = bindings()
        path = f"{self.root}/{self._names[model.name]}"
        root = pxr.Geom.Xform.Define(self.stage, path).GetPrim()
        pxr.Usd.ModelAPI(root).SetKind("component")
        pxr.Geom.Scope.Define(self.stage, f"{path}/{GEOMETRY}")
        for number, part in enumerate(model.parts):
            place_of = f"{path}/{GEOMETRY}/part_{number:03d}"
            prim = pxr.Geom.Mesh.Define(self.stage, place_of).GetPrim()
            prim.GetReferences().AddInternalReference(self._meshes.path_of(part.mesh))
            place(prim, part.T_object_part, part.scale)
            keep(prim, {"material": part.material, "role": part.role or None})
            self._paint(prim, part, part.material, number)
        add_colliders(self.stage, f"{path}/{COLLIDERS}", model.collision, self.friction)
        pxr.Semantics.LabelsAPI.Apply(root, TAXONOMY).CreateLabelsAttr([model.class_name])
        if model.parts:
            points = model.mesh().vertices
            extent = np.stack([points.min(axis=0), points.max(axis=0)]).astype(np.float32)
            pxr.Geom.ModelAPI.Apply(root).SetExtentsHint(pxr.Vt.Vec3fArray.FromNumpy(extent))
        _keep_model(root, model)

    def _add_look(self, path: str, bare: str, instance: ObjectInstance) -> None:
        """Add a class for the paint of an object, which refers to the bare one."""
        prim = bindings().Geom.Xform.Define(self.stage, path).GetPrim()
        prim.GetReferences().AddInternalReference(bare)
        keep(prim, {"paint_from": list(instance.paint), "paint_to": list(instance.paint.values())})
        for number, part in enumerate(self.scene.model_of(instance).parts):
            if part.material in instance.paint:
                over = self.stage.OverridePrim(f"{path}/{GEOMETRY}/part_{number:03d}")
                self._paint(over, part, instance.material_of(part), number)

    def _paint(self, prim: Any, part: Part, name: str, number: int) -> None:
        """Bind a material to a part and lay its texture on it, as ``render.painted_mesh`` does for renderers."""
        pxr = bindings()
        material = self.scene.materials[name]
        pxr.Shade.MaterialBindingAPI.Apply(prim).Bind(self.bound[name])
        vars_of, kinds = pxr.Geom.PrimvarsAPI(prim), pxr.Sdf.ValueTypeNames
        if material.texture is not None or material.picture is not None:
            tiles = corner_tiles(part, material, number).reshape(-1, 2)
            # Ours grow with the rows of an image, USD's t from its lower edge upwards.
            corners = np.stack([tiles[:, 0], 1.0 - tiles[:, 1]], axis=1).astype(np.float32)
            places, index = np.unique(corners, axis=0, return_inverse=True)
            st = vars_of.CreatePrimvar("st", kinds.TexCoord2fArray, pxr.Geom.Tokens.faceVarying)
            st.Set(pxr.Vt.Vec2fArray.FromNumpy(places))
            st.SetIndices(pxr.Vt.IntArray.FromNumpy(index.ravel().astype(np.int32)))
        shown = vars_of.CreatePrimvar("displayColor", kinds.Color3fArray, pxr.Geom.Tokens.constant)
        shown.Set([pxr.Gf.Vec3f(*map(float, material.base_color))])
        if material.opacity < 1.0:
            pxr.Geom.Gprim(prim).CreateDoubleSidedAttr(True)


def _keep_model(prim: Any, model: ObjectModel) -> None:
    symmetry, face, pockets = model.symmetry.transforms, model.luminous_face, model.pockets
    luminous = {} if face is None else {name: getattr(face, name) for name in _LUMINOUS}
    keep(
        prim,
        {
            "model": model.name,
            "class_name": model.class_name,
            "obj_id": model.obj_id,
            "size": model.size,
            "mass": model.mass,
            "make": model.make or None,
            "bears": model.bears,
            "own_materials": [item.name for item in model.materials],
            "symmetry": symmetry if len(symmetry) > 1 else None,
            "pocket_faces": [item.face for item in pockets] or None,
            "pocket_poses": np.stack([item.T_object_pocket for item in pockets]) if pockets else None,
            "pocket_sizes": np.stack([item.size for item in pockets]) if pockets else None,
            **{f"luminous_{name}": value for name, value in luminous.items()},
        },
    )


@dataclass(frozen=True, eq=False)
class ReadModel:
    """What one object, or a prototype of many, looks like."""

    model: ObjectModel
    paint: dict[str, str]


def read_model(path: Path, prim: Any, data: Any, meshes: MeshReader, materials: Mapping[str, Material]) -> ReadModel:
    """Return the model of an object and its paint.

    Args:
        path: File, for messages.
        prim: Holds the geometry: the object itself or its prototype.
        data: Prim with the model's custom data and mass: the object.
        meshes: Reads the meshes.
        materials: The scene's, by the path of their prim.

    Raises:
        DatasetError: Something is missing or cannot be used.
    """
    pxr = bindings()
    record, paint, parts = Record(path, data), dict[str, str](), []
    for child in prim.GetChild(GEOMETRY).GetChildren():
        own = Record(path, child)
        bound = str(pxr.Shade.MaterialBindingAPI(child).GetDirectBinding().GetMaterialPath())
        if bound not in materials:
            raise DatasetError(
                f"{path}: {child.GetPath()} is bound to {bound or 'nothing'}, which is no material there"
            )
        name = own.get("material", str, materials[bound].name)
        if name != materials[bound].name:
            paint[name] = materials[bound].name
        T_object_part, scale = placed_at(child)
        parts.append(Part(meshes.read(child), scale, T_object_part, name, own.get("role", str, "")))
    # Bindings show paint, but for what covers no part, or a material by itself.
    shown = {part.material for part in parts}
    recorded = zip(
        record.get("paint_from", tuple[str, ...], ()), record.get("paint_to", tuple[str, ...], ()), strict=False
    )
    paint |= {key: value for key, value in recorded if key not in shown or key == value}
    # What stands still has no body that has a mass.
    own_mass = pxr.Physics.MassAPI(data).GetMassAttr().Get() if data.HasAPI(pxr.Physics.MassAPI) else None
    names = {item.name: item for item in materials.values()}
    symmetry = record.numbers("symmetry", -1, 4, 4)
    model = ObjectModel(
        name=record.get("model", str),
        class_name=record.get("class_name", str),
        obj_id=record.get("obj_id", int),
        size=record.numbers("size", 3),
        parts=tuple(parts),
        collision=read_colliders(prim.GetChild(COLLIDERS)),
        mass=record.get("mass", float, 0.0) if own_mass is None else float(own_mass),
        symmetry=SymmetryGroup(symmetry) if len(symmetry) else SymmetryGroup.trivial(),
        pockets=_pockets(record),
        luminous_face=_luminous_face(record),
        materials=tuple(names[item] for item in record.get("own_materials", tuple[str, ...], ()) if item in names),
        make=record.get("make", str, ""),
        bears=record.get("bears", float, None),
    )
    return ReadModel(model, paint)


def _pockets(record: Record) -> tuple[Pocket, ...]:
    faces = record.get("pocket_faces", tuple[str, ...], ())
    poses, sizes = record.numbers("pocket_poses", -1, 4, 4), record.numbers("pocket_sizes", -1, 3)
    if not len(faces) == len(poses) == len(sizes):
        record.reject("pocket_poses", len(poses), f"as many as pocket_faces, {len(faces)}")
    return tuple(map(Pocket, faces, poses, sizes))


def _luminous_face(record: Record) -> LuminousFace | None:
    if "luminous_source" not in record:
        return None
    source = record.get("luminous_source", str)
    if source not in ("electric", "daylight"):
        record.reject("luminous_source", source, "electric or daylight")
    return LuminousFace(
        source="daylight" if source == "daylight" else "electric",
        material=record.get("luminous_material", str),
        catalog_material=record.get("luminous_catalog_material", str),
        inward=record.numbers("luminous_inward", 3),
        distance=record.get("luminous_distance", float),
        area=record.get("luminous_area", float),
    )
