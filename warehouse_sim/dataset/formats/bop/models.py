"""BOP models: the CAD surface to render, and the same surface meshed evenly, whose vertices pose errors use."""

from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from warehouse_sim.dataset.files.checksums import write_checksums
from warehouse_sim.dataset.files.json_file import write_json
from warehouse_sim.dataset.files.ply import write_ply
from warehouse_sim.dataset.formats.bop import BopLayout
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.mesh import TriangleMesh, grid_box, merge, split_long_edges, unit_box
from warehouse_sim.geometry.pose import make_transform, transform_points
from warehouse_sim.geometry.symmetry import SymmetryGroup
from warehouse_sim.output import make_folder
from warehouse_sim.schema import ObjectModel, Part

FEWEST_TURNS = 36
"""Equal turns about one axis from which a shape counts as one of revolution: the surface of a prism of so many sides
leaves the cylinder by 0.4 % of its radius. The number is our own; BOP names none."""
_SAME = 1e-9


def symmetry_rows(group: SymmetryGroup) -> dict[str, Any]:
    """Return the entries ``symmetries_continuous`` and ``symmetries_discrete`` (mm), each only if there is one.

    A group of many equal turns about one of the axes x, y and z becomes that continuous axis and, where the shape can
    also be turned over, one discrete half-turn. All other groups are listed motion by motion, without the identity.
    """
    for axis in np.eye(3):
        fixed = _keeps(group, axis)
        if fixed.sum() < FEWEST_TURNS:
            continue
        turned_over = np.flatnonzero(~fixed)
        row: dict[str, Any] = {"symmetries_continuous": [{"axis": axis.tolist(), "offset": [0.0, 0.0, 0.0]}]}
        if len(turned_over) in (0, fixed.sum()):
            # What turns the axis over is one half-turn and then a turn about the axis.
            return row | _discrete(group, turned_over[:1])
    return _discrete(group, np.arange(1, len(group)))


def _keeps(group: SymmetryGroup, axis: np.ndarray) -> np.ndarray:
    """Return which motions leave every point of an axis through the origin where it is."""
    T = group.transforms
    return np.asarray(
        (np.abs(T[:, :3, :3] @ axis - axis).max(axis=1) < _SAME) & (np.abs(T[:, :3, 3]).max(axis=1) < _SAME)
    )


def _discrete(group: SymmetryGroup, rows: np.ndarray) -> dict[str, Any]:
    if len(rows) == 0:
        return {}
    T = group.transforms[rows]
    in_mm = make_transform(T[:, :3, :3], T[:, :3, 3] * 1000.0)
    return {"symmetries_discrete": (in_mm.reshape(-1, 16) + 0.0).tolist()}


_FEWEST, _MOST = 2000, 4000


def write_models(folder: Path, models: Sequence[ObjectModel]) -> None:
    """Write models/ and models_eval/ with their models_info.json, in millimetres, and their checksums.

    Raises:
        DatasetError: A model has no shape.
    """
    layout = BopLayout(folder)
    for kind in ("models", "models_eval"):
        make_folder(layout.models_info(kind).parent)
        infos = {}
        for model in sorted(models, key=lambda model: model.obj_id):
            if not model.parts:
                raise DatasetError(f"BOP: there is no mesh of {model.name}; write a format that holds none")
            mesh = model.mesh() if kind == "models" else even_mesh(model)
            mesh_mm = TriangleMesh(mesh.vertices * 1000.0, mesh.faces)
            write_ply(layout.model(kind, model.obj_id), mesh_mm)
            infos[model.obj_id] = model_info(model, mesh_mm)
        write_json(layout.models_info(kind), infos)
        write_checksums(layout.models_info(kind).parent, [layout.model(kind, obj_id).name for obj_id in infos])


@lru_cache(maxsize=64)
def even_mesh(model: ObjectModel) -> TriangleMesh:
    """Return the surface of ``model`` (m) with 2,000 to 4,000 evenly spread vertices.

    A plain box has only its corners as vertices, which would make every pose error one of corners. Models of very many
    parts, or with very many triangles of their own, end above that number. What comes with one keeps it.
    """
    if model.metric_mesh is not None:
        return model.metric_mesh
    mesh = merge([_even_part(part, np.inf) for part in model.parts])
    if len(mesh.vertices) > _MOST:  # Where nothing is split any more, nothing gets coarser.
        return mesh
    area = model.mesh().face_areas().sum()
    spacing = float(np.sqrt(area / _MOST))
    for _ in range(20):
        mesh = merge([_even_part(part, spacing) for part in model.parts])
        count = len(mesh.vertices)
        if _FEWEST <= count <= _MOST:
            break
        spacing *= float(np.sqrt(count / ((_FEWEST + _MOST) / 2)))
    return mesh


def _even_part(part: Part, spacing: float) -> TriangleMesh:
    if not np.array_equal(part.mesh.vertices, unit_box().vertices):
        return split_long_edges(part.placed(), spacing)
    box = grid_box(part.scale, spacing)
    return TriangleMesh(transform_points(part.T_object_part, box.vertices), box.faces)


def model_info(model: ObjectModel, mesh_mm: TriangleMesh) -> dict[str, Any]:
    """Return a row of models_info.json of a model and its mesh in millimetres."""
    low, high = mesh_mm.vertices.min(axis=0), mesh_mm.vertices.max(axis=0)
    # Of the CAD vertices: those added on its faces lie between them and cannot be farther apart.
    info = {"diameter": model.diameter * 1000.0}
    info |= {f"min_{axis}": float(value) for axis, value in zip("xyz", low, strict=True)}
    info |= {f"size_{axis}": float(value) for axis, value in zip("xyz", high - low, strict=True)}
    return info | symmetry_rows(model.symmetry)
