"""Meshes: each once as a class in its own frame; parts refer to it, stretched and placed."""

from pathlib import Path
from typing import Any

import numpy as np

from warehouse_sim.errors import DatasetError, shown
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.interchange.usd.bindings import bindings

_EXACT = "warehouseSim:points"
"""Points in double precision where single rounds them: 1e-6 m are lost beyond 16 m."""
_MOST_TRIANGLES = 1_000_000


class MeshClasses:
    """The meshes of a stage, added when they are first requested.

    Args:
        stage: Where.
        root: Path of the prim that they are children of.
    """

    def __init__(self, stage: Any, root: str) -> None:
        self._stage, self._root = stage, root
        self._paths: dict[TriangleMesh, str] = {}

    def path_of(self, mesh: TriangleMesh) -> str:
        """Return the path of the class of ``mesh``."""
        if mesh not in self._paths:
            self._paths[mesh] = f"{self._root}/mesh_{len(self._paths):04d}"
            _add(self._stage, self._paths[mesh], mesh)
        return self._paths[mesh]


def _add(stage: Any, path: str, mesh: TriangleMesh) -> None:
    pxr = bindings()
    geometry, vt = pxr.Geom.Mesh.Define(stage, path), pxr.Vt
    points = mesh.vertices.astype(np.float32)
    geometry.CreatePointsAttr(vt.Vec3fArray.FromNumpy(points))
    geometry.CreateFaceVertexCountsAttr(vt.IntArray.FromNumpy(np.full(len(mesh.faces), 3, np.int32)))
    geometry.CreateFaceVertexIndicesAttr(vt.IntArray.FromNumpy(mesh.faces.ravel().astype(np.int32)))
    geometry.CreateSubdivisionSchemeAttr(pxr.Geom.Tokens.none)
    # Edges are sharp: each corner has the normal of its face.
    normals = np.repeat(mesh.face_normals(), 3, axis=0).astype(np.float32)
    geometry.CreateNormalsAttr(vt.Vec3fArray.FromNumpy(normals))
    geometry.SetNormalsInterpolation(pxr.Geom.Tokens.faceVarying)
    geometry.CreateExtentAttr(vt.Vec3fArray.FromNumpy(np.stack([points.min(axis=0), points.max(axis=0)])))
    if not np.array_equal(points, mesh.vertices):
        exact = geometry.GetPrim().CreateAttribute(_EXACT, pxr.Sdf.ValueTypeNames.Double3Array)
        exact.Set(vt.Vec3dArray.FromNumpy(np.ascontiguousarray(mesh.vertices, float)))


class MeshReader:
    """Reads meshes; equal ones become one object, so that renderers draw them together.

    Args:
        path: File, for messages.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._known: dict[tuple[bytes, bytes], TriangleMesh] = {}

    def read(self, prim: Any) -> TriangleMesh:
        """Return the triangles of a mesh prim in its own frame.

        Raises:
            DatasetError: It is no triangle mesh, or a value cannot be used.
        """
        geometry = bindings().Geom.Mesh(prim)
        points = np.array(geometry.GetPointsAttr().Get() or (), np.float32).reshape(-1, 3)
        counts = np.array(geometry.GetFaceVertexCountsAttr().Get() or (), int)
        faces = np.array(geometry.GetFaceVertexIndicesAttr().Get() or (), np.int32)
        if len(counts) == 0 or (counts != 3).any() or len(faces) != 3 * len(counts):
            self._reject(prim, "must be triangles", f"{len(counts)} faces with {len(faces)} corners")
        if len(counts) > _MOST_TRIANGLES:
            self._reject(prim, f"may have {_MOST_TRIANGLES:,} triangles", f"{len(counts):,}")
        if faces.min() < 0 or faces.max() >= len(points):
            self._reject(prim, f"must name its {len(points)} points", f"{faces.min()} to {faces.max()}")
        attribute = prim.GetAttribute(_EXACT)
        exact = np.array(attribute.Get() or (), float).reshape(-1, 3) if attribute else points.astype(float)
        # Another program moves points without knowing of the exact ones.
        vertices = exact if np.array_equal(exact.astype(np.float32), points) else points.astype(float)
        if not np.isfinite(vertices).all():
            self._reject(prim, "must have finite points", "some that are not")
        key = vertices.tobytes(), faces.tobytes()
        return self._known.setdefault(key, TriangleMesh(vertices, faces.reshape(-1, 3)))

    def _reject(self, prim: Any, wanted: str, found: str) -> None:
        raise DatasetError(f"{self._path}: {prim.GetPath()} {wanted}, found {shown(found)}; write the scene again")
