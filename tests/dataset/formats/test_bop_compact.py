"""Compact shards: what the exact ones hold, colours to few codes; read and validated alone; hostile files."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.dataset.formats.test_bop_shards import members, named, rewrite
from tests.dataset.toy import make_dataset, make_manifest
from warehouse_sim.dataset.files.jpeg import encode_jpeg
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.validate import validate
from warehouse_sim.errors import DatasetError


@pytest.fixture(scope="module")
def exact(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_dataset(tmp_path_factory.mktemp("exact") / "data", make_manifest(formats=("bop_webdataset",)))


@pytest.fixture
def compact(tmp_path: Path) -> Path:
    return make_dataset(tmp_path / "data", make_manifest(formats=("bop_compact",)))


def test_members_are_those_of_bop(compact: Path) -> None:
    found = members(compact / "bop_compact" / "test" / "shard-000000.tar")
    kinds = ["camera.json", "depth.png", "gt.json", "gt_info.json", "mask.json", "mask_visib.json", "rgb.jpg"]
    assert list(found) == [f"000002_00000{image}.{kind}" for image in (0, 1) for kind in kinds]
    assert "JPEG of quality 90" in (compact / "bop_compact" / "dataset_info.md").read_text()
    assert all(check.ok for check in validate(compact)), [check for check in validate(compact) if not check.ok]


def test_all_but_colour_is_the_same_to_the_bit(exact: Path, compact: Path) -> None:
    a, b = DatasetReader(exact), DatasetReader(compact)
    for split in a.splits:
        for one, other in zip(a.images(split), b.images(split), strict=True):
            assert one.camera == other.camera
            assert np.array_equal(one.T_world_camera, other.T_world_camera)
            assert np.array_equal(a.depth(one), b.depth(other))
            assert a.rgb(one).shape == b.rgb(other).shape
            assert np.abs(a.rgb(one).astype(float) - b.rgb(other)).mean() < 3.0
            for target, theirs in zip(one.targets, other.targets, strict=True):
                assert np.array_equal(target.T_camera_object, theirs.T_camera_object)
                empty = {"T_camera_object": np.eye(4)}
                assert str(replace(target, **empty)) == str(replace(theirs, **empty))
                assert np.array_equal(a.mask(one, target.gt_index), b.mask(other, target.gt_index))
                assert np.array_equal(a.mask_visible(one, target.gt_index), b.mask_visible(other, target.gt_index))


def test_the_folder_alone_is_read_as_bop(compact: Path) -> None:
    alone = DatasetReader((compact / "bop_compact").rename(compact.parent / "apart"))
    other = alone.images("train")[0]
    assert alone.rgb(other).shape == (other.camera.height, other.camera.width, 3)
    assert alone.mask_visible(other, 0).any()


def another(kind: str, data: bytes):
    """Return a change of the first member of a kind."""

    def change(items):
        index = next(i for i, (item, _) in enumerate(items) if item.name.endswith(kind))
        return [*items[:index], named(items[index][0].name, data), *items[index + 1 :]]

    return change


def read_all(reader: DatasetReader) -> None:
    for image in reader.images("test"):
        reader.rgb(image)
        reader.depth(image)
        for target in image.targets:
            reader.mask_visible(image, target.gt_index)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (another("rgb.jpg", b"\xff\xd8\xff\xe0"), r"rgb\.jpg: is not a JPEG image"),
        (another("rgb.jpg", encode_jpeg(np.zeros((8, 8, 3), np.uint8))), "the camera|is .8, 8."),
        (lambda items: [pair for pair in items if not pair[0].name.endswith("rgb.jpg")], r"rgb\.jpg is missing"),
        (another("mask_visib.json", json.dumps({"0": {"size": [96, 160], "counts": "o"}}).encode()), "within a number"),
        (another("depth.png", b"\x89PNG\r\n\x1a\n"), "is not a PNG image"),
    ],
)
def test_hostile_shards_are_rejected(compact: Path, change, message: str) -> None:
    rewrite(compact / "bop_compact" / "test" / "shard-000000.tar", change)
    with pytest.raises(DatasetError, match=message):
        read_all(DatasetReader(compact))
    assert not all(check.ok for check in validate(compact))
