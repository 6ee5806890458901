"""scenes/000000.json: everything that stands in a scene, so that nothing visible is nameless.

The record is the last file of its scene: where it exists, the scene is complete.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from warehouse_sim.dataset.card.tally import Tally, TallyRecord
from warehouse_sim.dataset.files.json_file import read_json, write_json
from warehouse_sim.dataset.files.ply import read_ply, write_ply
from warehouse_sim.dataset.files.record import Name, Record, Rigid, Whole
from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.dataset.objects import FACES
from warehouse_sim.dataset.split import Split
from warehouse_sim.dataset.stored.contents import ReadingContents
from warehouse_sim.dataset.stored.observation_record import RecordedObservation, light_row
from warehouse_sim.errors import shown
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.output import make_folder
from warehouse_sim.schema import Accessibility, ObjectInstance, SceneSpec
from warehouse_sim.schema.things import is_damaged


@dataclass(frozen=True, eq=False)
class RecordedObject(Record):
    """One object of a scene."""

    instance_id: Whole
    class_name: Name
    model: str
    obj_id: Whole
    group: int
    T_world_object: Rigid
    paint: dict[str, str] = field(default_factory=dict, metadata={"omitted": True})
    """Material of the model -> the one that it has here instead; their appearance is in the record's ``paints``."""
    dockable: dict[str, str] | None = field(default=None, metadata={"omitted": True})
    """Face -> "free" or why no truck takes it by that; None where that is not known, or it has no pockets."""
    stacked: bool | None = field(default=None, metadata={"omitted": True})
    """Whether it is part of a stack; None as ``dockable``."""

    def __post_init__(self) -> None:
        if not set(FACES).issuperset(self.dockable or ()):
            raise ValueError(
                f"dockable must name faces among {', '.join(FACES)}, found {shown(sorted(self.dockable or ()))}"
            )
        if (self.dockable is None) != (self.stacked is None):
            raise ValueError("dockable and stacked must both be there, or none of them")

    @property
    def accessibility(self) -> Accessibility | None:
        """Which of its faces a truck can take it by."""
        return None if self.dockable is None else Accessibility(self.dockable, bool(self.stacked))

    @property
    def is_damaged(self) -> bool:
        """Whether its boards differ from the CAD model of its obj_id, whose frame and pockets it keeps."""
        return is_damaged(self.model)


def _read_tally(data: Any, where: str) -> Tally:
    return TallyRecord.read(data, where).tally()


def _tally_row(tally: Tally) -> dict[str, Any]:
    return TallyRecord.of(tally).row()


@dataclass(frozen=True, eq=False)
class SceneRecord(Record):
    """What is stored of a scene beside its sensor data."""

    scene_index: Whole
    seed: int
    split: str
    attempt: int
    """How often it was drawn before it stood."""
    targets: tuple[str, ...]
    """Class names that have labels."""
    renderer: str
    """Description of the renderer that drew it."""
    settle: dict[str, Any]
    """How the scene came to rest."""
    occlusion: dict[str, Any] | None
    """How requests for a visible fraction were met, if there were any."""
    tally: Tally = field(metadata={"from_plain": _read_tally, "to_plain": _tally_row})
    """What is in it, counted for the dataset's card."""
    readings: dict[str, ReadingContents] = field(default_factory=dict, metadata={"omitted": True}, kw_only=True)
    """What sensors that no format holds gave in it."""
    origin: dict[str, Any] | None = field(default=None, metadata={"omitted": True}, kw_only=True)
    """Where third-party observations come from."""
    lighting: str
    """Name of the light preset; it, ``ambient``, ``exposure`` and ``lights`` are those of the scene."""
    ambient: float
    exposure: float
    lights: tuple[dict[str, Any], ...]
    paints: dict[str, dict[str, Any]] = field(default_factory=dict, metadata={"omitted": True}, kw_only=True)
    """Materials that objects are painted with in place of their models'."""
    paired_variants: tuple[dict[str, Any], ...]
    """Light and materials of each variant beside the scene."""
    observations: tuple[RecordedObservation, ...]
    """In order of index."""
    objects: tuple[RecordedObject, ...]
    """In order of instance id."""

    @property
    def T_world_camera(self) -> tuple[Transform, ...]:
        """Camera of each observation."""
        return tuple(item.T_world_camera for item in self.observations)

    def object(self, instance_id: int) -> RecordedObject | None:
        """Return the object with an instance id, or None."""
        return next((item for item in self.objects if item.instance_id == instance_id), None)


@dataclass(frozen=True)
class Outcome:
    """What became of a scene while it was made: what its record says beside the scene itself."""

    settle: Mapping[str, Any]
    """Plain data on how it came to rest."""
    renderer: str
    """Description of the renderer that drew it."""
    occlusion: Mapping[str, Any] | None = None
    """Plain data on how requests for a visible fraction were met."""
    paired_variants: Sequence[tuple[str, SceneSpec]] = ()
    """Name and scene of each variant beside the scene itself."""
    origin: Mapping[str, Any] | None = None
    """Plain data on where third-party observations come from."""
    accessibility: Mapping[int, Accessibility] = field(default_factory=dict)
    """Which sides of its pallets a truck can take them by, by instance id, where that is known."""


def write_scene_record(
    path: Path,
    scene: SceneSpec,
    split: Split,
    observations: Sequence[RecordedObservation],
    tally: Tally,
    outcome: Outcome,
    readings: Mapping[str, ReadingContents],
) -> SceneRecord:
    """Write the record of a settled scene, and return it.

    Args:
        path: The record's file.
        scene: The scene as it was drawn.
        split: The split it belongs to.
        observations: Those that were written, in order.
        tally: What is in it.
        outcome: What became of it.
        readings: What sensors that no format holds gave in it.
    """
    used = {name for item in scene.instances for name in item.paint.values()}
    record = SceneRecord(
        scene_index=scene.scene_index,
        seed=scene.seed,
        split=split,
        attempt=scene.attempt,
        targets=scene.targets,
        renderer=outcome.renderer,
        settle=dict(outcome.settle),
        occlusion=None if outcome.occlusion is None else dict(outcome.occlusion),
        tally=tally,
        readings=dict(readings),
        origin=None if outcome.origin is None else dict(outcome.origin),
        **_light_row(scene),
        paints={name: vars(scene.materials[name]) for name in sorted(used)},
        paired_variants=tuple(
            {"variant": name, **_light_row(variant), **_surface_row(variant, scene)}
            for name, variant in outcome.paired_variants
        ),
        observations=tuple(observations),
        objects=tuple(_recorded_object(scene, item, outcome) for item in sorted(scene.instances, key=_number)),
    )
    write_json(path, record.row(), depth=2)
    return record


def _number(item: ObjectInstance) -> int:
    return item.instance_id


def _recorded_object(scene: SceneSpec, item: ObjectInstance, outcome: Outcome) -> RecordedObject:
    model, reach = scene.model_of(item), outcome.accessibility.get(item.instance_id)
    return RecordedObject(
        item.instance_id,
        model.class_name,
        item.model,
        model.obj_id,
        item.group,
        item.T_world_object,
        dict(item.paint),
        None if reach is None else dict(reach.faces),
        None if reach is None else reach.stacked,
    )


def _light_row(scene: SceneSpec) -> dict[str, Any]:
    return {
        "lighting": scene.lighting,
        "ambient": scene.ambient,
        "exposure": scene.exposure,
        "lights": tuple(light_row(light) for light in scene.lights),
    }


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
    data = read_json(path)
    return SceneRecord.read(data if objects or not isinstance(data, dict) else data | {"objects": []}, str(path))


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
