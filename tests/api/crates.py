"""A mesh file as users bring it."""

from pathlib import Path

import trimesh


def write_crate(folder: Path, name: str = "crate", size: tuple[float, float, float] = (0.5, 0.2, 0.35)) -> Path:
    """Write a box as GLB, whose y axis points up, and return its path."""
    path = folder / f"{name}.glb"
    trimesh.creation.box(size).export(path)
    return path
