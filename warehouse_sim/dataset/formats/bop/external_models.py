"""The objects of a BOP folder that others made: models_info.json and meshes in millimetres."""

import re
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float

from warehouse_sim.dataset.json_file import read_table
from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.dataset.plain import LENGTHS, Span, take_if_given, take_numbers
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.mesh import TriangleMesh, diameter
from warehouse_sim.geometry.mesh_file import load_mesh
from warehouse_sim.geometry.pose import Transform, make_transform
from warehouse_sim.geometry.symmetry import SymmetryGroup

_KINDS = ("models", "models_eval")
_NAME = re.compile(r"obj_(\d{6})\.(ply|stl|obj)", re.IGNORECASE)
_TURNS = 315
"""Steps of a continuous symmetry, those of bop_toolkit: points move by a hundredth of the radius at most."""
_LENGTHS_MM = Span(1000.0 * LENGTHS.low, 1000.0 * LENGTHS.high)
CLASS_NAME = "object"
"""Class of every object, as BOP has none."""


def read_models(root: Path) -> dict[int, ObjectInfo]:
    """Return what the folder says of each object that it has a mesh of.

    Raises:
        DatasetError: There is no mesh, or a table is malformed.
    """
    files = {kind: _files(root / kind) for kind in _KINDS}
    tables = [root / kind / "models_info.json" for kind in _KINDS]
    table = next((read_table(path) for path in tables if path.is_file()), {})
    numbers = sorted(files["models"] | files["models_eval"])
    if not numbers:
        raise DatasetError(f"{root / 'models'}: holds no obj_000001.ply or the like; poses need their meshes")
    return {number: _object(root, number, table.get(number, {}), files) for number in numbers if number > 0}


def _files(folder: Path) -> dict[int, Path]:
    found = sorted(folder.iterdir()) if folder.is_dir() else []
    return {int(match[1]): path for path in found if (match := _NAME.fullmatch(path.name))}


def _object(root: Path, obj_id: int, row: Any, files: dict[str, dict[int, Path]]) -> ObjectInfo:
    where, read = f"{root / 'models' / 'models_info.json'}: {obj_id}", partial(_read_mesh, files)
    sizes = [take_if_given(row, f"size_{axis}", float, where, _LENGTHS_MM) for axis in "xyz"]
    largest = take_if_given(row, "diameter", float, where, _LENGTHS_MM)
    if None in sizes or largest is None:
        points = read(obj_id, True).vertices
        size, largest_m = np.ptp(points, axis=0), diameter(points)
    else:
        size, largest_m = np.array(sizes, dtype=float) / 1000.0, largest / 1000.0
    return ObjectInfo(
        obj_id=obj_id,
        name=f"obj_{obj_id:06d}",
        class_name=CLASS_NAME,
        size=size,
        diameter=largest_m,
        symmetry=SymmetryGroup(_symmetries(row, where)),
        pockets=(),
        root=root,
        read_mesh=read,
        is_scan=True,
    )


def _read_mesh(files: dict[str, dict[int, Path]], obj_id: int, even: bool) -> TriangleMesh:
    """Read a mesh in metres; where one kind is missing the other stands for it."""
    first, second = reversed(_KINDS) if even else _KINDS
    path = files[first].get(obj_id) or files[second][obj_id]
    try:
        mesh = load_mesh(path)
    except ValueError as problem:
        raise DatasetError(f"{path}: cannot be read ({problem}); export it again") from problem
    return TriangleMesh(mesh.vertices / 1000.0, mesh.faces)


def _symmetries(row: Any, where: str) -> Float[np.ndarray, "n 4 4"]:
    """Return discrete symmetries, each with every step of the continuous ones; the identity comes first."""
    rows = take_if_given(row, "symmetries_discrete", list, where) or []
    listed = [take_numbers({"row": item}, "row", 16, f"{where}: symmetries_discrete").reshape(4, 4) for item in rows]
    discrete = [np.eye(4), *(make_transform(T[:3, :3], T[:3, 3] / 1000.0) for T in listed)]
    turns = [np.eye(4)]
    for axis in take_if_given(row, "symmetries_continuous", list, where) or []:
        turns = _turns(axis, f"{where}: symmetries_continuous")
    return np.stack([a @ b for a, b in product(discrete, turns)])


def _turns(data: Any, where: str) -> list[Transform]:
    axis, offset = take_numbers(data, "axis", 3, where), take_numbers(data, "offset", 3, where) / 1000.0
    if not np.linalg.norm(axis) > 0:
        raise DatasetError(f"{where}: axis is {axis.tolist()}, which has no direction")
    x, y, z = axis / np.linalg.norm(axis)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turns = []
    for angle in 2.0 * np.pi * np.arange(_TURNS) / _TURNS:
        # Rodrigues' formula.
        R = np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross
        turns.append(make_transform(R, offset - R @ offset))
    return turns
