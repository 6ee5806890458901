"""Normals and object coordinates come back within half a step, as the bytes of the files say."""

import struct
import zlib
from pathlib import Path

import numpy as np
import pytest

from warehouse_sim.dataset.files.png import encode_png
from warehouse_sim.dataset.formats.bop.exact_images import (
    decode_coordinates,
    decode_normals,
    encode_coordinates,
    encode_normals,
)
from warehouse_sim.errors import DatasetError


def stored(data: bytes) -> np.ndarray:
    """Decode a PNG of rows with filter Up by the standard's own words, without an image library."""
    width, height, depth, colour = struct.unpack(">IIBB", data[16:26])
    assert (depth, colour) == (16, 2)
    (length,) = struct.unpack(">I", data[33:37])
    rows = np.frombuffer(zlib.decompress(data[41 : 41 + length]), np.uint8).reshape(height, -1)
    assert set(rows[:, 0]) == {2}
    return np.cumsum(rows[:, 1:], axis=0, dtype=np.uint8).view(">u2").reshape(height, width, 3).astype(int)


def test_normals_are_32767_steps_beside_32768(tmp_path: Path) -> None:
    normals = np.zeros((2, 4, 3), np.float32)
    normals[0, :3] = np.eye(3)
    normals[1, :3] = -np.eye(3)
    normals[0, 3] = np.float32([0.6, 0.0, -0.8])
    data = encode_normals(normals)
    found = stored(data)
    assert found[0, 0].tolist() == [65535, 32768, 32768]
    assert found[1, 2].tolist() == [32768, 32768, 1]
    assert found[1, 3].tolist() == [0, 0, 0]
    assert found[0, 3].tolist() == [32768 + 19660, 32768, 32768 - 26214]
    (tmp_path / "n.png").write_bytes(data)
    assert np.abs(decode_normals(tmp_path / "n.png") - normals).max() <= 0.51 / 32767


def test_coordinates_are_65534_steps_from_1(tmp_path: Path) -> None:
    coordinates = np.full((1, 4, 3), np.nan, np.float32)
    coordinates[0, 0] = 0.0, 0.5, 1.0
    coordinates[0, 1] = -0.01, 1.01, 0.25  # a surface that leaves its nominal box
    coordinates[0, 2] = 0.0
    data = encode_coordinates(coordinates)
    found = stored(data)
    assert found[0, 0].tolist() == [1, 32768, 65535]
    assert found[0, 1].tolist() == [1, 65535, 1 + round(0.25 * 65534)]
    assert found[0, 2].tolist() == [1, 1, 1]
    assert found[0, 3].tolist() == [0, 0, 0]
    (tmp_path / "c.png").write_bytes(data)
    read = decode_coordinates(tmp_path / "c.png")
    assert np.isnan(read[0, 3]).all()
    assert np.abs(read[0, :3] - np.clip(coordinates[0, :3], 0, 1)).max() <= 0.51 / 65534


@pytest.mark.parametrize("decode", [decode_normals, decode_coordinates])
@pytest.mark.parametrize("pixels", [np.zeros((2, 2), np.uint16), np.zeros((2, 2, 3), np.uint8)], ids=["grey", "8 bit"])
def test_another_kind_of_image_is_rejected(tmp_path: Path, decode: object, pixels: np.ndarray) -> None:
    (tmp_path / "x.png").write_bytes(encode_png(pixels, "none"))
    with pytest.raises(DatasetError, match="expected a 16-bit colour image, found uint"):
        decode(tmp_path / "x.png")  # type: ignore[operator]


def test_what_is_no_direction_and_no_position_is_rejected(tmp_path: Path) -> None:
    pixels = np.zeros((2, 2, 3), np.uint16)
    pixels[0, 0] = 40000, 40000, 0
    (tmp_path / "x.png").write_bytes(encode_png(pixels, "up"))
    with pytest.raises(DatasetError, match="normals that are not 1 long"):
        decode_normals(tmp_path / "x.png")
    with pytest.raises(DatasetError, match="less than three axes"):
        decode_coordinates(tmp_path / "x.png")
