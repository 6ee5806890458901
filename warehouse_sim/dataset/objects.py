"""objects.json: what estimators and scores need to know of each CAD geometry, in metres."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float

from warehouse_sim.dataset.json_file import read_table, write_json
from warehouse_sim.dataset.layout import BopLayout, DatasetLayout
from warehouse_sim.dataset.plain import plain, read_transform, take
from warehouse_sim.dataset.ply import read_ply
from warehouse_sim.dataset.shape_symmetry import shape_symmetry
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.mesh import TriangleMesh, diameter
from warehouse_sim.geometry.symmetry import SymmetryGroup
from warehouse_sim.schema import ObjectModel, Pocket


@dataclass(frozen=True, eq=False)
class ObjectInfo:
    """One CAD geometry of a dataset; its frame has the origin at the centre of the bounding box, z up."""

    obj_id: int
    name: str
    class_name: str
    size: Float[np.ndarray, " 3"]
    """Nominal outer edge lengths (m)."""
    diameter: float
    """Largest distance (m) between two vertices."""
    symmetry: SymmetryGroup
    """Poses that look the same, print included."""
    pockets: tuple[Pocket, ...]
    root: Path
    """Folder of the dataset, where the mesh lies."""

    def mesh(self) -> TriangleMesh:
        """Read the CAD surface (m, object frame) from the BOP models.

        Raises:
            DatasetError: The dataset was made without the format "bop", or the mesh cannot be read.
        """
        return self._read("models")

    def metric_mesh(self) -> TriangleMesh:
        """Read the evenly meshed surface (m, object frame), whose vertices are the points that pose errors use."""
        return self._read("models_eval")

    @cached_property
    def shape_symmetry(self) -> SymmetryGroup:
        """The group of the shape, whatever is printed on it: ``symmetry`` or more, measured on the CAD surface.

        Raises:
            DatasetError: As ``mesh``.
        """
        return shape_symmetry(self.mesh(), self.symmetry)

    def _read(self, kind: str) -> TriangleMesh:
        path = BopLayout(DatasetLayout(self.root).format_folder("bop")).model(kind, self.obj_id)
        if not path.is_file():
            raise DatasetError(f"{path}: no mesh of {self.name}; generate the dataset with the format bop")
        mesh = read_ply(path)
        return TriangleMesh(mesh.vertices / 1000.0, mesh.faces)


def object_info(model: ObjectModel, root: Path) -> ObjectInfo:
    """Return what a dataset at ``root`` says of ``model``."""
    return ObjectInfo(
        obj_id=model.obj_id,
        name=model.name,
        class_name=model.class_name,
        size=np.asarray(model.size, dtype=float),
        diameter=diameter(model.mesh().vertices),
        symmetry=model.symmetry,
        pockets=model.pockets,
        root=root,
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


def read_objects(root: Path) -> dict[int, ObjectInfo]:
    """Read objects.json.

    Raises:
        DatasetError: The file is missing or an entry is incomplete or malformed.
    """
    path = DatasetLayout(root).objects
    return {obj_id: _from_plain(obj_id, data, f"{path}: {obj_id}", root) for obj_id, data in read_table(path).items()}


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
        }
    )


def _from_plain(obj_id: int, data: Any, where: str, root: Path) -> ObjectInfo:
    symmetries = take(data, "symmetries", list, where)
    pockets = take(data, "pockets", list, where)
    if not symmetries:
        raise DatasetError(f"{where}: symmetries must hold at least the identity")
    return ObjectInfo(
        obj_id=obj_id,
        name=take(data, "name", str, where),
        class_name=take(data, "class_name", str, where),
        size=_read_size(data, where),
        diameter=take(data, "diameter", float, where),
        symmetry=SymmetryGroup(
            np.stack([read_transform(T, f"{where}: symmetries[{i}]") for i, T in enumerate(symmetries)])
        ),
        pockets=tuple(_read_pocket(pocket, f"{where}: pockets[{i}]") for i, pocket in enumerate(pockets)),
        root=root,
    )


def _read_pocket(data: Any, where: str) -> Pocket:
    T_object_pocket = read_transform(take(data, "T_object_pocket", list, where), where)
    return Pocket(take(data, "face", str, where), T_object_pocket, _read_size(data, where))


def _read_size(data: Any, where: str) -> Float[np.ndarray, " 3"]:
    size = np.array(take(data, "size", list, where), dtype=float)
    if size.shape != (3,) or not (size > 0).all():
        raise DatasetError(f"{where}: size must be three lengths above 0, found {size.tolist()}")
    return size
