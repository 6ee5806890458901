"""A GLB file read by nothing but struct and json, as its specification describes it."""

import json
import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

_TYPES = {5123: np.uint16, 5125: np.uint32, 5126: np.float32}
_NUMBERS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


@dataclass(frozen=True)
class GltfFile:
    """The JSON of a file and its one buffer."""

    root: dict[str, Any]
    buffer: bytes

    @classmethod
    def read(cls, path: Path) -> "GltfFile":
        data = path.read_bytes()
        magic, version, length = struct.unpack_from("<4sII", data, 0)
        assert (magic, version, length) == (b"glTF", 2, len(data))
        size, kind = struct.unpack_from("<I4s", data, 12)
        assert kind == b"JSON"
        assert size % 4 == 0
        more, second = struct.unpack_from("<I4s", data, 20 + size)
        assert second == b"BIN\0"
        assert 28 + size + more == len(data)
        return cls(json.loads(data[20 : 20 + size]), data[28 + size :])

    def view(self, index: int) -> bytes:
        view = self.root["bufferViews"][index]
        return self.buffer[view["byteOffset"] : view["byteOffset"] + view["byteLength"]]

    def array(self, index: int) -> np.ndarray:
        item = self.root["accessors"][index]
        values = np.frombuffer(self.view(item["bufferView"]), _TYPES[item["componentType"]])
        return values.reshape(item["count"], _NUMBERS[item["type"]])

    def pixels(self, texture: dict[str, int]) -> np.ndarray:
        """Return the RGB or grey pixels of a texture as floats 0-1."""
        image = self.root["images"][self.root["textures"][texture["index"]]["source"]]
        assert image["mimeType"] == "image/png"
        found = cv2.imdecode(np.frombuffer(self.view(image["bufferView"]), np.uint8), cv2.IMREAD_UNCHANGED)
        return (found[..., ::-1] if found.ndim == 3 else found) / 255.0

    def named(self, kind: str, name: str) -> dict[str, Any]:
        (found,) = [item for item in self.root[kind] if item.get("name") == name]
        return found

    def world(self, name: str) -> np.ndarray:
        """Return the matrix of the node called ``name`` in the file's y-up world, composed from the root down."""
        (root,) = self.root["scenes"][self.root["scene"]]["nodes"]
        node = self.named("nodes", name)
        assert self.root["nodes"].index(node) in self.root["nodes"][root]["children"]
        return local(self.root["nodes"][root]) @ local(node)


def local(node: dict[str, Any]) -> np.ndarray:
    x, y, z, w = node["rotation"]
    T = np.eye(4)
    T[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    T[:3, 3] = node["translation"]
    return T
