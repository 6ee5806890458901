"""PNG files (ISO/IEC 15948, third edition of the W3C) from arrays, through Intel's fast deflate.

One filter for a whole image, chosen by what the image shows, and the fastest level that builds Huffman codes of its
own; any PNG reader decodes the result. Means over real observations of `demo` and `selective_rack` at 1224 x 370, in
CPU-ms and kB, with the recipe's sensor noise / clean (`make speed` measures this module and OpenCV again):

| | RGB: ms | kB | 16-bit depth: ms | kB | 16-bit ids: ms | kB |
|---|---|---|---|---|---|---|
| this module | 4.4 / 3.7 | 793 / 556 | 2.7 / 0.5 | 490 / 40 | 0.3 | 12 |
| OpenCV, default (run lengths) | 13.6 / 14.6 | 751 / 573 | 8.5 / 6.5 | 493 / 249 | 1.9 | 16 |
| imagecodecs (libpng), level 1 | 27.0 / 22.2 | 801 / 525 | 17.3 / 6.8 | 482 / 34 | 5.0 | 13 |
| fpng | 2.0 / 1.7 | 839 / 664 | - | - | - | - |
| this module with Average | 5.3 / 4.1 | 776 / 551 | 2.9 / 0.9 | 502 / 57 | 0.5 | 17 |
| this module with Paeth | 14.0 / 9.8 | 746 / 511 | 7.1 / 4.4 | 475 / 31 | 2.8 | 11 |
| this module, level 0 | 4.5 / 3.4 | 1168 / 623 | 2.6 / 0.5 | 584 / 48 | 0.3 | 17 |
| this module, level 3 | 5.3 / 5.2 | 799 / 551 | 3.2 / 2.0 | 484 / 44 | 1.7 | 13 |

fpng is faster still for colour, but holds no 16-bit images and comes without binaries.
"""

import struct
import zlib
from itertools import pairwise
from pathlib import Path
from typing import Literal

import numpy as np
from isal import isal_zlib
from isal.igzip_lib import IsalError
from jaxtyping import UInt8, UInt16

from warehouse_sim.errors import DatasetError

Filter = Literal["none", "sub", "up"]
"""What each byte is stored as: itself, its difference from the pixel to the left, or from the one above."""

_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_FILTER_BYTES: dict[Filter, int] = {"none": 0, "sub": 1, "up": 2}
_GREY, _RGB = 0, 2
_LEVEL, _SMALL_LEVEL = 1, 6
_MOST_PIXELS = 2**26
"""Pixels of the largest image that is decoded: 8192 x 8192."""


def encode_png(image: np.ndarray, row_filter: Filter, small: bool = False) -> bytes:
    """Return the PNG file of an image; equal images give equal bytes.

    Args:
        image: UInt8 or UInt16, grey (h, w) or RGB (h, w, 3); h, w >= 1.
        row_filter: Sub suits photographs, Up what stands upright on smooth ground, None what is flat.
        small: Whether zlib takes twenty times as long for a sixth less.

    Raises:
        DatasetError: The image has another shape or type.
    """
    depth = 8 * image.dtype.itemsize if image.dtype.kind == "u" and image.dtype.itemsize <= 2 else None
    grey, colour = image.ndim == 2, image.ndim == 3 and image.shape[2] == 3
    if depth is None or not (grey or colour) or image.size == 0:
        raise DatasetError(f"an image of shape {image.shape} and type {image.dtype} cannot be encoded as PNG")
    height, width = image.shape[:2]
    # Width, height, bits a channel, colour type; then deflate, the five filters, no interlacing.
    header = struct.pack(">IIBBBBB", width, height, depth, _RGB if colour else _GREY, 0, 0, 0)
    samples = np.ascontiguousarray(image, image.dtype.newbyteorder(">"))
    rows = samples.view(np.uint8).reshape(height, -1)
    filtered = _filtered(rows, rows.shape[1] // width, row_filter)
    data = zlib.compress(filtered, _SMALL_LEVEL) if small else isal_zlib.compress(filtered, _LEVEL)
    return b"".join([_SIGNATURE, *_chunk(b"IHDR", header), *_chunk(b"IDAT", data), *_chunk(b"IEND", b"")])


def smaller_png(image: np.ndarray) -> bytes:
    """Return the smallest PNG file of a grey image that is still quick to read: with Up or with no filter.

    Readings of stereo repeat few steps of disparity, farther away so few that Up breaks their repetitions up. The fast
    level says which filter wins; it was right for all 32 images that it was tried with.
    """
    filters: tuple[Filter, Filter] = ("up", "none")
    return encode_png(image, min(filters, key=lambda name: len(encode_png(image, name))), small=True)


def decode_plain_png(data: bytes, where: str) -> UInt16[np.ndarray, "h w"] | None:
    """Return the pixels of a whole 16-bit grey PNG as this module writes it, in half of OpenCV's time; None of others.

    Raises:
        DatasetError: Its pixels are too few, too many or damaged.
    """
    width, height, *form = struct.unpack(">IIBBBBB", data[16:29])
    length = int.from_bytes(data[33:37], "big")
    behind = data[49 + length : 53 + length] if length < len(data) else b""
    if form != [16, _GREY, 0, 0, 0] or data[8:12] != b"\0\0\0\r" or (data[37:41], behind) != (b"IDAT", b"IEND"):
        return None
    size = height * (2 * width + 1)
    try:
        stored = isal_zlib.decompressobj().decompress(data[41 : 41 + length], size + 1)
    except IsalError as problem:  # type: ignore[misc]  # its stubs call it a value
        raise DatasetError(f"{where}: is a damaged PNG image ({problem}); generate the dataset again") from problem
    if len(stored) != size:
        raise DatasetError(f"{where}: holds {len(stored)} bytes of pixels, not {size}; generate the dataset again")
    rows = np.frombuffer(stored, np.uint8).reshape(height, -1)
    kind = rows[0, 0]
    if kind not in (_FILTER_BYTES["none"], _FILTER_BYTES["up"]) or (rows[:, 0] != kind).any():
        return None
    pixels = np.ascontiguousarray(rows[:, 1:])
    if kind == _FILTER_BYTES["up"]:
        for above, row in pairwise(pixels):
            np.add(row, above, out=row)
    return pixels.view(">u2").astype(np.uint16)


def png_header_size_wh(header: bytes, where: str) -> tuple[int, int]:
    """Return width and height of a PNG file from its first 24 bytes.

    Raises:
        DatasetError: They are those of no PNG, or of one too large to be decoded.
    """
    if len(header) < 24 or header[:8] != _SIGNATURE or header[12:16] != b"IHDR":
        raise DatasetError(f"{where}: is not a PNG image; generate the dataset again")
    width, height = struct.unpack(">II", header[16:24])
    if not 1 <= width * height <= _MOST_PIXELS:
        raise DatasetError(f"{where}: is an image of {width} x {height} pixels, 1 to {_MOST_PIXELS} are read")
    return width, height


def is_rgb_png(path: Path) -> bool:
    """Return whether a file is an 8-bit RGB image in PNG, as its header says."""
    try:
        with open(path, "rb") as file:
            header = file.read(26)
    except OSError:
        return False
    return header[:8] == _SIGNATURE and header[24:26] == bytes([8, _RGB])


def require_whole_png(data: bytes, where: str) -> None:
    """Reject a PNG file with a changed, missing or additional byte: every chunk has its checksum, IEND ends the file.

    Raises:
        DatasetError: It is damaged, or too large to be decoded.
    """
    png_header_size_wh(data[:24], where)
    start, kind = len(_SIGNATURE), b""
    while kind != b"IEND":
        length, kind = int.from_bytes(data[start : start + 4], "big"), data[start + 4 : start + 8]
        end = start + 8 + length
        checksum = int.from_bytes(data[end : end + 4], "big")
        if end + 4 > len(data) or isal_zlib.crc32(memoryview(data)[start + 4 : end]) != checksum:
            raise DatasetError(f"{where}: is a damaged PNG image from byte {start} on; generate the dataset again")
        start = end + 4
    if start != len(data):
        raise DatasetError(
            f"{where}: goes on for {len(data) - start} bytes behind its image; generate the dataset again"
        )


def _filtered(rows: UInt8[np.ndarray, "h b"], pixel_bytes: int, row_filter: Filter) -> UInt8[np.ndarray, "h b+1"]:
    """Return the rows, each behind the number of its filter; differences are modulo 256, outside lies 0."""
    result = np.empty((rows.shape[0], rows.shape[1] + 1), np.uint8)
    result[:, 0] = _FILTER_BYTES[row_filter]
    stored = result[:, 1:]
    if row_filter == "none":
        stored[:] = rows
    elif row_filter == "sub":
        stored[:, :pixel_bytes] = rows[:, :pixel_bytes]
        np.subtract(rows[:, pixel_bytes:], rows[:, :-pixel_bytes], out=stored[:, pixel_bytes:])
    else:
        stored[0] = rows[0]
        np.subtract(rows[1:], rows[:-1], out=stored[1:])
    return result


def _chunk(kind: bytes, data: bytes) -> tuple[bytes, ...]:
    checksum = isal_zlib.crc32(data, isal_zlib.crc32(kind))
    return len(data).to_bytes(4, "big"), kind, data, checksum.to_bytes(4, "big")
