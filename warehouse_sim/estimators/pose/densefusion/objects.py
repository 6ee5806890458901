"""What an estimator must know of each object: how big it is, how it is symmetric and where its surface is."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np
import torch
from jaxtyping import Bool, Float
from torch import Tensor

from warehouse_sim.dataset.files.plain import is_rigid
from warehouse_sim.dataset.objects import ObjectInfo
from warehouse_sim.errors import TrainingError
from warehouse_sim.geometry.mesh import sample_surface
from warehouse_sim.geometry.pose import transform_points
from warehouse_sim.geometry.symmetry import SymmetryGroup
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
