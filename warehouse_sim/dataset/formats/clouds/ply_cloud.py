"""Point clouds as PLY: written binary and little-endian; read as text or binary of either order of bytes."""

from pathlib import Path

import numpy as np

from warehouse_sim.dataset.files.ply import ply_header
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

_TYPES = {"f4": "float", "f8": "double", "u1": "uchar", "i1": "char", "i2": "short", "u2": "ushort", "i4": "int"} | {
    "u4": "uint"
}
_CODES = {name: code for code, name in _TYPES.items()} | {
    **{"float32": "f4", "float64": "f8", "int8": "i1", "uint8": "u1"},
    **{"int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4"},
}
_ORDERS = {"ascii": "<", "binary_little_endian": "<", "binary_big_endian": ">"}


def encode_ply(table: Table, comment: str) -> bytes:
    """Return the content of a PLY file with one vertex a point.

    Args:
        table: The points.
        comment: One line on units and frame.
    """
    names = table.dtype.names or ()
    properties = [f"{_TYPES[table.dtype[name].str[1:]]} {name}" for name in names]
    return ply_header(comment, {"vertex": (len(table), properties)}) + table.tobytes()


def read_ply_cloud(path: Path) -> Table:
    """Read the vertices of a PLY file that anyone wrote; what comes after them, such as faces, is passed over.

    Raises:
        DatasetError: The file is missing, damaged, or its first element is no vertex with numbers x, y, z.
    """
    lines, body = split_header(path, b"end_header")
    if lines[0] != ["ply"] or len(lines) < 3 or lines[1][0] != "format" or lines[1][1:2] == []:
        raise DatasetError(f"{path}: is no PLY file: it must begin with 'ply' and its format")
    encoding = lines[1][1]
    if encoding not in _ORDERS:
        raise DatasetError(f"{path}: format must be one of {', '.join(_ORDERS)}, found {shown(encoding)}")
    count, others, names, types = _vertex(lines, path, _ORDERS[encoding])
    row = table_type(names, types, path)
    if encoding == "ascii":
        body = b"\n".join(body.split(b"\n", count)[:count]) if others else body
        return require_places(rows_of_text(body, count, row, path), path)
    if others:
        body = body[: count * row.itemsize]
    table = rows_of_bytes(body, count, row, path)
    return require_places(table.astype(row.newbyteorder("<")), path)


def _vertex(lines: list[list[str]], path: Path, order: str) -> tuple[int, bool, list[str], list[str]]:
    """Return how many vertices there are, whether other elements follow, and names and types of the fields."""
    elements = [words for words in lines if words[0] == "element"]
    if not elements or len(elements[0]) != 3 or elements[0][1] != "vertex":
        raise DatasetError(f"{path}: the first element must be 'vertex'")
    names, types, inside = [], [], False
    for words in lines:
        if words[0] == "element":
            inside = words is elements[0]
        elif words[0] == "property" and inside:
            if len(words) != 3 or words[1] not in _CODES:
                raise DatasetError(f"{path}: a property of a vertex must be a number, found {shown(' '.join(words))}")
            names.append(words[2])
            types.append(np.dtype(order + _CODES[words[1]]).str)
    return whole_number(elements[0][2], path, "the number of vertices"), len(elements) > 1, names, types
