"""objects.json: what estimators and scores need to know of each CAD geometry, in metres."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Literal, cast

import numpy as np
from jaxtyping import Float

from warehouse_sim.dataset.files.json_file import read_table, write_json
from warehouse_sim.dataset.files.record import Length, Lengths, Name, Record, Rigid
from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.geometry.symmetry import SymmetryGroup, shape_symmetry
from warehouse_sim.schema import ObjectModel, Pocket

FACES: dict[str, tuple[float, float, float]] = {
    "-x": (-1.0, 0.0, 0.0),
    "+x": (1.0, 0.0, 0.0),
    "-y": (0.0, -1.0, 0.0),
    "+y": (0.0, 1.0, 0.0),
}
"""Sides that a pocket can open on, with their outward normals."""
_Face = Literal["-x", "+x", "-y", "+y"]
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

    @property
    def has_mesh(self) -> bool:
        """Whether a mesh of its surface is stored."""
        return self.has_cad and self.read_mesh is not None

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
        diameter=model.diameter,
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
    entries = {obj_id: _row(object_info(by_id[obj_id], root)).row() for obj_id in sorted(by_id)}
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
        obj_id: _ObjectRow.read(data, f"{path}: {obj_id}").info(obj_id, root, read_mesh)
        for obj_id, data in table.items()
    }


def _row(info: ObjectInfo) -> "_ObjectRow":
    pockets = tuple(_PocketRow(cast(_Face, p.face), p.T_object_pocket, p.size) for p in info.pockets)
    symmetries = tuple(info.symmetry.transforms)
    return _ObjectRow(info.name, info.class_name, info.size, info.diameter, symmetries, pockets, info.is_scan or None)


@dataclass(frozen=True, eq=False)
class _PocketRow(Record):
    """A pocket as objects.json holds it."""

    face: _Face
    T_object_pocket: Rigid
    size: Lengths


@dataclass(frozen=True, eq=False)
class _ObjectRow(Record):
    """An entry of objects.json; its number is its key."""

    name: Name
    class_name: Name
    size: Lengths
    diameter: Length
    symmetries: tuple[Rigid, ...]
    pockets: tuple[_PocketRow, ...]
    is_scan: bool | None = field(default=None, metadata={"omitted": True})

    def __post_init__(self) -> None:
        if not 1 <= len(self.symmetries) <= _MOST_SYMMETRIES:
            raise ValueError(f"symmetries must hold the identity, and {_MOST_SYMMETRIES} poses at most")
        least, most = float(self.size.max()), float(np.linalg.norm(self.size))
        if not least - _SAME_LENGTH <= self.diameter <= most + _SAME_LENGTH:
            raise ValueError(
                f"diameter {self.diameter:.6g} m does not go with size {self.size.tolist()} m: "
                f"two points of that box lie {least:.6g} to {most:.6g} m apart at most"
            )

    def info(self, obj_id: int, root: Path, read_mesh: MeshReader | None) -> ObjectInfo:
        """Return the object that the entry describes."""
        return ObjectInfo(
            obj_id=obj_id,
            name=self.name,
            class_name=self.class_name,
            size=self.size,
            diameter=self.diameter,
            symmetry=SymmetryGroup(np.stack(self.symmetries)),
            pockets=tuple(Pocket(p.face, p.T_object_pocket, p.size) for p in self.pockets),
            root=root,
            read_mesh=read_mesh,
            is_scan=bool(self.is_scan),
        )
