"""What things are: materials, parts, pockets, and the model of an object that is made of them."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal

import numpy as np
from jaxtyping import Float

from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.mesh import TriangleMesh, diameter, merge
from warehouse_sim.geometry.pose import Transform, transform_points
from warehouse_sim.geometry.symmetry import SymmetryGroup

RETROREFLECTIVE = 2.0
"""Remission from which a material sends light back to where it came from, whatever the incidence."""

SAME_SHAPE = "look-"
"""Begins the tag in the name of a model that has the surface of its type and other colours."""


@dataclass(frozen=True)
class Material:
    """Surface appearance in the metallic-roughness model, and what a LiDAR sees of it."""

    name: str
    base_color: tuple[float, float, float]
    """Linear albedo, 0-1 a channel."""
    roughness: float = 0.8
    """Perceptual roughness, 0-1."""
    metallic: float = 0.0
    """0 for dielectrics, 1 for metals."""
    texture: str | None = None
    """Detail texture that modulates the albedo: name of a shipped one, "package:folder" in another package, or None."""
    texture_size: float = 1.0
    """Edge length of one texture tile (m)."""
    remission: float = 0.5
    """Relative LiDAR remission at 905 nm and normal incidence, 1 = white plaster."""
    emission: float = 0.0
    """Luminance (cd/m^2) that it emits, in the colour ``base_color``."""
    opacity: float = 1.0
    """Fraction of light that the surface stops, 0-1; below 1 it is a film that what lies behind shines through."""
    picture: str | None = None
    """Name of a generated colour picture ("shipping_label:4711", see catalog/pictures) that is laid once over the
    largest faces of each part: upright along the part's z, or along its y where it lies; it covers colour and texture
    as far as it is opaque. Films have none."""


def is_damaged(model: str) -> bool:
    """Return whether a model's surface is not that of its type: the catalog names such ones ``epal1~1f00ba44``.

    What has other colours alone is named ``plastic_runners~look-1f00ba44``.
    """
    return "~" in model and f"~{SAME_SHAPE}" not in model


@dataclass(frozen=True, eq=False)
class Part:
    """A piece of an object: a mesh, stretched, placed and painted."""

    mesh: TriangleMesh
    scale: Float[np.ndarray, "3"]
    """Factors along the mesh's own axes; the edge lengths (m) when the mesh is the unit box."""
    T_object_part: Transform
    material: str
    """Name of a material of the scene."""
    role: str = ""
    """What the piece is in its object where something asks, as wear does of a pallet's: "deck", "block", ..."""

    def placed(self) -> TriangleMesh:
        """Return the part's mesh in the object frame (m)."""
        return TriangleMesh(transform_points(self.T_object_part, self.mesh.vertices * self.scale), self.mesh.faces)


@dataclass(frozen=True, eq=False)
class Pocket:
    """An opening that a fork can enter: a prism along +x of its own frame, x = 0 at the opening."""

    face: str
    """Side of the object it opens on, "-x", "+x", "-y" or "+y"; the pockets of one face are entered together."""
    T_object_pocket: Transform
    """Origin at the centre of the opening, x inwards, z up."""
    size: Float[np.ndarray, "3"]
    """Depth along x, clear width along y, clear height along z (m)."""


@dataclass(frozen=True, eq=False)
class LuminousFace:
    """The flat face of an object that light comes out of: the cover of a luminaire, or a door that opens to the sky."""

    source: Literal["electric", "daylight"]
    material: str
    """Of the parts that are the face; in a scene each object has its own, which emits what its light gives."""
    catalog_material: str
    """Name of the catalog's material that it is made of."""
    inward: Float[np.ndarray, "3"]
    """Unit vector from the face into the object, in the object frame."""
    distance: float
    """From the object's origin to the face (m)."""
    area: float
    """Of the face (m^2)."""


@dataclass(frozen=True, eq=False)
class ObjectModel:
    """One CAD geometry with its physics and meaning; origin at the centre of its bounding box, z up."""

    name: str
    class_name: str
    """Detection class: pallet, carton, rack, floor, ..."""
    obj_id: int
    """Number of this geometry, unique in a dataset (the BOP model id), >= 1."""
    size: Float[np.ndarray, "3"]
    """Nominal outer edge lengths (m)."""
    parts: tuple[Part, ...]
    collision: tuple[OrientedBox, ...]
    """Boxes in the object frame that stand for the object in physics."""
    mass: float = 0.0
    """Kilograms; 0 for what never moves."""
    symmetry: SymmetryGroup = field(default_factory=SymmetryGroup.trivial)
    pockets: tuple[Pocket, ...] = ()
    luminous_face: LuminousFace | None = None
    """Where light comes out of it; None for what is no luminaire."""
    materials: tuple[Material, ...] = ()
    """Materials of its parts that the catalog does not hold: what comes from elsewhere brings its own."""
    make: str = ""
    """Whose make it is ("EPAL", "POOL"), where that is branded on it."""
    bears: float | None = None
    """What may stand on it (kg); None leaves it to what its class bears."""
    metric_mesh: TriangleMesh | None = None
    """The surface (m, object frame) whose vertices pose errors use, where a dataset had one; None = yet to be made."""

    def mesh(self) -> TriangleMesh:
        """Return all parts as one mesh in the object frame (m)."""
        return merge([part.placed() for part in self.parts])

    @cached_property
    def radius(self) -> float:
        """Distance (m) of the farthest vertex of its surface from its origin."""
        return max(float(np.linalg.norm(part.placed().vertices, axis=1).max()) for part in self.parts)

    @cached_property
    def diameter(self) -> float:
        """Largest distance between two points of its surface (m), of its boxes' size where it has none."""
        return diameter(self.mesh().vertices) if self.parts else float(np.linalg.norm(self.size))
