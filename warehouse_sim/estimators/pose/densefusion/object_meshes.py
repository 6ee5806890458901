"""The CAD surfaces of the objects that an estimator knows, kept beside its weights: ICP needs no dataset."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import safetensors
import safetensors.numpy

from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.errors import TrainingError
from warehouse_sim.estimators.pose.densefusion.objects import ObjectShape
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.output import write_bytes

MESHES = "objects.safetensors"


def dataset_meshes(datasets: Sequence[Path], shapes: Sequence[ObjectShape]) -> dict[int, TriangleMesh]:
    """Return the CAD surfaces (m, object frame) of ``shapes`` by obj_id, each from the first dataset that has it.

    Objects without CAD are left out.
    """
    readers = [DatasetReader(data) for data in datasets]
    known = {obj_id: info for reader in reversed(readers) for obj_id, info in reader.objects.items()}
    return {shape.obj_id: known[shape.obj_id].mesh() for shape in shapes if known[shape.obj_id].has_cad}


def write_meshes(run: Path, meshes: Mapping[int, TriangleMesh]) -> None:
    """Write the CAD surfaces (m, object frame) by obj_id into a run folder."""
    tensors = {}
    for obj_id, mesh in meshes.items():
        tensors[f"{obj_id}.vertices"] = np.ascontiguousarray(mesh.vertices, dtype=np.float32)
        tensors[f"{obj_id}.faces"] = np.ascontiguousarray(mesh.faces, dtype=np.int32)
    write_bytes(run / MESHES, safetensors.numpy.save(tensors), durable=True)


def without_mesh(run: Path, shapes: Sequence[ObjectShape]) -> list[str]:
    """Return the names of the objects whose CAD surface a run folder does not have."""
    known = read_meshes(run)
    return [shape.name for shape in shapes if shape.obj_id not in known]


def read_meshes(run: Path) -> dict[int, TriangleMesh]:
    """Return the CAD surfaces (m, object frame) by obj_id.

    Raises:
        TrainingError: The run has none, or the file is malformed.
    """
    path = run / MESHES
    if not path.is_file():
        raise TrainingError(f"{run} has no {MESHES}, which ICP needs; train again, or predict with --refine none")
    try:
        tensors = safetensors.numpy.load_file(path)
        ids = sorted(int(name.removesuffix(".faces")) for name in tensors if name.endswith(".faces"))
        meshes = {i: (tensors[f"{i}.vertices"].astype(float), tensors[f"{i}.faces"]) for i in ids}
    except (safetensors.SafetensorError, KeyError, ValueError) as problem:
        raise TrainingError(f"{path} is malformed: {problem}") from problem
    for number, (vertices, faces) in meshes.items():
        if not (_is_table(vertices, "f") and _is_table(faces, "i") and np.isfinite(vertices).all()):
            raise TrainingError(f"{path} is malformed: object {number} has no table of corners and one of faces")
        if faces.min() < 0 or faces.max() >= len(vertices):
            raise TrainingError(f"{path} is malformed: a face of object {number} has a corner that is not there")
    return {i: TriangleMesh(vertices, faces) for i, (vertices, faces) in meshes.items()}


def _is_table(array: np.ndarray, kind: str) -> bool:
    return array.ndim == 2 and array.shape[1] == 3 and len(array) > 0 and array.dtype.kind == kind
