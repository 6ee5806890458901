"""What a user's YAML file says about an object that its mesh file does not."""

import re
from dataclasses import dataclass, field
from typing import Any, Literal

from warehouse_sim.catalog.mesh_files import Up
from warehouse_sim.config import from_mapping
from warehouse_sim.errors import ConfigError

FIRST_OBJ_ID = 1000
"""Smaller numbers belong to the catalog."""


@dataclass(frozen=True)
class SymmetryConfig:
    """Rotations that leave the object's look unchanged; in YAML ``none``, ``cuboid`` or a mapping of axis and count."""

    kind: Literal["none", "cuboid", "turns"] = "none"
    """No rotation, the half turns of a box about its three axes, or equal turns about one axis."""
    axis: Literal["x", "y", "z"] = "z"
    """Axis of the turns in the object's frame, z up."""
    count: int = 2
    """Turns that make a full one, 2-360; 36 and more stand for a round body."""

    def __post_init__(self) -> None:
        if not 2 <= self.count <= 360:
            raise ValueError(f"count must be 2-360, found {self.count}")

    @classmethod
    def from_plain(cls, data: Any, where: str) -> "SymmetryConfig":
        """Read a name, or a mapping of axis and count."""
        if isinstance(data, dict):
            return from_mapping(cls, {"kind": "turns", **data}, where)
        return from_mapping(cls, {"kind": data}, where)


@dataclass(frozen=True)
class BoxConfig:
    """One collision box, parallel to the object's axes."""

    size: tuple[float, float, float]
    """Edge lengths along x, y and z (m), > 0."""
    centre: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Its centre, from the centre of the object's bounding box (m)."""

    def __post_init__(self) -> None:
        if min(self.size) <= 0.0:
            raise ValueError(f"size must be > 0, found {list(self.size)}")


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
            raise ConfigError(f"{where} must be box, parts or a list of boxes with size and centre, found {data!r}")
        return cls(data)


@dataclass(frozen=True)
class CustomObjectConfig:
    """What the mesh file does not say."""

    name: str
    """Name of the object in recipes: lower case letters, digits and _."""
    class_name: str
    """Detection class, such as carton or machine: lower case letters, digits and _."""
    obj_id: int
    """Number of the geometry in datasets, >= 1000, different for each of your objects and never changed."""
    file: str
    """Mesh file (.obj, .ply, .glb, .usd, .usda, .usdc, .usdz) in the folder of the YAML file or below."""
    scale: float | None = None
    """Metres of one unit of the file, > 0; by default what a USD stage says, else 1."""
    up: Up | None = None
    """Axis of the file that points up; by default y for GLB, what a USD stage says, else z."""
    mass: float = 0.0
    """Mass (kg), >= 0; 0 for what never moves."""
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
                raise ValueError(f"{key}: {getattr(self, key)!r} must be lower case letters, digits and _")
        if self.obj_id < FIRST_OBJ_ID:
            raise ValueError(
                f"obj_id must be >= {FIRST_OBJ_ID}, found {self.obj_id}; smaller numbers are the catalog's"
            )
        if self.scale is not None and self.scale <= 0.0:
            raise ValueError(f"scale must be > 0, found {self.scale}")
        if self.mass < 0.0:
            raise ValueError(f"mass must be >= 0, found {self.mass}")
