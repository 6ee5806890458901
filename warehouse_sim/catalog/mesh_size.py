"""How large a mesh file is, from its header alone: what is far too large is rejected before it is read."""

import json
import re
import struct
from pathlib import Path
from typing import Any

from warehouse_sim.errors import ConfigError

MAX_TRIANGLES = 100_000
"""More would slow every renderer and ray caster down without showing in an image."""
MAX_VERTICES = 3 * MAX_TRIANGLES
"""As many as that many triangles can have."""
_MOST_BYTES = 200_000_000
_MOST_HEADER_BYTES = 20_000_000


def reject_large_file(path: Path) -> None:
    """Reject a mesh file that is too large, or whose header declares too many vertices or triangles.

    Raises:
        ConfigError: It is too large, or its header cannot be read.
    """
    size = path.stat().st_size
    if size > _MOST_BYTES:
        raise ConfigError(
            f"{path.name} has {size // 1_000_000} MB, at most {_MOST_BYTES // 1_000_000} are read; simplify it"
        )
    count = {".ply": _ply_counts, ".glb": _glb_counts}.get(path.suffix.lower())
    if count is not None:
        try:
            vertices, triangles = count(path)
        except (ValueError, LookupError, TypeError, AttributeError, RecursionError, struct.error) as problem:
            raise ConfigError(f"{path.name} cannot be read (its header is broken); export it again") from problem
        reject_many(path.name, vertices, triangles)


def reject_many(name: str, vertices: int, triangles: int) -> None:
    """Reject more vertices or triangles than an object may have.

    Raises:
        ConfigError: There are more.
    """
    if triangles > MAX_TRIANGLES:
        raise ConfigError(f"{name} has {triangles:,} triangles or more; simplify it to {MAX_TRIANGLES:,} at most")
    if vertices > MAX_VERTICES:
        raise ConfigError(f"{name} has {vertices:,} vertices or more; simplify it to {MAX_VERTICES:,} at most")


def _ply_counts(path: Path) -> tuple[int, int]:
    """Return the vertices and faces that the header announces."""
    with path.open("rb") as file:
        header = file.read(65_536).partition(b"end_header")[0]
    counts = {name: int(number) for name, number in re.findall(rb"element\s+(vertex|face)\s+(\d{1,18})\s", header)}
    return counts[b"vertex"], counts.get(b"face", 0)


def _glb_counts(path: Path) -> tuple[int, int]:
    """Return the vertices and triangles of all meshes, each as often as a node shows it (glTF 2.0, 3.7 and 4.4)."""
    with path.open("rb") as file:
        length, _ = struct.unpack("<12xI4s", file.read(20))
        if length > _MOST_HEADER_BYTES:
            raise ValueError(f"a description of {length} bytes")
        content: dict[str, Any] = json.loads(file.read(length))
    accessors = [int(item["count"]) for item in content.get("accessors", [])]
    vertices = triangles = 0
    for node in content.get("nodes", []):
        for part in content["meshes"][node["mesh"]]["primitives"] if "mesh" in node else []:
            corners = accessors[part["attributes"]["POSITION"]]
            vertices += corners
            triangles += (accessors[part["indices"]] if "indices" in part else corners) // 3
    return vertices, triangles
