"""What an estimator must know of each object: its size, symmetry and surface, and its CAD beside the weights."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, NamedTuple

import numpy as np
import safetensors
import safetensors.numpy
import torch
from jaxtyping import Bool, Float
from torch import Tensor

from warehouse_sim.dataset.files.plain import is_rigid
from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.errors import TrainingError
from warehouse_sim.geometry.mesh import TriangleMesh, sample_surface
from warehouse_sim.geometry.pose import transform_points
from warehouse_sim.geometry.symmetry import SymmetryGroup
from warehouse_sim.output import write_bytes
from warehouse_sim.ranges import Range, ranged

_MOMENT_SAMPLES = 20_000
_BLUR = 1e-3


@dataclass(frozen=True)
@ranged
class ObjectShape:
    """The plain numbers of one CAD geometry that a run folder keeps."""

    obj_id: Annotated[int, Range(1, 999_999)]
    """Number of the geometry in the dataset, 1-999,999."""
    name: str
    """Name of the geometry."""
    diameter: Annotated[float, Range(0.0001, 1000, "m")]
    """Largest distance between two surface points (m), 0.0001-1,000, or the mean box's diagonal of a class without CAD;
    half of it is the network's unit of length."""
    centroid: Annotated[tuple[float, ...], Range(-1000, 1000, "m")]
    """Mean of the surface in the object frame (m), 3 values, -1,000 to 1,000."""
    covariance: Annotated[tuple[float, ...], Range(-1_000_000, 1_000_000, "m^2")]
    """Covariance of the surface about its centroid (m^2), 3x3 row by row, -1,000,000 to 1,000,000."""
    symmetries: Annotated[tuple[tuple[float, ...], ...], Range(-1000, 1000)]
    """Poses that look the same to the network, each a 4x4 matrix row by row (m), -1,000 to 1,000: the declared group,
    or that of the shape where the network sees no colour."""
    surface: Annotated[tuple[float, ...], Range(-1000, 1000, "m")] = ()
    """Points evenly on the surface, 3 values each (m), -1,000 to 1,000, beside their images under the symmetries; where
    the loss compares them."""
    class_name: str = ""
    """Detection class of the geometry."""

    def __post_init__(self) -> None:
        if len(self.centroid) != 3 or len(self.covariance) != 9 or len(self.surface) % 3:
            raise ValueError("centroid must be 3 numbers, covariance 9, and surface 3 a point")
        if not self.symmetries or any(len(values) != 16 for values in self.symmetries):
            raise ValueError("each of symmetries must be 16 numbers, a 4x4 matrix row by row")
        transforms = np.reshape(self.symmetries, (-1, 4, 4))
        if not np.allclose(transforms[:1], np.eye(4)) or not all(is_rigid(T, 1e-4) for T in transforms):
            raise ValueError("symmetries must be poses, the identity first")


def measure_shape(
    info: ObjectInfo, rng: np.random.Generator, sees_colour: bool = True, surface_points: int = 0
) -> ObjectShape:
    """Return the shape of an object of a dataset, its moments over the area of its CAD surface, or over its cloud.

    An object without CAD is a class: its cloud is that of many instances.

    Args:
        info: The object.
        rng: Source of the samples.
        sees_colour: Whether the network can tell poses apart by what is printed on the object.
        surface_points: Points of the surface to keep.

    Raises:
        TrainingError: It has no CAD, and no LiDAR point lies in any of its boxes.
    """
    points = _samples(info, rng)
    symmetry = info.symmetry if sees_colour else info.shape_symmetry
    return ObjectShape(
        obj_id=info.obj_id,
        name=info.name,
        diameter=float(info.diameter),
        centroid=tuple(map(float, points.mean(axis=0))),
        covariance=tuple(map(float, np.cov(points.T, bias=True).ravel())),
        symmetries=tuple(tuple(map(float, T.ravel())) for T in symmetry.transforms),
        surface=tuple(np.round(_closed(points, symmetry, surface_points), 4).ravel().tolist()),
        class_name=info.class_name,
    )


def _closed(points: Float[np.ndarray, "n 3"], group: SymmetryGroup, count: int) -> Float[np.ndarray, "m 3"]:
    """Return about ``count`` of the points, each beside its images under the group.

    So a pose that looks like the true one has all its points where those of the true one are.
    """
    if count == 0:
        return points[:0]
    few = points[: max(1, count // len(group))]
    return np.stack([transform_points(T, few) for T in group.transforms], axis=1).reshape(-1, 3)


def _samples(info: ObjectInfo, rng: np.random.Generator) -> Float[np.ndarray, "n 3"]:
    """Draw points evenly from the CAD surface; of what has none, from its cloud, each moved by about a millimetre.

    So the cloud of one flat side has a covariance that can be inverted.
    """
    if info.has_cad:
        return sample_surface(info.mesh(), _MOMENT_SAMPLES, rng)[0]
    cloud = info.model_points()
    if len(cloud) == 0:
        raise TrainingError(f"{info.root}: no LiDAR point lies in any box of {info.name}; leave it out with --objects")
    return cloud[rng.integers(len(cloud), size=_MOMENT_SAMPLES)] + rng.normal(0.0, _BLUR, (_MOMENT_SAMPLES, 3))


class ShapeTensors(NamedTuple):
    """Shapes of all classes in normalised units (the diameter is 2); groups are padded with the identity."""

    anchors: Float[Tensor, "c 4 3"]
    """Four points with the mean and the covariance of the surface: under any two poses their RMS distance is that of
    the whole surface."""
    symmetry_rotation: Float[Tensor, "c g 3 3"]
    symmetry_translation: Float[Tensor, "c g 3"]
    surface: Float[Tensor, "c m 3"]
    """Points of the surfaces; none unless the loss compares them."""
    half_diameter: Float[Tensor, " c"]
    """Length of the unit (m)."""

    def is_symmetric(self) -> Bool[Tensor, " c"]:
        """Return which classes have more than one look-alike pose."""
        turned = (self.symmetry_rotation - torch.eye(3, device=self.anchors.device)).abs().amax(dim=(1, 2, 3))
        return (turned > 1e-4) | (self.symmetry_translation.abs().amax(dim=(1, 2)) > 1e-4)

    def to(self, device: torch.device) -> "ShapeTensors":
        """Return the same shapes on ``device``."""
        return ShapeTensors(*(value.to(device) for value in self))


def shape_tensors(shapes: Sequence[ObjectShape]) -> ShapeTensors:
    """Stack ``shapes`` in their order, which is the order of the network's classes."""
    most = max(len(shape.symmetries) for shape in shapes)
    half = np.array([shape.diameter / 2.0 for shape in shapes])
    groups = np.stack([
        np.concatenate([
            np.reshape(shape.symmetries, (-1, 4, 4)),
            np.tile(np.eye(4), (most - len(shape.symmetries), 1, 1)),
        ])
        for shape in shapes
    ])  # fmt: skip
    anchors = np.stack([_anchors(shape) for shape in shapes]) / half[:, None, None]
    fewest = min(len(shape.surface) for shape in shapes)
    surface = np.array([shape.surface[:fewest] for shape in shapes]).reshape(len(shapes), fewest // 3, 3)
    arrays = (
        anchors,
        groups[..., :3, :3],
        groups[..., :3, 3] / half[:, None, None],
        surface / half[:, None, None],
        half,
    )
    return ShapeTensors(*(torch.tensor(array, dtype=torch.float32) for array in arrays))


def _anchors(shape: ObjectShape) -> Float[np.ndarray, "4 3"]:
    # The corners of a cube's inscribed tetrahedron have zero mean and unit covariance.
    tetrahedron = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], dtype=float)
    root = np.linalg.cholesky(np.reshape(shape.covariance, (3, 3)))
    return np.array(shape.centroid) + tetrahedron @ root.T


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
