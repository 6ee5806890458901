"""The objects of a third-party BOP folder: models_info.json and meshes in millimetres."""

import re
from dataclasses import replace
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float

from warehouse_sim.dataset.files.json_file import read_table
from warehouse_sim.dataset.files.plain import LENGTHS, Span, take_if_given, take_name, take_numbers
from warehouse_sim.dataset.objects import MeshReader, ObjectInfo
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.mesh import TriangleMesh, diameter, load_mesh
from warehouse_sim.geometry.pose import Transform, make_transform
from warehouse_sim.geometry.symmetry import SymmetryGroup

_EVEN = "models_eval"
_SURFACES = ("models", "models_cad", "models_fine", "models_reconst")
"""Folders of the surface, the better ones first: T-LESS has two, YCB-V a fine one beside the plain one."""
_CLASSES, _NAMES = "classes.json", "names.json"
_NAME = re.compile(r"obj_(\d{6})\.(ply|stl|obj)", re.IGNORECASE)
_TURNS = 315
"""Steps of a continuous symmetry, those of bop_toolkit: points move by a hundredth of the radius at most."""
_LENGTHS_MM = Span(1000.0 * LENGTHS.low, 1000.0 * LENGTHS.high)
CLASS_NAME = "object"
"""Class of every object that classes.json does not name, as BOP has none."""


def model_folders(root: Path) -> list[Path]:
    """Return the folders of meshes: the surfaces first, the better ones before others, then models_eval."""
    known = [name for name in (*_SURFACES, _EVEN) if (root / name).is_dir()]
    more = sorted(path.name for path in root.glob("models_*") if path.is_dir() and path.name not in known)
    return [
        root / name for name in (*(name for name in known if name != _EVEN), *more, _EVEN) if (root / name).is_dir()
    ]


def read_models(root: Path) -> dict[int, ObjectInfo]:
    """Return what the folder says of each object that it has a mesh of.

    Raises:
        DatasetError: There is no mesh, or a table is malformed.
    """
    folders = model_folders(root)
    files = {folder.name: _files(folder) for folder in folders}
    tables = [folder / "models_info.json" for folder in folders]
    table = next((read_table(path) for path in tables if path.is_file()), {})
    numbers = sorted({number for found in files.values() for number in found if number > 0})
    if not numbers:
        raise DatasetError(f"{root / 'models'}: holds no obj_000001.ply or the like; poses need their meshes")
    classes, names = _words(root / _CLASSES, "class"), _words(root / _NAMES, "name")
    return {
        number: replace(
            _object(root, number, table.get(number, {}), files, classes.get(number, CLASS_NAME)),
            name=names.get(number, f"obj_{number:06d}"),
        )
        for number in numbers
    }


def _words(path: Path, key: str) -> dict[int, str]:
    """Return the user's names by object, such as ``{"1": "ape", "2": "vise"}``; none without the file."""
    if not path.is_file():
        return {}
    table = read_table(path)
    return {number: take_name({key: name}, key, f"{path}: {number}") for number, name in table.items()}


def _files(folder: Path) -> dict[int, Path]:
    found = sorted(folder.iterdir()) if folder.is_dir() else []
    return {int(match[1]): path for path in found if (match := _NAME.fullmatch(path.name))}


def _object(root: Path, obj_id: int, row: Any, files: dict[str, dict[int, Path]], class_name: str) -> ObjectInfo:
    where = f"{root / 'models' / 'models_info.json'}: {obj_id}"
    return described_object(root, obj_id, row, where, partial(_read_mesh, files), class_name)


def described_object(
    root: Path, obj_id: int, row: Any, where: str, read: MeshReader, class_name: str = CLASS_NAME
) -> ObjectInfo:
    """Return what a row of models_info says of an object; what it does not say is measured on the mesh.

    Args:
        root: Folder of the dataset.
        obj_id: Its number.
        row: Size, diameter and symmetries in millimetres, each if given.
        where: File and key, for messages.
        read: Reads its meshes.
        class_name: Its class.

    Raises:
        DatasetError: The row is malformed, or the mesh cannot be read.
    """
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
        class_name=class_name,
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
    ordered = sorted(files, key=lambda name: name == _EVEN, reverse=even)
    return read_mesh_mm(next(files[name][obj_id] for name in ordered if obj_id in files[name]))


def read_mesh_mm(path: Path) -> TriangleMesh:
    """Read a mesh of any origin that is in millimetres; it comes in metres.

    Raises:
        DatasetError: It cannot be read.
    """
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
