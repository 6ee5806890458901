"""objects.json: what estimators and scores need to know of each CAD geometry, in metres."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float

from warehouse_sim.dataset.files.json_file import read_table, write_json
from warehouse_sim.dataset.files.plain import (
    LENGTHS,
    plain,
    read_transform,
    shown,
    take,
    take_if_given,
    take_name,
    take_numbers,
)
from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.mesh import TriangleMesh, diameter
from warehouse_sim.geometry.symmetry import SymmetryGroup
from warehouse_sim.schema import ObjectModel, Pocket

FACES: dict[str, tuple[float, float, float]] = {
    "-x": (-1.0, 0.0, 0.0),
    "+x": (1.0, 0.0, 0.0),
    "-y": (0.0, -1.0, 0.0),
    "+y": (0.0, 1.0, 0.0),
}
"""Sides that a pocket can open on, with their outward normals."""
MeshReader = Callable[[int, bool], TriangleMesh]
"""Reads the surface (m, object frame) of an obj_id; on True the same with evenly spread vertices."""
CloudReader = Callable[[], Float[np.ndarray, "n 3"]]
"""Reads the points (m, object frame) that stand for a surface."""
_MOST_SYMMETRIES = 1000
_SAME_LENGTH = 1e-3
"""How far (m) vertices may leave the nominal box."""


@dataclass(frozen=True, eq=False)
class ObjectInfo:
    """One CAD geometry of a dataset; its frame has the origin at the centre of the bounding box, z up."""

    obj_id: int
    name: str
    class_name: str
    size: Float[np.ndarray, " 3"]
    """Nominal outer edge lengths (m)."""
    diameter: float
    """Largest distance (m) between two vertices; the diagonal of its box where it has no CAD."""
    symmetry: SymmetryGroup
    """Poses that look the same, print included."""
    pockets: tuple[Pocket, ...]
    root: Path
    """Folder of the dataset."""
    read_mesh: MeshReader | None = None
    """Where its surface comes from; None in a dataset without meshes."""
    is_scan: bool = False
    """Whether others described it, whose meshes are measured: declared symmetries need not be exact."""
    read_cloud: CloudReader | None = None
    """Where its points come from if it has no CAD: they are its model then, and its diameter is its box's diagonal."""

    @property
    def has_cad(self) -> bool:
        """Whether its surface is known, or only points that a LiDAR saw in its box."""
        return self.read_cloud is None

    def model_points(self) -> Float[np.ndarray, "n 3"]:
        """Read the points (m, object frame) that pose errors use: even vertices of its surface, or its cloud.

        Raises:
            DatasetError: As ``mesh``, or the cloud cannot be read.
        """
        return self.metric_mesh().vertices if self.read_cloud is None else self.read_cloud()

    def mesh(self) -> TriangleMesh:
        """Read the CAD surface (m, object frame).

        Raises:
            DatasetError: The dataset was made without a format that holds meshes, or the mesh cannot be read.
        """
        return self._read(even=False)

    def metric_mesh(self) -> TriangleMesh:
        """Read the evenly meshed surface (m, object frame), whose vertices are the points that pose errors use."""
        return self._read(even=True)

    @cached_property
    def shape_symmetry(self) -> SymmetryGroup:
        """The group of the shape, whatever is printed on it: ``symmetry`` or more, measured on the CAD surface.

        Raises:
            DatasetError: As ``mesh``.
        """
        if not self.has_cad:
            return self.symmetry
        # Imported on use: it brings scipy.spatial, which takes longer to import than all else that reading needs.
        from warehouse_sim.dataset.shape_symmetry import shape_symmetry

        return shape_symmetry(self.mesh(), self.symmetry)

    def _read(self, even: bool) -> TriangleMesh:
        if not self.has_cad:
            raise DatasetError(f"{self.root}: {self.name} has no CAD surface, its model is the points in its box")
        if self.read_mesh is None:
            raise DatasetError(f"{self.root}: no mesh of {self.name}; generate it in a format that holds meshes")
        return self.read_mesh(self.obj_id, even)


def object_info(model: ObjectModel, root: Path) -> ObjectInfo:
    """Return what a dataset at ``root`` says of ``model``."""
    return ObjectInfo(
        obj_id=model.obj_id,
        name=model.name,
        class_name=model.class_name,
        size=np.asarray(model.size, dtype=float),
        diameter=diameter(model.mesh().vertices) if model.parts else float(np.linalg.norm(model.size)),
        symmetry=model.symmetry,
        pockets=model.pockets,
        root=root,
        is_scan=model.metric_mesh is not None,
    )


def write_objects(root: Path, models: Sequence[ObjectModel]) -> None:
    """Write objects.json, sorted by obj_id.

    Raises:
        DatasetError: Two models share an obj_id.
    """
    by_id: dict[int, ObjectModel] = {}
    for model in models:
        other = by_id.setdefault(model.obj_id, model)
        if other is not model or model.obj_id < 1:
            raise DatasetError(
                f"obj_id {model.obj_id} of {model.name!r} must be >= 1 and its own, {other.name!r} has it; "
                "give each geometry of the catalog one number"
            )
    entries = {obj_id: _to_plain(object_info(by_id[obj_id], root)) for obj_id in sorted(by_id)}
    write_json(DatasetLayout(root).objects, entries, depth=2)


def read_objects(root: Path, read_mesh: MeshReader | None = None) -> dict[int, ObjectInfo]:
    """Read objects.json.

    Args:
        root: Folder of the dataset.
        read_mesh: Reads the meshes of one of its formats.

    Raises:
        DatasetError: The file is missing or empty, or an entry is incomplete or malformed.
    """
    path = DatasetLayout(root).objects
    table = read_table(path)
    if not table or min(table) < 1:
        raise DatasetError(f"{path}: must hold objects, numbered from 1; generate the dataset again")
    return {
        obj_id: replace(_from_plain(obj_id, data, f"{path}: {obj_id}", root), read_mesh=read_mesh)
        for obj_id, data in table.items()
    }


def _to_plain(info: ObjectInfo) -> dict[str, Any]:
    pockets = [{"face": p.face, "T_object_pocket": p.T_object_pocket, "size": p.size} for p in info.pockets]
    return plain(
        {
            "name": info.name,
            "class_name": info.class_name,
            "size": info.size,
            "diameter": info.diameter,
            "symmetries": info.symmetry.transforms,
            "pockets": pockets,
            **({"is_scan": True} if info.is_scan else {}),
        }
    )


def _from_plain(obj_id: int, data: Any, where: str, root: Path) -> ObjectInfo:
    symmetries = take(data, "symmetries", list, where)
    pockets = take(data, "pockets", list, where)
    if not 1 <= len(symmetries) <= _MOST_SYMMETRIES:
        raise DatasetError(f"{where}: symmetries must hold the identity, and {_MOST_SYMMETRIES} poses at most")
    size, diameter = _read_size(data, where), take(data, "diameter", float, where, LENGTHS)
    least, most = float(size.max()), float(np.linalg.norm(size))
    if not least - _SAME_LENGTH <= diameter <= most + _SAME_LENGTH:
        raise DatasetError(
            f"{where}: diameter {diameter:.6g} m does not go with size {size.tolist()} m: "
            f"two points of that box lie {least:.6g} to {most:.6g} m apart at most"
        )
    return ObjectInfo(
        obj_id=obj_id,
        name=take_name(data, "name", where),
        class_name=take_name(data, "class_name", where),
        size=size,
        diameter=diameter,
        symmetry=SymmetryGroup(
            np.stack([read_transform(T, f"{where}: symmetries[{i}]") for i, T in enumerate(symmetries)])
        ),
        pockets=tuple(_read_pocket(pocket, f"{where}: pockets[{i}]") for i, pocket in enumerate(pockets)),
        root=root,
        is_scan=take_if_given(data, "is_scan", bool, where) or False,
    )


def _read_pocket(data: Any, where: str) -> Pocket:
    T_object_pocket = read_transform(take(data, "T_object_pocket", list, where), where)
    face = take(data, "face", str, where)
    if face not in FACES:
        raise DatasetError(f"{where}: face must be {', '.join(FACES)}, found {shown(face)}")
    return Pocket(face, T_object_pocket, _read_size(data, where))


def _read_size(data: Any, where: str) -> Float[np.ndarray, " 3"]:
    return take_numbers(data, "size", 3, where, LENGTHS)
