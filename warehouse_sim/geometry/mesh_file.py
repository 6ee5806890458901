"""Mesh files of any dialect, read by trimesh: PLY (text or binary, with polygons, colours, normals), STL, OBJ, GLB."""

from pathlib import Path

import numpy as np

from warehouse_sim.geometry.mesh import TriangleMesh, merge

Parts = dict[str, tuple[TriangleMesh, np.ndarray]]


def load_parts(path: Path) -> Parts:
    """Return the named meshes of a file in its own units, each with the 4x4 matrix that places it in the file's scene.

    Raises:
        ValueError: The file cannot be read, with the reason in one line.
    """
    # Imported on use: it takes longer to import than all of geometry.
    import trimesh

    try:
        # From an open file, so that nothing beside it can be reached.
        with path.open("rb") as file:
            loaded = trimesh.load_scene(file, file_type=path.suffix[1:].lower(), process=False)
    except Exception as problem:  # trimesh raises whatever its parsers stumble over
        raise ValueError(" ".join(str(problem).split())[:200]) from problem
    parts: Parts = {}
    for node in sorted(loaded.graph.nodes_geometry):
        T_file_part, name = loaded.graph[node]
        geometry = loaded.geometry[name]
        if hasattr(geometry, "faces"):
            mesh = TriangleMesh(np.asarray(geometry.vertices, float), np.asarray(geometry.faces, np.int32))
            parts[path.stem if len(loaded.geometry) == 1 else node] = mesh, np.asarray(T_file_part)
    return parts


def placed(mesh: TriangleMesh, T_file_part: np.ndarray) -> TriangleMesh:
    """Return the mesh where the file's scene has it; a mirrored one is turned right side out."""
    linear = T_file_part[:3, :3]
    vertices = np.asarray(mesh.vertices, float) @ linear.T + T_file_part[:3, 3]
    mirrored = np.linalg.det(linear) < 0
    return TriangleMesh(vertices, np.ascontiguousarray(mesh.faces[:, ::-1]) if mirrored else mesh.faces)


def load_mesh(path: Path) -> TriangleMesh:
    """Return all triangles of a file as one mesh in its own units.

    Raises:
        ValueError: The file cannot be read, or holds no triangles of finite vertices that exist.
    """
    parts = [placed(*part) for part in load_parts(path).values()]
    mesh = merge(parts) if parts else None
    if mesh is None or not len(mesh.faces):
        raise ValueError("it holds no triangles")
    if not np.isfinite(mesh.vertices).all():
        raise ValueError("it has vertices that are not finite")
    if mesh.faces.min() < 0 or mesh.faces.max() >= len(mesh.vertices):
        raise ValueError("it has faces that name vertices which do not exist")
    return mesh
