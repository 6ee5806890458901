"""How each ground truth stands in its scene: which sides a truck reaches, whether in a stack, and its own surface."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from jaxtyping import Bool, Float

from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.dataset.reader import DatasetReader, ImageRecord
from warehouse_sim.dataset.stored.scene_record import RecordedObject, read_damaged_mesh, read_scene_record
from warehouse_sim.evaluation.docking.fork import DockingFace, docking_errors
from warehouse_sim.evaluation.docking.insertion import DockingSlack, docking_slack, failure_axes
from warehouse_sim.evaluation.docking.mesh_sweep import lane_triangles, mesh_slack
from warehouse_sim.evaluation.pairing import Place
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.geometry.pose import Transform, invert, make_transform
from warehouse_sim.schema import FREE, UNDER_A_STACK, PalletFace


@dataclass(frozen=True, eq=False)
class Standings:
    """What the scene records say of the objects of some scenes; without records, nothing is known of any."""

    objects: dict[tuple[int, int], RecordedObject] = field(default_factory=dict)
    """By scene id and instance id."""
    reader: DatasetReader | None = None
    """Where the surfaces of damaged objects are."""
    _meshes: dict[object, TriangleMesh] = field(default_factory=dict)
    _clearances: dict[object, float] = field(default_factory=dict)
    _lanes: dict[object, Float[np.ndarray, "m 3 3"]] = field(default_factory=dict)

    @classmethod
    def of(cls, reader: DatasetReader, images: Sequence[ImageRecord]) -> "Standings":
        """Read the records of the scenes of ``images``, as far as there are any."""
        found = {}
        for scene_id in sorted({image.scene_id for image in images}):
            if DatasetLayout(reader.root).scene_record(scene_id).is_file():
                for item in read_scene_record(reader.root, scene_id).objects:
                    found[scene_id, item.instance_id] = item
        return cls(found, reader)

    def verdict(self, place: Place, face: DockingFace) -> str:
        """Return "free" or why no truck takes an object by ``face``; empty where that is not known."""
        item = self.objects.get((place[0], place[2]))
        return "" if item is None or item.accessibility is None else item.accessibility.faces.get(face.name, "")

    def free(self, place: Place, faces: Sequence[DockingFace]) -> Bool[np.ndarray, " f"]:
        """Return by which faces a truck is known to reach an object, of a stack as a whole."""
        return np.array([self.verdict(place, face) in (FREE, UNDER_A_STACK) for face in faces], dtype=bool)

    def stacked(self, place: Place) -> bool:
        """Return whether an object is known to stand in a stack."""
        item = self.objects.get((place[0], place[2]))
        return item is not None and item.accessibility is not None and item.accessibility.stacked

    def surface(self, place: Place, info: ObjectInfo) -> str:
        """Return the name of the surface of an object: its own where it is worn, else that of its geometry."""
        item = self.objects.get((place[0], place[2]))
        return item.model if item is not None and item.is_damaged else f"{info.obj_id}"

    def clearance(self, place: Place, info: ObjectInfo, face: DockingFace) -> float:
        """Return what the true pose leaves around the tines (m); nan without pockets, -inf if the tines are too short.

        It is the smaller of the clearances to the nominal pockets and to the surface, so that both are evaluated of the
        same.
        """
        if not face.pockets:
            return float("nan")
        key = info.obj_id, self.surface(place, info), face.name
        if key not in self._clearances:
            slack = docking_slack(np.eye(4)[None], face)
            clearances = [float(slack.lateral[0]), float(slack.vertical[0])]
            lane = self.lane(place, info, face)
            if lane is not None:
                clearances.append(float(mesh_slack(np.eye(4)[None], face, -float(info.size[2]) / 2.0, lane)[0]))
            self._clearances[key] = min(clearances) if slack.depth[0] >= 0.0 else float("-inf")
        return self._clearances[key]

    def lane(self, place: Place, info: ObjectInfo, face: DockingFace) -> Float[np.ndarray, "m 3 3"] | None:
        """Return the triangles near the lanes behind ``face``; None in a dataset without meshes.

        Raises:
            DatasetError: A mesh cannot be read.
        """
        if info.read_mesh is None:
            return None
        name = self.surface(place, info)
        if (name, face.name) not in self._lanes:
            if name not in self._meshes:
                item = self.objects.get((place[0], place[2]))
                own = None if item is None or self.reader is None else read_damaged_mesh(self.reader.root, item)
                self._meshes[name] = own or info.mesh()
            self._lanes[name, face.name] = lane_triangles(self._meshes[name], face)
        return self._lanes[name, face.name]


def face_columns(
    estimated: PalletFace,
    T_camera_object: Transform,
    faces: Sequence[DockingFace],
    standing: tuple[Standings, Place, ObjectInfo] | None = None,
) -> dict[str, Any]:
    """Return what a row of scores says of docking, for the face that the face means: the one with its direction.

    Args:
        estimated: The estimate.
        T_camera_object: The true pose.
        faces: Sides of the object that can be approached.
        standing: How objects stand, and which of them it is; None is not known.

    Returns:
        Columns of the error table; none where that side has not as many pockets as the face.
    """
    T_object_dock = invert(T_camera_object) @ estimated.T_camera_dock
    face = max(faces, key=lambda item: float(item.T_object_dock[:3, 0] @ T_object_dock[:3, 0]))
    if not face.pockets or len(face.pockets) != len(estimated.pockets):
        return {}
    T_object_estimated = (T_object_dock @ invert(face.T_object_dock))[None]
    aside = [(invert(face.T_object_dock) @ pocket.T_object_pocket)[1, 3] for pocket in face.pockets]
    ordered = estimated.pockets[np.argsort(estimated.pockets[:, 0])]
    centres = ordered[np.argsort(np.argsort(aside))]
    tines = [make_transform(np.eye(3), np.array([0.0, *centre])) for centre in centres]
    errors = docking_errors(T_object_estimated, face)
    slack = docking_slack(T_object_estimated, face, tines)
    clearance = np.minimum(slack.lateral, slack.vertical)
    limiting: str | None = None
    if standing is not None:
        standings, place, info = standing
        lane = standings.lane(place, info, face)
        if lane is not None and np.isfinite(slack.heel[0]):
            clearance = mesh_slack(T_object_estimated, face, -float(info.size[2]) / 2.0, lane, tines)
        if standings.verdict(place, face) not in ("", FREE, UNDER_A_STACK):
            # The truck would go where it cannot stand.
            limiting = "wrong_face"
            slack, clearance = DockingSlack(*np.full((4, 1), -np.inf)), np.array([-np.inf])
    return {
        "face": face.name,
        **{name: float(getattr(errors, name)[0]) for name in ("depth", "lateral", "vertical", "yaw", "pitch")},
        "slack_lateral": float(slack.lateral[0]),
        "slack_vertical": float(slack.vertical[0]),
        "slack_depth": float(slack.depth[0]),
        "slack_mesh": float(clearance[0]),
        "limiting_error": limiting or failure_axes(errors, slack, face, clearance)[0],
    }
