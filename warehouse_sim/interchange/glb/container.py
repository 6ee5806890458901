"""A binary glTF file as it grows: lists of JSON objects, and one buffer in which equal bytes stand once.

glTF 2.0 specification (Khronos, ISO/IEC 12113), sections 3.6 (buffers, accessors) and 4.4 (the GLB container).
"""

import hashlib
import json
import struct
from typing import Any

import numpy as np
from jaxtyping import Float, Int

_FLOAT, _UINT16, _UINT32 = 5126, 5123, 5125
_VERTICES, _INDICES = 34962, 34963
_JSON, _BINARY = 0x4E4F534A, 0x004E4942
_MAGIC, _VERSION = 0x46546C67, 2
_LIMIT = (1 << 32) - 1


class GlbContainer:
    """What a GLB file is made of; lists keep the order of addition, so that equal scenes give equal bytes."""

    def __init__(self, asset: dict[str, Any]) -> None:
        self._lists: dict[str, list[dict[str, Any]]] = {}
        self._root: dict[str, Any] = {"asset": asset}
        self._buffer = bytearray()
        self._views: dict[bytes, int] = {}
        self._accessors: dict[tuple[int, str, int], int] = {}

    def add(self, kind: str, item: dict[str, Any]) -> int:
        """Append ``item`` to the list ``kind`` ("nodes", "meshes", ...) and return its index."""
        items = self._lists.setdefault(kind, [])
        items.append(item)
        return len(items) - 1

    def set(self, key: str, value: Any) -> None:
        """Set a property of the whole file."""
        self._root[key] = value

    def add_vectors(self, values: Float[np.ndarray, "n k"], bounds: bool = False) -> int:
        """Store float vectors of 2, 3 or 4 numbers; return their accessor. Positions need ``bounds``."""
        data = np.ascontiguousarray(values, np.float32)
        shape = f"VEC{data.shape[1]}"
        view = self._view(data.tobytes(), _VERTICES)
        known = self._accessors.get((view, shape, len(data)))
        if known is not None:
            return known
        item: dict[str, Any] = {"bufferView": view, "componentType": _FLOAT, "count": len(data), "type": shape}
        if bounds:
            item |= {"min": data.min(axis=0).tolist(), "max": data.max(axis=0).tolist()}
        self._accessors[view, shape, len(data)] = index = self.add("accessors", item)
        return index

    def add_indices(self, faces: Int[np.ndarray, "m 3"]) -> int:
        """Store triangles; return their accessor."""
        small = int(faces.max()) < 0xFFFF  # the largest number is kept for restarts
        data = np.ascontiguousarray(faces, np.uint16 if small else np.uint32)
        view = self._view(data.tobytes(), _INDICES)
        known = self._accessors.get((view, "SCALAR", data.size))
        if known is not None:
            return known
        kind = _UINT16 if small else _UINT32
        item = {"bufferView": view, "componentType": kind, "count": data.size, "type": "SCALAR"}
        self._accessors[view, "SCALAR", data.size] = index = self.add("accessors", item)
        return index

    def add_png(self, data: bytes, name: str) -> int:
        """Store an image; return its index."""
        return self.add("images", {"name": name, "mimeType": "image/png", "bufferView": self._view(data, None)})

    def to_bytes(self) -> bytes:
        """Return the file.

        Raises:
            OverflowError: It is larger than the format can say, 4 GiB.
        """
        root = self._root | {key: items for key, items in self._lists.items() if items}
        binary = bytes(self._buffer) + b"\0" * (-len(self._buffer) % 4)
        if binary:
            root["buffers"] = [{"byteLength": len(self._buffer)}]
        text = json.dumps(root, separators=(",", ":"), allow_nan=False).encode()
        text += b" " * (-len(text) % 4)
        chunks = struct.pack("<II", len(text), _JSON) + text
        if binary:
            chunks += struct.pack("<II", len(binary), _BINARY) + binary
        if 12 + len(chunks) > _LIMIT:
            raise OverflowError(f"{12 + len(chunks):,} bytes")
        return struct.pack("<III", _MAGIC, _VERSION, 12 + len(chunks)) + chunks

    def _view(self, data: bytes, target: int | None) -> int:
        key = hashlib.sha256(data + bytes([0 if target is None else target & 0xFF])).digest()
        if key not in self._views:
            self._buffer.extend(b"\0" * (-len(self._buffer) % 4))
            item: dict[str, Any] = {"buffer": 0, "byteOffset": len(self._buffer), "byteLength": len(data)}
            if target is not None:
                item["target"] = target
            self._buffer.extend(data)
            self._views[key] = self.add("bufferViews", item)
        return self._views[key]
