"""Embree 4 through its C interface: meshes that many objects share, and rays in packets.

The library is the one that embreex brings. embreex's own classes know no instances and copy every triangle of a scene
one by one; placing shared meshes builds a warehouse of 1.5 million triangles in 0.06 CPU-seconds instead of 2.3.
Names, enumerations and structures are those of Embree's include/embree4/*.h.
"""

import ctypes
import weakref
from collections.abc import Iterator, Sequence
from ctypes.util import find_library
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import ClassVar

import numpy as np
from jaxtyping import Bool, Float, Float32, Int32

from warehouse_sim.errors import MissingPackageError, RenderError
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.optional import require

_TRIANGLES, _INSTANCE = 0, 121  # RTCGeometryType
_INDEX, _VERTEX = 0, 1  # RTCBufferType
_UINT3, _FLOAT3, _FLOAT3X4_ROW_MAJOR = 0x5003, 0x9003, 0x9134  # RTCFormat
_COHERENT = 1 << 16  # RTCRayQueryFlags
_ROBUST = 1 << 2  # RTCSceneFlags: no ray slips through the edge that two triangles share
_NATIVE_PACKETS = {16: 34, 8: 33, 4: 32}  # RTCDeviceProperty that tells whether packets of a width run natively

_POINTER, _UINT, _SIZE = ctypes.c_void_p, ctypes.c_uint, ctypes.c_size_t
_FUNCTIONS = {
    "rtcNewDevice": (_POINTER, [ctypes.c_char_p]),
    "rtcGetDeviceProperty": (ctypes.c_ssize_t, [_POINTER, ctypes.c_int]),
    "rtcGetDeviceError": (ctypes.c_int, [_POINTER]),
    "rtcNewScene": (_POINTER, [_POINTER]),
    "rtcSetSceneFlags": (None, [_POINTER, ctypes.c_int]),
    "rtcCommitScene": (None, [_POINTER]),
    "rtcReleaseScene": (None, [_POINTER]),
    "rtcNewGeometry": (_POINTER, [_POINTER, ctypes.c_int]),
    "rtcSetSharedGeometryBuffer": (
        None,
        [_POINTER, ctypes.c_int, _UINT, ctypes.c_int, _POINTER, _SIZE, _SIZE, _SIZE],
    ),
    "rtcSetGeometryInstancedScene": (None, [_POINTER, _POINTER]),
    "rtcSetGeometryTransform": (None, [_POINTER, _UINT, ctypes.c_int, _POINTER]),
    "rtcCommitGeometry": (None, [_POINTER]),
    "rtcAttachGeometryByID": (None, [_POINTER, _POINTER, _UINT]),
    "rtcReleaseGeometry": (None, [_POINTER]),
    **{
        f"rtc{query}{width}": (None, [_POINTER] * 4) for query in ("Intersect", "Occluded") for width in _NATIVE_PACKETS
    },
}

# Rows of the structure RTCRayHit16 (or 8, or 4), each as long as the packet; all four bytes an entry.
_ORIGIN, _DIRECTION, _FAR, _MASK = slice(0, 3), slice(4, 7), 8, 9
_NORMAL, _TRIANGLE, _PIECE, _PLACE = (12, 13, 14), 17, 18, 19
_ROWS = 21
_NOTHING = 0xFFFFFFFF
_PACKETS_AT_ONCE = 512
"""As many as fit into a core's cache."""


class _Query(ctypes.Structure):
    """RTCIntersectArguments: how to look for hits."""

    _fields_: ClassVar = [
        ("flags", ctypes.c_int),
        ("features", ctypes.c_int),
        *((name, _POINTER) for name in ("context", "filter", "intersect")),
        ("least_width", ctypes.c_float),
    ]


_ALONGSIDE = _Query(flags=_COHERENT, features=-1)


@dataclass(frozen=True, eq=False)
class PacketHits:
    """What rays meet first; normals mean nothing where ``place`` is -1."""

    distance: Float32[np.ndarray, " n"]
    """In units of the ray's direction; infinite when nothing is hit."""
    place: Int32[np.ndarray, " n"]
    """Number of the placement, -1 = nothing."""
    piece: Int32[np.ndarray, " n"]
    """Number of the mesh within its group; 0 when nothing is hit."""
    triangle: Int32[np.ndarray, " n"]
    """Number of the triangle within its mesh; -1 when nothing is hit."""
    normal: Float32[np.ndarray, "n 3"]
    """Normal in the group's frame, of any length; components lie one after the other in memory."""


class PlacedMeshes:
    """Groups of meshes, each placed any number of times.

    Args:
        groups: Meshes (m) that are placed together.
        placements: Number of a group and its T_world_group.

    Raises:
        MissingPackageError: embreex is not installed, or without its library.
        RenderError: Embree reports a failure.
    """

    def __init__(self, groups: Sequence[Sequence[TriangleMesh]], placements: Sequence[tuple[int, Transform]]) -> None:
        self._library, self._device = _open()
        self._buffers: list[np.ndarray] = []  # Embree reads them as long as the scenes live
        scenes = [self._group_scene(meshes) for meshes in groups]
        self._scene = self._new_scene()
        for number, (group, T_world_group) in enumerate(placements):
            geometry = self._library.rtcNewGeometry(self._device, _INSTANCE)
            self._library.rtcSetGeometryInstancedScene(geometry, scenes[group])
            rows = np.ascontiguousarray(T_world_group[:3], np.float32)
            self._library.rtcSetGeometryTransform(geometry, 0, _FLOAT3X4_ROW_MAJOR, rows.ctypes.data)
            self._attach(self._scene, geometry, number)
        self._library.rtcCommitScene(self._scene)
        weakref.finalize(self, _release, self._library, [self._scene, *scenes], self._buffers)
        self._require_ok("building")

    def cast(
        self,
        origins: Float[np.ndarray, "n 3"],
        directions: Float[np.ndarray, "n 3"],
        *,
        coherent: bool = False,
        reach: float = np.inf,
    ) -> PacketHits:
        """Return what rays meet first.

        Args:
            origins: Starting points (m).
            directions: Of any length.
            reach: Where rays end, in units of their directions; it is the distance of those that meet nothing.
            coherent: Whether rays that follow one another mostly go the same way: then a packet of them is followed as
                one, which is faster.
        """
        count = len(directions)
        hits = PacketHits(
            distance=np.empty(count, np.float32),
            place=np.empty(count, np.int32),
            piece=np.empty(count, np.int32),
            triangle=np.empty(count, np.int32),
            normal=np.empty((3, count), np.float32).T,
        )
        for rays, packets in self._packets_of(origins, directions):
            packets[:, _FAR] = reach
            words = packets.view(np.uint32)
            words[:, _TRIANGLE] = words[:, _PLACE] = _NOTHING
            words[:, _PIECE] = 0
            self._ask("Intersect", packets, rays.stop - rays.start, coherent)
            _read(packets, rays, hits)
        self._require_ok("casting rays")
        return hits

    def blocked(
        self, origins: Float[np.ndarray, "n 3"], directions: Float[np.ndarray, "n 3"], reach: float = 1.0
    ) -> Bool[np.ndarray, " n"]:
        """Return whether anything lies on rays nearer than ``reach``, in units of their directions."""
        found = np.empty(len(directions), bool)
        for rays, packets in self._packets_of(origins, directions):
            packets[:, _FAR] = reach
            self._ask("Occluded", packets, rays.stop - rays.start, coherent=False)
            found[rays] = packets[:, _FAR].ravel()[: rays.stop - rays.start] < 0.0  # -inf is Embree's yes
        self._require_ok("casting rays")
        return found

    def _packets_of(
        self, origins: Float[np.ndarray, "n 3"], directions: Float[np.ndarray, "n 3"]
    ) -> Iterator[tuple[slice, Float32[np.ndarray, "k r w"]]]:
        """Yield the rays by as many as go into the packets, and these filled with where they start and go."""
        count, width = len(directions), packet_width()
        packets = _aligned((max(1, min(_PACKETS_AT_ONCE, -(-count // width))), _ROWS, width))
        step = len(packets) * width
        for start in range(0, count, step):
            rays = slice(start, min(start + step, count))
            _fill(packets[:, _ORIGIN], origins[rays])
            _fill(packets[:, _DIRECTION], directions[rays])
            packets.view(np.uint32)[:, _MASK] = _NOTHING
            yield rays, packets

    def _ask(self, query: str, packets: Float32[np.ndarray, "k r w"], count: int, coherent: bool) -> None:
        """Let Embree answer a query for the first ``count`` rays of ``packets``."""
        width = packets.shape[2]
        full, rest = divmod(count, width)
        if rest:
            packets[full, _FAR, rest:] = -np.inf  # no rays: what fills up the last packet
        valid = np.full(2 * width, -1, np.int32)
        valid_address = valid.ctypes.data + -valid.ctypes.data % (4 * width)
        answer = getattr(self._library, f"rtc{query}{width}")
        how = ctypes.addressof(_ALONGSIDE) if coherent else None
        first, step = packets.ctypes.data, packets.strides[0]
        for address in range(first, first + (full + (rest > 0)) * step, step):
            answer(valid_address, self._scene, address, how)

    def _group_scene(self, meshes: Sequence[TriangleMesh]) -> int:
        scene = self._new_scene()
        for number, mesh in enumerate(meshes):
            # One more vertex, as Embree reads 16 bytes at the last one.
            vertices = np.zeros((len(mesh.vertices) + 1, 3), np.float32)
            vertices[:-1] = mesh.vertices
            faces = np.ascontiguousarray(mesh.faces, np.uint32)
            self._buffers += [vertices, faces]
            geometry = self._library.rtcNewGeometry(self._device, _TRIANGLES)
            for kind, form, data, rows in (
                (_VERTEX, _FLOAT3, vertices, len(mesh.vertices)),
                (_INDEX, _UINT3, faces, len(faces)),
            ):
                self._library.rtcSetSharedGeometryBuffer(geometry, kind, 0, form, data.ctypes.data, 0, 12, rows)
            self._attach(scene, geometry, number)
        self._library.rtcCommitScene(scene)
        return scene

    def _new_scene(self) -> int:
        scene: int = self._library.rtcNewScene(self._device)
        self._library.rtcSetSceneFlags(scene, _ROBUST)
        return scene

    def _attach(self, scene: int, geometry: int, number: int) -> None:
        self._library.rtcCommitGeometry(geometry)
        self._library.rtcAttachGeometryByID(scene, geometry, number)
        self._library.rtcReleaseGeometry(geometry)  # the scene holds it

    def _require_ok(self, action: str) -> None:
        code = self._library.rtcGetDeviceError(self._device)
        if code:
            raise RenderError(f"Embree failed while {action} (RTCError {code}); check the scene's meshes")


@cache
def _open() -> tuple[ctypes.CDLL, int]:
    """Return the library and a device of it, the same for the whole process."""
    library = ctypes.CDLL(str(library_path()))
    for name, (result, arguments) in _FUNCTIONS.items():
        function = getattr(library, name)
        function.restype, function.argtypes = result, arguments
    # Small structures are built fastest by the calling thread.
    device: int = library.rtcNewDevice(b"threads=1")
    return library, device


def library_path() -> str | Path:
    """Return where the Embree library lies, or the name by which the system finds it.

    Raises:
        MissingPackageError: There is none.
    """
    package = Path(str(require("embreex", "generate", "for LiDAR and ray casting").__file__)).parent
    # Where wheels keep the libraries that they bring: beside the package, or inside of it on macOS.
    folders = (package.parent / "embreex.libs", package / ".dylibs", package)
    found = [path for folder in folders if folder.is_dir() for path in sorted(folder.glob("*embree4*"))]
    installed = found[0] if found else find_library("embree4")
    if installed is None:
        raise MissingPackageError(
            f"no Embree 4 library lies beside {package}; install a wheel of it: pip install 'embreex>=4.4'"
        )
    return installed


@cache
def packet_width() -> int:
    """Return the number of rays in a packet that the processor casts at once."""
    library, device = _open()
    native = (width for width, key in _NATIVE_PACKETS.items() if library.rtcGetDeviceProperty(device, key))
    return next(native, min(_NATIVE_PACKETS))


def _aligned(shape: tuple[int, ...]) -> np.ndarray:
    """Return float32 zeros that start at a multiple of 64 bytes, as packets of 16 must."""
    size = int(np.prod(shape))
    raw = np.zeros(size + 16, np.float32)
    start = -raw.ctypes.data % 64 // 4
    return raw[start : start + size].reshape(shape)


def _fill(rows: Float32[np.ndarray, "k 3 w"], vectors: Float[np.ndarray, "n 3"]) -> None:
    """Put vectors into the packets, in order; what the last packet has more is left alone."""
    full, rest = divmod(len(vectors), rows.shape[2])
    for i in range(3):
        component = vectors[:, i]
        rows[:full, i] = component[: len(vectors) - rest].reshape(full, rows.shape[2])
        if rest:
            rows[full, i, :rest] = component[-rest:]


def _read(packets: Float32[np.ndarray, "k r w"], rays: slice, hits: PacketHits) -> None:
    """Put what the packets hold into the rows ``rays`` of ``hits``."""
    count, words = rays.stop - rays.start, packets.view(np.int32)
    hits.distance[rays] = packets[:, _FAR].ravel()[:count]
    hits.place[rays] = words[:, _PLACE].ravel()[:count]
    hits.piece[rays] = words[:, _PIECE].ravel()[:count]
    hits.triangle[rays] = words[:, _TRIANGLE].ravel()[:count]
    for i, row in enumerate(_NORMAL):
        hits.normal[rays, i] = packets[:, row].ravel()[:count]


def _release(library: ctypes.CDLL, scenes: list[int], buffers: list[Int32[np.ndarray, "..."]]) -> None:
    for scene in scenes:
        library.rtcReleaseScene(scene)
    buffers.clear()
