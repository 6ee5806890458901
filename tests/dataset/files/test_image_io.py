from pathlib import Path

import cv2
import numpy as np
import pytest

from warehouse_sim.dataset.files.image_io import (
    decode_depth,
    decode_mask,
    decode_rgb,
    encode_depth,
    encode_instance_mask,
    encode_mask,
    encode_rgb,
    image_size_wh,
)
from warehouse_sim.errors import DatasetError


def test_rgb_round_trip_and_channel_order_in_the_file(tmp_path: Path) -> None:
    rgb = np.random.default_rng(0).integers(0, 256, (17, 23, 3), dtype=np.uint8)
    path = tmp_path / "a.png"
    path.write_bytes(encode_rgb(rgb))
    assert np.array_equal(decode_rgb(path), rgb)
    # OpenCV reads files as BGR: the file itself must hold red first.
    assert np.array_equal(cv2.imread(str(path))[..., ::-1], rgb)
    assert image_size_wh(path) == (23, 17)


@pytest.mark.parametrize("steps_per_metre", [1000.0, 256.0])
def test_depth_round_trip_within_half_a_step(tmp_path: Path, steps_per_metre: float) -> None:
    depth = np.random.default_rng(1).uniform(0.3, 60.0, (31, 41)).astype(np.float32)
    depth[3, 4] = 0.0
    (tmp_path / "a.png").write_bytes(encode_depth(depth, steps_per_metre, "here"))
    steps = decode_depth(tmp_path / "a.png")
    assert steps[3, 4] == 0
    assert np.abs(steps / steps_per_metre - depth).max() <= 0.5 / steps_per_metre + 1e-5


@pytest.mark.parametrize(
    ("value", "steps_per_metre"),
    [(65.5356, 1000.0), (300.0, 256.0), (256.0, 256.0), (-0.001, 1000.0), (np.nan, 1000.0), (np.inf, 256.0)],
)
def test_depth_out_of_range_is_rejected_not_wrapped(value: float, steps_per_metre: float) -> None:
    depth = np.full((3, 3), 2.0, dtype=np.float32)
    depth[1, 1] = value
    with pytest.raises(DatasetError, match=r"BOP, scene 4: depth .* does not fit into 16 bits"):
        encode_depth(depth, steps_per_metre, "BOP, scene 4")


def test_the_largest_depth_is_kept(tmp_path: Path) -> None:
    (tmp_path / "a.png").write_bytes(encode_depth(np.full((2, 2), 65.535, dtype=np.float32), 1000.0, "here"))
    assert (decode_depth(tmp_path / "a.png") == 65535).all()


def test_mask_is_0_and_255(tmp_path: Path) -> None:
    mask = np.random.default_rng(2).random((9, 14)) > 0.5
    (tmp_path / "a.png").write_bytes(encode_mask(mask))
    assert np.array_equal(cv2.imread(str(tmp_path / "a.png"), cv2.IMREAD_UNCHANGED), mask * np.uint8(255))
    assert np.array_equal(decode_mask(tmp_path / "a.png"), mask)


@pytest.mark.parametrize("shape", [(1, 1), (1, 5), (5, 1), (370, 1224)])
@pytest.mark.parametrize("value", [False, True])
def test_even_masks_of_any_size_come_back(tmp_path: Path, shape: tuple[int, int], value: bool) -> None:
    mask = np.full(shape, value)
    (tmp_path / "a.png").write_bytes(encode_mask(mask))
    assert np.array_equal(decode_mask(tmp_path / "a.png"), mask)


def test_ids_are_kept_up_to_16_bits_and_rejected_beyond(tmp_path: Path) -> None:
    ids = np.random.default_rng(3).integers(0, 65536, (13, 7)).astype(np.int32)
    ids[0, :2] = 0, 65535
    (tmp_path / "a.png").write_bytes(encode_instance_mask(ids, "here"))
    assert np.array_equal(decode_depth(tmp_path / "a.png"), ids)
    for wrong in (65536, -1):
        ids[4, 4] = wrong
        with pytest.raises(DatasetError, match=f"scene 4: instance id {wrong} does not fit into 16 bits"):
            encode_instance_mask(ids, "scene 4")


def test_files_are_hardly_larger_than_those_of_opencv() -> None:
    """On an image with edges, shading and sensor noise; the table in ``png`` is that of real observations."""
    rng = np.random.default_rng(4)
    height, width = 185, 612
    columns, rows = np.meshgrid(np.arange(width), np.arange(height))
    patches = (rows // 37 + columns // 51) % 5 * 30 + columns * 0.1
    rgb = np.clip(patches[..., None] + rng.normal(0, 2, (height, width, 3)), 0, 255).astype(np.uint8)
    depth = (3.0 + (columns // 51) * 0.4 + rows * 0.01 + rng.normal(0, 0.003, rows.shape)).astype(np.float32)
    ids = ((rows // 37) * 12 + columns // 51).astype(np.int32)
    millimetres = np.rint(depth * 1000).astype(np.uint16)
    for data, image in [
        (encode_rgb(rgb), rgb),
        (encode_depth(depth, 1000.0, "here"), millimetres),
        (encode_instance_mask(ids, "here"), ids.astype(np.uint16)),
    ]:
        assert len(data) <= 1.3 * len(cv2.imencode(".png", image)[1])


GREY = np.full((4, 5), 7, dtype=np.uint8)
COLOUR = np.full((4, 5, 3), 7, dtype=np.uint8)
DEEP = np.full((4, 5), 7, dtype=np.uint16)


@pytest.mark.parametrize(
    ("decode", "image", "message"),
    [
        (decode_rgb, GREY, "expected an 8-bit colour image"),
        (decode_rgb, DEEP, "expected an 8-bit colour image"),
        (decode_depth, GREY, "expected 16-bit depth"),
        (decode_depth, COLOUR, "expected 16-bit depth"),
        (decode_mask, DEEP, "expected an 8-bit mask"),
        (decode_mask, GREY, "0 and 255 only"),
    ],
)
def test_images_of_the_wrong_kind_are_rejected(tmp_path: Path, decode, image: np.ndarray, message: str) -> None:
    cv2.imwrite(str(tmp_path / "a.png"), image)
    with pytest.raises(DatasetError, match=message):
        decode(tmp_path / "a.png")


@pytest.mark.parametrize("content", [b"", b"no image", None])
@pytest.mark.parametrize("decode", [decode_rgb, decode_depth, decode_mask, image_size_wh])
def test_unreadable_files_are_named(tmp_path: Path, decode, content: bytes | None) -> None:
    if content is not None:
        (tmp_path / "a.png").write_bytes(content)
    with pytest.raises(DatasetError, match=r"a\.png: (is not|cannot be read)"):
        decode(tmp_path / "a.png")
