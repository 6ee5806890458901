"""JPEG files of colour images, as cameras store them: at one stated quality, colour differences halved."""

import cv2
import numpy as np
from jaxtyping import UInt8

from warehouse_sim.dataset.files.extent import Source, read_bytes, where_of
from warehouse_sim.errors import DatasetError

QUALITY = 90
"""Of libjpeg's tables, 1-100. That of the cameras in ``sensors``, whose images it keeps to one or two codes: with 52 dB
on `selective_rack` and 58 dB on `dock_staging`, where 95 has 48 and 50 dB and a fifth more bytes."""
_START, _END = b"\xff\xd8\xff", b"\xff\xd9"
_FRAMES = frozenset({*range(0xC0, 0xD0)} - {0xC4, 0xC8, 0xCC})
"""Markers whose segment says how large the image is."""
_MOST_PIXELS = 2**26
"""Pixels of the largest image that is decoded: 8192 x 8192."""
_HEAD_BYTES = 4096
"""Where that is said in files of this module; in others it can come later."""


def encode_jpeg(rgb: UInt8[np.ndarray, "h w 3"]) -> bytes:
    """Return the JPEG of an RGB image, with Huffman codes of its own."""
    options = [cv2.IMWRITE_JPEG_QUALITY, QUALITY, cv2.IMWRITE_JPEG_OPTIMIZE, 1]
    options += [cv2.IMWRITE_JPEG_SAMPLING_FACTOR, cv2.IMWRITE_JPEG_SAMPLING_FACTOR_420]
    found, data = cv2.imencode(".jpg", cv2.cvtColor(rgb, cv2.COLOR_RGB2BGR), options)
    assert found
    return data.tobytes()


def decode_jpeg(source: Source) -> UInt8[np.ndarray, "h w 3"]:
    """Read an 8-bit colour JPEG as RGB.

    Raises:
        DatasetError: It is none, is cut off, or is too large to be decoded.
    """
    data, where = read_bytes(source), where_of(source)
    _size_wh(data, where)
    if data[-2:] != _END:
        raise DatasetError(f"{where}: is a damaged JPEG image, its end is missing; copy it again")
    try:
        flags = cv2.IMREAD_COLOR_RGB | cv2.IMREAD_IGNORE_ORIENTATION
        image = cv2.imdecode(np.frombuffer(data, np.uint8), flags)
    except cv2.error:
        image = None
    if image is None:
        raise DatasetError(f"{where}: is not a readable image; copy or generate the dataset again")
    return image


def jpeg_size_wh(source: Source) -> tuple[int, int]:
    """Return width and height of a JPEG in colour without decoding it.

    Raises:
        DatasetError: It is none, or is too large to be decoded.
    """
    head = read_bytes(source, _HEAD_BYTES)
    return _size_wh(head if _frame(head) else read_bytes(source), where_of(source))


def _size_wh(data: bytes, where: str) -> tuple[int, int]:
    at = _frame(data)
    if at is None:
        raise DatasetError(f"{where}: is not a JPEG image; generate the dataset again")
    bits, channels = data[at + 4], data[at + 9]
    height, width = (int.from_bytes(data[at + i : at + i + 2], "big") for i in (5, 7))
    if (bits, channels) != (8, 3) or not 1 <= width * height <= _MOST_PIXELS:
        raise DatasetError(
            f"{where}: is an image of {width} x {height} pixels with {channels} channels of {bits} bits; "
            f"1 to {_MOST_PIXELS} pixels with 3 of 8 are read"
        )
    return width, height


def _frame(data: bytes) -> int | None:
    """Return where the segment that says how large the image is begins; None where there is none."""
    if data[:3] != _START:
        return None
    at = 2
    while at + 11 <= len(data) and data[at] == 0xFF:
        if data[at + 1] in _FRAMES:
            return at
        at += 2 + int.from_bytes(data[at + 2 : at + 4], "big")
    return None
