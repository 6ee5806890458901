import io
import zlib
from itertools import product

import cv2
import numpy as np
import pytest

from warehouse_sim.dataset.files.png import Filter, decode_plain_png, encode_png, smaller_png
from warehouse_sim.errors import DatasetError

FILTERS: tuple[Filter, ...] = ("none", "sub", "up")
SHAPES = [(1, 1), (1, 9), (9, 1), (2, 2), (3, 257), (61, 40)]


def random_image(seed: int, shape: tuple[int, int], kind: str) -> np.ndarray:
    """An image of one kind: noise, smooth with noise, or flat with specks, which require different codes."""
    rng = np.random.default_rng(seed)
    dtype, channels = {"grey8": (np.uint8, 1), "grey16": (np.uint16, 1), "rgb": (np.uint8, 3), "rgb16": (np.uint16, 3)}[
        kind
    ]
    size = (*shape, 3) if channels == 3 else shape
    largest = np.iinfo(dtype).max
    style = seed % 3
    if style == 0:
        return rng.integers(0, largest + 1, size, dtype=dtype)
    if style == 1:
        smooth = np.cumsum(np.ones(size), axis=1) * largest / 300 + rng.normal(0, 3, size)
        return np.mod(smooth, largest + 1).astype(dtype)
    return np.where(rng.random(size) < 0.02, largest, 0).astype(dtype)


@pytest.mark.parametrize("kind", ["grey8", "grey16", "rgb", "rgb16"])
@pytest.mark.parametrize("row_filter", FILTERS)
def test_opencv_reads_back_every_kind_of_image(kind: str, row_filter: Filter) -> None:
    for shape, seed in product(SHAPES, range(6)):
        image = random_image(seed, shape, kind)
        decoded = cv2.imdecode(np.frombuffer(encode_png(image, row_filter), np.uint8), cv2.IMREAD_UNCHANGED)
        assert decoded.dtype == image.dtype
        assert np.array_equal(decoded[..., ::-1] if image.ndim == 3 else decoded, image)


@pytest.mark.parametrize("kind", ["grey8", "grey16", "rgb"])
@pytest.mark.parametrize("row_filter", FILTERS)
def test_pillow_reads_back_every_kind_of_image(kind: str, row_filter: Filter) -> None:
    pillow = pytest.importorskip("PIL.Image")
    for seed, shape in enumerate(SHAPES):
        image = random_image(seed, shape, kind)
        with pillow.open(io.BytesIO(encode_png(image, row_filter))) as opened:
            opened.load()
            assert opened.size == shape[::-1]
            assert opened.mode in {"grey8": ("L",), "grey16": ("I;16", "I"), "rgb": ("RGB",)}[kind]
            assert np.array_equal(np.asarray(opened).astype(image.dtype), image)


@pytest.mark.parametrize("row_filter", FILTERS)
def test_the_file_is_as_the_standard_says(row_filter: Filter) -> None:
    image = random_image(1, (7, 11), "grey16")
    data = encode_png(image, row_filter)
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    chunks, at = {}, 8
    while at < len(data):
        length, kind = int.from_bytes(data[at : at + 4], "big"), data[at + 4 : at + 8]
        chunks[kind] = data[at + 8 : at + 8 + length]
        assert int.from_bytes(data[at + 8 + length : at + 12 + length], "big") == zlib.crc32(kind + chunks[kind])
        at += 12 + length
    assert list(chunks) == [b"IHDR", b"IDAT", b"IEND"]
    assert chunks[b"IHDR"] == bytes([0, 0, 0, 11, 0, 0, 0, 7, 16, 0, 0, 0, 0])
    # The standard library checks the stream's own checksum too.
    rows = np.frombuffer(zlib.decompress(chunks[b"IDAT"]), np.uint8).reshape(7, 1 + 2 * 11)
    assert (rows[:, 0] == {"none": 0, "sub": 1, "up": 2}[row_filter]).all()


def test_the_same_image_gives_the_same_bytes_whatever_its_layout() -> None:
    image = random_image(0, (61, 40), "rgb")
    wanted = encode_png(image, "sub")
    assert encode_png(image.copy(), "sub") == wanted
    assert encode_png(np.asfortranarray(image), "sub") == wanted
    assert encode_png(image[:, ::-1][:, ::-1], "sub") == wanted
    deep = random_image(0, (61, 40), "grey16")
    assert encode_png(deep.astype(">u2"), "up") == encode_png(deep.astype("<u2"), "up")


@pytest.mark.parametrize(
    "image",
    [
        np.zeros((3, 3), np.int32),
        np.zeros((3, 3), bool),
        np.zeros((3, 3, 4), np.uint8),
        np.zeros((3, 3, 2), np.uint16),
        np.zeros((0, 3), np.uint8),
        np.zeros((3, 0, 3), np.uint8),
        np.zeros(3, np.uint8),
    ],
    ids=lambda image: f"{image.dtype}{image.shape}",
)
def test_what_png_cannot_hold_is_rejected(image: np.ndarray) -> None:
    with pytest.raises(DatasetError, match="cannot be encoded as PNG"):
        encode_png(image, "sub")


@pytest.mark.parametrize("small", [False, True])
@pytest.mark.parametrize("row_filter", FILTERS)
def test_plain_files_are_decoded_as_opencv_does(row_filter: Filter, small: bool) -> None:
    for shape, seed in product(SHAPES, range(3)):
        image = random_image(seed, shape, "grey16")
        found = decode_plain_png(encode_png(image, row_filter, small), "here")
        assert (found is None) == (row_filter == "sub")
        assert found is None or np.array_equal(found, image)
        assert decode_plain_png(encode_png(random_image(0, shape, "grey8"), row_filter), "here") is None


def test_smaller_files_hold_the_same() -> None:
    ramp = np.repeat(np.arange(400, dtype=np.uint16)[:, None], 300, axis=1) // 7 * 37
    for image in (ramp, random_image(1, (61, 40), "grey16"), random_image(2, (61, 40), "grey16")):
        data = smaller_png(image)
        assert np.array_equal(cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED), image)
        assert len(data) <= min(len(encode_png(image, name)) for name in ("up", "none"))


@pytest.mark.parametrize(("rows", "message"), [(5, "holds"), (80, "holds")])
def test_plain_files_with_other_pixels_than_they_say_are_rejected(rows: int, message: str) -> None:
    data = encode_png(random_image(0, (rows, 11), "grey16"), "up")
    with pytest.raises(DatasetError, match=message):
        decode_plain_png(data[:20] + (7).to_bytes(4, "big") + data[24:], "here")
