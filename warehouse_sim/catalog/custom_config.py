"""What a user's YAML file says about an object that its mesh file does not."""

import re
from dataclasses import dataclass, field
from typing import Annotated, Any, Literal

from warehouse_sim.catalog.mesh_files import Up
from warehouse_sim.config import from_mapping
from warehouse_sim.errors import ConfigError, shown
from warehouse_sim.ranges import Range, ranged

FIRST_OBJ_ID = 1000
"""Smaller numbers belong to the catalog."""
_LEAST_MASS = 0.001
"""What is lighter than this (kg) physics cannot move."""


@dataclass(frozen=True)
@ranged
class SymmetryConfig:
    """Rotations that leave the object's look unchanged; in YAML ``none``, ``cuboid`` or a mapping of axis and count."""

    kind: Literal["none", "cuboid", "turns"] = "none"
    """No rotation, the half turns of a box about its three axes, or equal turns about one axis."""
    axis: Literal["x", "y", "z"] = "z"
    """Axis of the turns in the object's frame, z up."""
    count: Annotated[int, Range(2, 360)] = 2
    """Turns that make a full one, 2-360; 36 and more stand for a round body."""

    @classmethod
    def from_plain(cls, data: Any, where: str) -> "SymmetryConfig":
        """Read a name, or a mapping of axis and count."""
        if isinstance(data, dict):
            return from_mapping(cls, {"kind": "turns", **data}, where)
        return from_mapping(cls, {"kind": data}, where)


@dataclass(frozen=True)
@ranged
class BoxConfig:
    """One collision box, parallel to the object's axes."""

    size: Annotated[tuple[float, float, float], Range(0.001, 100, "m")]
    """Edge lengths along x, y and z (m), 0.001-100."""
    centre: Annotated[tuple[float, float, float], Range(-100, 100, "m")] = (0.0, 0.0, 0.0)
    """Its centre, from the centre of the object's bounding box (m), -100 to 100."""


@dataclass(frozen=True)
class CollisionConfig:
    """What physics collides with; in YAML ``box``, ``parts`` or a list of boxes."""

    kind: Literal["box", "parts", "boxes"] = "box"
    """The bounding box, that of each part of the file, or the boxes that are listed."""
    boxes: tuple[BoxConfig, ...] = ()
    """The listed boxes."""

    @classmethod
    def from_plain(cls, data: Any, where: str) -> "CollisionConfig":
        """Read a name, or a list of boxes."""
        if isinstance(data, list) and data:
            return from_mapping(cls, {"kind": "boxes", "boxes": data}, where)
        if data not in ("box", "parts"):
            raise ConfigError(
                f"{where} must be box, parts or a list of boxes with size and centre, found {shown(data)}"
            )
        return cls(data)


@dataclass(frozen=True)
@ranged
class CustomObjectConfig:
    """What the mesh file does not say."""

    name: str
    """Name of the object in recipes: lower case letters, digits and _."""
    class_name: str
    """Detection class, such as carton or machine: lower case letters, digits and _."""
    obj_id: Annotated[int, Range(FIRST_OBJ_ID, 999_999)]
    """Number of the geometry in datasets, 1,000-999,999, different for each of your objects and never changed."""
    file: str
    """Mesh file (.obj, .ply, .glb, .usd, .usda, .usdc, .usdz) in the folder of the YAML file or below."""
    scale: Annotated[float, Range(0.000001, 1000)] | None = None
    """Metres of one unit of the file, 0.000001-1,000; by default what a USD stage says, else 1."""
    up: Up | None = None
    """Axis of the file that points up; by default y for GLB, what a USD stage says, else z."""
    mass: Annotated[float, Range(0, 20_000, "kg")] = 0.0
    """Mass (kg), 0-20,000; 0 for what never moves."""
    bears: Annotated[float, Range(0, 100_000, "kg")] | None = None
    """What may stand on it where it is stacked as goods (kg), 0-100,000; by default what its class does in the catalog,
    nothing for a class of your own.
    """
    material: str | None = None
    """Catalog material of all parts that ``materials`` does not name."""
    materials: dict[str, str] = field(default_factory=dict)
    """Catalog material of parts by their names in the file."""
    symmetry: SymmetryConfig = field(default_factory=SymmetryConfig)
    """Rotations that leave the look unchanged: none, those of a box, or equal turns about an axis."""
    collision: CollisionConfig = field(default_factory=CollisionConfig)
    """What physics collides with: the bounding box, that of each part, or boxes that you list."""

    def __post_init__(self) -> None:
        for key in ("name", "class_name"):
            if not re.fullmatch("[a-z][a-z0-9_]*", getattr(self, key)):
                raise ValueError(f"{key}: {shown(getattr(self, key))} must be lower case letters, digits and _")
        if 0.0 < self.mass < _LEAST_MASS:
            raise ValueError(f"mass must be at least {_LEAST_MASS} kg, or 0 for what never moves, found {self.mass}")
