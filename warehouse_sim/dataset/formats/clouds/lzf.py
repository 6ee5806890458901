"""Decompression of LZF, in which PCD files may hold their points.

The stream is that of Marc Lehmann's liblzf: a byte below 32 announces that many bytes and one more as they are; any
other says how many bytes come again, and from how far back.
"""

import struct
from pathlib import Path

from warehouse_sim.errors import DatasetError

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
