"""JPEG files: RGB in memory, one quality; hostile files are rejected."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from warehouse_sim.dataset.files.jpeg import QUALITY, decode_jpeg, encode_jpeg, jpeg_size_wh
from warehouse_sim.errors import DatasetError


@pytest.fixture
def file(tmp_path: Path) -> Path:
    rgb = np.zeros((48, 80, 3), np.uint8)
    rgb[:, :40], rgb[:, 40:] = (220, 40, 10), (20, 60, 200)
    path = tmp_path / "rgb.jpg"
    path.write_bytes(encode_jpeg(rgb))
    return path


def test_colours_come_back_in_their_order(file: Path) -> None:
    rgb = decode_jpeg(file)
    assert jpeg_size_wh(file) == (80, 48)
    assert rgb.shape == (48, 80, 3)
    assert np.abs(rgb[24, 10].astype(int) - (220, 40, 10)).max() < 4
    assert np.abs(rgb[24, 70].astype(int) - (20, 60, 200)).max() < 4
    assert np.array_equal(rgb, cv2.imread(str(file))[..., ::-1])


def test_what_a_camera_compressed_is_kept_to_few_codes() -> None:
    rng = np.random.default_rng(0)
    image = cv2.GaussianBlur(rng.integers(0, 256, (120, 160, 3), dtype=np.uint8), (0, 0), 2)
    read = cv2.imdecode(cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])[1], cv2.IMREAD_COLOR_RGB)
    kept = cv2.imdecode(np.frombuffer(encode_jpeg(read), np.uint8), cv2.IMREAD_COLOR_RGB)
    assert cv2.PSNR(read, kept) > 45


def huge(data: bytes) -> bytes:
    at = data.index(b"\xff\xc0")
    return data[: at + 5] + b"\xff\xff\xff\xff" + data[at + 9 :]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda data: data[:-40], "its end is missing"),
        (lambda data: b"\x89PNG" + data, "is not a JPEG image"),
        (lambda data: b"", "is not a JPEG image"),
        (huge, "is an image of 65535 x 65535 pixels"),
        (lambda data: data[: data.index(b"\xff\xc0")], "is not a JPEG image"),
    ],
)
def test_damaged_files_are_rejected(file: Path, change, message: str) -> None:
    file.write_bytes(change(file.read_bytes()))
    with pytest.raises(DatasetError, match=message):
        decode_jpeg(file)


def test_grey_files_are_rejected(file: Path) -> None:
    file.write_bytes(cv2.imencode(".jpg", np.zeros((8, 8), np.uint8))[1].tobytes())
    with pytest.raises(DatasetError, match="with 1 channels of 8 bits"):
        jpeg_size_wh(file)
