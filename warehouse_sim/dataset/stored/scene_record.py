"""scenes/000000.json: everything that stands in a scene, so that nothing visible is nameless.

The record is the last file of its scene: where it exists, the scene is complete.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from warehouse_sim.config import from_mapping
from warehouse_sim.dataset.card.tally import Tally, read_tally
from warehouse_sim.dataset.files.json_file import read_json, write_json
from warehouse_sim.dataset.files.plain import WHOLE, plain, read_transform, shown, take, take_if_given, take_name
from warehouse_sim.dataset.files.ply import read_ply, write_ply
from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.dataset.objects import FACES
from warehouse_sim.dataset.split import Split
from warehouse_sim.dataset.stored.contents import ReadingContents
from warehouse_sim.dataset.stored.observation_record import RecordedObservation, light_row, read_observation
from warehouse_sim.errors import ConfigError, DatasetError
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.output import make_folder
from warehouse_sim.schema import Accessibility, SceneSpec
from warehouse_sim.schema.things import is_damaged


@dataclass(frozen=True, eq=False)
class RecordedObject:
    """One object of a scene."""

    instance_id: int
    class_name: str
    model: str
    obj_id: int
    group: int
    T_world_object: Transform
    paint: Mapping[str, str] = field(default_factory=dict)
    """Material of the model -> the one that it has here instead; their appearance is in the record's ``paints``."""

    accessibility: Accessibility | None = None
    """Which of its faces a truck can take it by; None where that is not stored, or it has no pockets."""

    @property
    def is_damaged(self) -> bool:
        """Whether its boards differ from the CAD model of its obj_id, whose frame and pockets it keeps."""
        return is_damaged(self.model)


@dataclass(frozen=True, eq=False)
class SceneRecord:
    """What is stored of a scene beside its sensor data."""

    scene_index: int
    seed: int
    split: str
    renderer: str
    """Description of the renderer that drew it."""
    objects: tuple[RecordedObject, ...]
    """In order of instance id."""
    observations: tuple[RecordedObservation, ...]
    """In order of index."""
    tally: Tally
    """What is in it, counted for the dataset's card."""
    settle: dict[str, Any] = field(default_factory=dict)
    """How the scene came to rest."""
    readings: dict[str, ReadingContents] = field(default_factory=dict)
    """What sensors that no format holds gave in it."""

    @property
    def T_world_camera(self) -> tuple[Transform, ...]:
        """Camera of each observation."""
        return tuple(item.T_world_camera for item in self.observations)

    def object(self, instance_id: int) -> RecordedObject | None:
        """Return the object with an instance id, or None."""
        return next((item for item in self.objects if item.instance_id == instance_id), None)


def write_scene_record(
    path: Path,
    scene: SceneSpec,
    split: Split,
    observations: Sequence[Mapping[str, Any]],
    extra: Mapping[str, Any],
    paired_variants: Sequence[tuple[str, SceneSpec]] = (),
    accessibility: Mapping[int, Accessibility] | None = None,
) -> None:
    """Write the record of a settled scene.

    Args:
        path: The record's file.
        scene: The scene as it was drawn.
        split: The split it belongs to.
        observations: Row of each observation that was written, in order; see ``observation_row``.
        extra: Further entries as plain data: ``renderer``, ``settle``, ``occlusion``, ``readings``, ``tally``.
        paired_variants: Name and scene of each variant beside the scene itself.
        accessibility: Which sides of its pallets a truck can take them by, by instance id; None is not known.
    """
    reach = accessibility or {}
    objects = [
        {
            "instance_id": item.instance_id,
            "class_name": scene.model_of(item).class_name,
            "model": item.model,
            "obj_id": scene.model_of(item).obj_id,
            "group": item.group,
            "T_world_object": item.T_world_object,
            **({"paint": dict(item.paint)} if item.paint else {}),
            **accessibility_row(reach.get(item.instance_id)),
        }
        for item in sorted(scene.instances, key=lambda item: item.instance_id)
    ]
    data = {
        "scene_index": scene.scene_index,
        "seed": scene.seed,
        "split": split,
        "attempt": scene.attempt,
        "targets": scene.targets,
        **extra,
        **_light_row(scene),
        **_paint_row(scene),
        "paired_variants": [
            {"variant": name, **_light_row(paired_variant), **_surface_row(paired_variant, scene)}
            for name, paired_variant in paired_variants
        ],
        "observations": list(observations),
        "objects": objects,
    }
    write_json(path, plain(data), depth=2)


def accessibility_row(reach: Accessibility | None) -> dict[str, Any]:
    """Return what is stored of an object beside all else; nothing where nothing is known."""
    return {} if reach is None else {"dockable": dict(reach.faces), "stacked": reach.stacked}


def _light_row(scene: SceneSpec) -> dict[str, Any]:
    return {
        "lighting": scene.lighting,
        "ambient": scene.ambient,
        "exposure": scene.exposure,
        "lights": [light_row(light) for light in scene.lights],
    }


def _paint_row(scene: SceneSpec) -> dict[str, Any]:
    """Return the materials that objects are painted with in place of their models'; nothing where none is."""
    used = {name for item in scene.instances for name in item.paint.values()}
    return {"paints": {name: vars(scene.materials[name]) for name in sorted(used)}} if used else {}


def _surface_row(paired_variant: SceneSpec, scene: SceneSpec) -> dict[str, Any]:
    """Return the materials of a paired variant that differ from those of the first."""
    changed = {name: item for name, item in paired_variant.materials.items() if item != scene.materials.get(name)}
    return {"materials": {name: vars(item) for name, item in changed.items()}}


def read_scene_record(root: Path, scene_index: int, objects: bool = True) -> SceneRecord:
    """Read the record of a scene strictly.

    Args:
        root: Folder of the dataset.
        scene_index: Which scene.
        objects: Whether to read what stands in it, thousands of things; without, the record has none.

    Raises:
        DatasetError: The record is missing, incomplete or malformed.
    """
    path = DatasetLayout(root).scene_record(scene_index)
    data, where = read_json(path), str(path)
    observations = take(data, "observations", list, where)
    things = take(data, "objects", list, where) if objects else []
    return SceneRecord(
        scene_index=take(data, "scene_index", int, where, WHOLE),
        seed=take(data, "seed", int, where),
        split=take(data, "split", str, where),
        renderer=take(data, "renderer", str, where),
        objects=tuple(_read_object(item, f"{where}: objects[{i}]") for i, item in enumerate(things)),
        observations=tuple(
            read_observation(item, f"{where}: observations[{i}]") for i, item in enumerate(observations)
        ),
        settle=take(data, "settle", dict, where),
        tally=read_tally(take(data, "tally", dict, where), f"{where}: tally"),
        readings=_read_readings(take_if_given(data, "readings", dict, where) or {}, f"{where}: readings"),
    )


def _read_readings(data: dict[str, Any], where: str) -> dict[str, ReadingContents]:
    try:
        return {name: from_mapping(ReadingContents, item, f"{where}: {name}") for name, item in data.items()}
    except ConfigError as problem:
        raise DatasetError(str(problem)) from problem


def _read_object(data: Any, where: str) -> RecordedObject:
    return RecordedObject(
        instance_id=take(data, "instance_id", int, where, WHOLE),
        class_name=take_name(data, "class_name", where),
        model=take(data, "model", str, where),
        obj_id=take(data, "obj_id", int, where, WHOLE),
        group=take(data, "group", int, where),
        T_world_object=read_transform(take(data, "T_world_object", list, where), where),
        paint=_read_paint(take_if_given(data, "paint", dict, where) or {}, f"{where}: paint"),
        accessibility=_read_accessibility(data, where),
    )


def _read_accessibility(data: Any, where: str) -> Accessibility | None:
    faces = take_if_given(data, "dockable", dict, where)
    if faces is None:
        return None
    if not set(FACES).issuperset(faces):
        raise DatasetError(f"{where}: dockable must name faces among {', '.join(FACES)}, found {shown(sorted(faces))}")
    verdicts = {face: take(faces, face, str, f"{where}: dockable") for face in faces}
    return Accessibility(verdicts, take(data, "stacked", bool, where))


def _read_paint(data: dict[str, Any], where: str) -> dict[str, str]:
    return {str(name): take(data, name, str, where) for name in data}


def write_damaged_meshes(root: Path, scene: SceneSpec) -> None:
    """Store the surface of each damaged target of a scene, in millimetres as BOP's models."""
    names = sorted({item.model for item in scene.target_instances() if is_damaged(item.model)})
    for name in names:
        path, mesh = DatasetLayout(root).damaged_mesh(name), scene.models[name].mesh()
        make_folder(path.parent)
        write_ply(path, TriangleMesh(mesh.vertices * 1000.0, mesh.faces))


def read_damaged_mesh(root: Path, item: RecordedObject) -> TriangleMesh | None:
    """Return the surface (m, object frame) of a damaged object; None for one that is as it was built, or not stored.

    Raises:
        DatasetError: The file is none that this package wrote.
    """
    path = DatasetLayout(root).damaged_mesh(item.model)
    if not item.is_damaged or not path.is_file():
        return None
    mesh = read_ply(path)
    return TriangleMesh(mesh.vertices / 1000.0, mesh.faces)
