"""Point clouds as PCD 0.7, the Point Cloud Library's format: written binary; read as text, binary or compressed.

https://pointclouds.org/documentation/tutorials/pcd_file_format.html
"""

import struct
from pathlib import Path

import numpy as np

from warehouse_sim.dataset.files.point_table import Table
from warehouse_sim.dataset.formats.clouds.text_header import (
    require_places,
    rows_of_bytes,
    rows_of_text,
    split_header,
    table_type,
    whole_number,
)
from warehouse_sim.errors import DatasetError, shown

_LITERAL = 32
_LONG = 7


def decompress(body: bytes, expected: int, path: Path) -> bytes:
    """Return the content of a compressed block with its two sizes before it, as PCD files have it.

    Args:
        body: Sizes, each an unsigned 32-bit number, then the stream.
        expected: Bytes that must come out; no more are ever held.
        path: Of the file, for the message.

    Raises:
        DatasetError: The sizes are others, or the stream ends early or points before its beginning.
    """
    damaged = DatasetError(f"{path}: the compressed points are damaged, or not {expected} bytes as the header says")
    if len(body) < 8:
        raise damaged
    packed, unpacked = struct.unpack_from("<II", body)
    if unpacked != expected or packed > len(body) - 8:
        raise damaged
    stream, found, at = body[8 : 8 + packed], bytearray(), 0
    try:
        while at < packed and len(found) <= expected:
            at = _step(stream, at, found)
    except (IndexError, ValueError) as problem:
        raise damaged from problem
    if len(found) != expected or at != packed:
        raise damaged
    return bytes(found)


def _step(stream: bytes, at: int, found: bytearray) -> int:
    """Undo one piece of the stream and return where the next one begins."""
    control = stream[at]
    at += 1
    if control < _LITERAL:
        found += stream[at : at + control + 1]
        return at + control + 1
    length = control >> 5
    if length == _LONG:
        length += stream[at]
        at += 1
    start = len(found) - ((control & 31) << 8) - stream[at] - 1
    if start < 0:
        raise ValueError("points before the beginning")
    length += 2
    # What comes again may reach into itself, as a run of one byte does.
    piece = found[start : start + length]
    while len(piece) < length:
        piece += piece[: length - len(piece)]
    found += piece
    return at + 1


_KINDS = {"f": "F", "i": "I", "u": "U"}
_SIZES = {"F": (4, 8), "I": (1, 2, 4, 8), "U": (1, 2, 4, 8)}
_KEYS = ("FIELDS", "SIZE", "TYPE", "COUNT", "WIDTH", "HEIGHT", "POINTS", "DATA")
_COLOR = ("red", "green", "blue")


def encode_pcd(table: Table, comment: str) -> bytes:
    """Return the content of a binary PCD file; red, green and blue become the one field ``rgb`` as PCL packs it.

    Args:
        table: The points.
        comment: One line on units and frame.
    """
    table = _packed(table)
    names = table.dtype.names or ()
    types = [table.dtype[name] for name in names]
    header = [
        "# .PCD v0.7 - Point Cloud Data file format",
        f"# {comment}",
        "VERSION 0.7",
        f"FIELDS {' '.join(names)}",
        f"SIZE {' '.join(str(item.itemsize) for item in types)}",
        f"TYPE {' '.join(_KINDS[item.kind] for item in types)}",
        f"COUNT {' '.join('1' for _ in names)}",
        f"WIDTH {len(table)}",
        "HEIGHT 1",
        "VIEWPOINT 0 0 0 1 0 0 0",
        f"POINTS {len(table)}",
        "DATA binary",
        "",
    ]
    return "\n".join(header).encode("ascii") + table.tobytes()


def read_pcd_cloud(path: Path) -> Table:
    """Read a PCD file that anyone wrote; ``rgb`` comes back as red, green, blue.

    Raises:
        DatasetError: The file is missing, damaged, or holds several numbers in one field.
    """
    lines, body = split_header(path, b"DATA")
    given = {words[0]: words[1:] for words in lines if not words[0].startswith("#")}
    missing = [key for key in _KEYS if not given.get(key) and key != "COUNT"]
    if missing:
        raise DatasetError(f"{path}: is no PCD file: the header lacks {', '.join(missing)}")
    row = _row(given, path)
    count = whole_number(given["POINTS"][0], path, "POINTS")
    sides = [whole_number(given[key][0], path, key) for key in ("WIDTH", "HEIGHT")]
    if sides[0] * sides[1] != count:
        raise DatasetError(f"{path}: POINTS is {count}, but WIDTH x HEIGHT is {sides[0]} x {sides[1]}")
    encoding = given["DATA"][0]
    if encoding == "ascii":
        table = rows_of_text(body, count, row, path)
    elif encoding == "binary":
        table = rows_of_bytes(body, count, row, path)
    elif encoding == "binary_compressed":
        table = _columns(decompress(body, count * row.itemsize, path), count, row)
    else:
        raise DatasetError(f"{path}: DATA must be ascii, binary or binary_compressed, found {shown(encoding)}")
    return _unpacked(require_places(table, path))


def _row(given: dict[str, list[str]], path: Path) -> np.dtype:
    names = given["FIELDS"]
    counts = given.get("COUNT") or ["1"] * len(names)
    if not len(names) == len(given["SIZE"]) == len(given["TYPE"]) == len(counts) or set(counts) != {"1"}:
        raise DatasetError(f"{path}: FIELDS, SIZE, TYPE and COUNT must be of one length, and every COUNT 1")
    types = []
    for kind, size in zip(given["TYPE"], given["SIZE"], strict=True):
        if kind not in _SIZES or whole_number(size, path, "SIZE") not in _SIZES[kind]:
            raise DatasetError(f"{path}: a field cannot be of TYPE {shown(kind)} and SIZE {shown(size)}")
        types.append(f"<{kind.lower()}{int(size)}")
    return table_type(names, types, path)


def _columns(content: bytes, count: int, row: np.dtype) -> Table:
    """Return rows from what was compressed field by field."""
    table, start = np.empty(count, row), 0
    for name in row.names or ():
        table[name] = np.frombuffer(content, row[name], count, start)
        start += count * row[name].itemsize
    return table


def _packed(table: Table) -> Table:
    names = table.dtype.names or ()
    if not set(_COLOR) <= set(names):
        return table
    kept = [(name, table.dtype[name].str) for name in names if name not in _COLOR]
    packed = np.empty(len(table), [*kept[:3], ("rgb", "<u4"), *kept[3:]])
    for name, _ in kept:
        packed[name] = table[name]
    red, green, blue = (table[name].astype(np.uint32) for name in _COLOR)
    packed["rgb"] = red << 16 | green << 8 | blue
    return packed


def _unpacked(table: Table) -> Table:
    names = table.dtype.names or ()
    if "rgb" not in names or table.dtype["rgb"].itemsize != 4 or set(_COLOR) & set(names):
        return table
    # Written as a number of either kind, it is the same four bytes.
    bits = np.ascontiguousarray(table["rgb"]).view(np.uint32)
    kept = [(name, table.dtype[name].str) for name in names if name != "rgb"]
    place = names.index("rgb")
    row = np.dtype([*kept[:place], *((name, "u1") for name in _COLOR), *kept[place:]])
    found = np.empty(len(table), row)
    for name, _ in kept:
        found[name] = table[name]
    for name, shift in zip(_COLOR, (16, 8, 0), strict=True):
        found[name] = bits >> np.uint32(shift) & np.uint32(255)
    return found
