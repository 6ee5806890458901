"""Every value of every file of a small dataset, replaced by others: the checks speak or pass, they never break."""

import json
import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import cycle, product
from pathlib import Path
from typing import Any

import pytest

from tests.dataset.faults.folder import linked_copy
from tests.dataset.toy import make_dataset, make_manifest, make_scene
from warehouse_sim.dataset.validate import validate

FILES = (
    "manifest.json",
    "objects.json",
    "scenes/000000.json",
    "bop/camera.json",
    "bop/models/models_info.json",
    "bop/models_eval/models_info.json",
    "bop/test_targets_bop19.json",
    "bop/train/000000/scene_camera.json",
    "bop/train/000000/scene_gt.json",
    "bop/train/000000/scene_gt_info.json",
    "bop/train/000000/scene_gt_coco.json",
)
HOSTILE: tuple[Any, ...] = ("x", None, -1, 0, 10**18, -1e300, 10**400, math.nan, True, [], {}, [[[]]], {"a": {}})
FREE_TEXT = {"name", "description", "renderer", "lighting", "variant", "kind", "model", "supercategory"}
NOT_USED = (
    "settle",
    "lights",
    "packages",
    "attempt",
    "ambient",
    "exposure",
    "occlusion",
    "paired_variants",
    "licenses",
    "info",
    "bins",
)
"""Told for people, or how the scene came about; no label or score reads them."""


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One scene of one observation, as of values of one kind the first is replaced."""
    scene = make_scene(0)
    scene, manifest = replace(scene, viewpoints=scene.viewpoints[:1]), make_manifest(1)
    root = tmp_path_factory.mktemp("small") / "data"
    return make_dataset(root, replace(manifest, observations_per_scene=1), scene_of=lambda _: scene)


def places(data: Any, path: tuple = ()) -> Iterator[tuple]:
    """Yield the path of each value; of those of one kind, a list or a table by number, of the first."""
    if path:
        yield path
    if isinstance(data, dict):
        numbered = [key for key in data if key.isdecimal()]
        for key, value in data.items():
            if key in numbered[1:]:
                continue
            yield from places(value, (*path, key))
    elif isinstance(data, list) and data:
        yield from places(data[0], (*path, 0))


def replaced(data: Any, path: tuple, value: Any) -> Any:
    copy = json.loads(json.dumps(data))
    inner = copy
    for key in path[:-1]:
        inner = inner[key]
    inner[path[-1]] = value
    return copy


def scored(file: str, path: tuple) -> bool:
    """Whether a label or a score is made of the value, whatever replaces it."""
    if file.startswith("bop/train") and "gt_coco" not in file:
        return True
    return file == "bop/camera.json" or (file == "objects.json" and path[-1] not in FREE_TEXT)


def verdict(root: Path) -> list:
    """Validate; what is rejected is told in one line."""
    problems = [check for check in validate(root) if not check.ok]
    assert all(check.detail and "\n" not in check.detail and len(check.detail) < 1000 for check in problems)
    return problems


@pytest.mark.parametrize("file", FILES)
def test_every_value_is_read_or_rejected(small: Path, tmp_path: Path, file: str) -> None:
    """Each value meets one of the others, each of the others meets some value."""
    walk(small, tmp_path, file, lambda number: (HOSTILE[3 * number % len(HOSTILE)],))


@pytest.mark.slow
@pytest.mark.parametrize("file", FILES)
def test_every_value_meets_all_others(small: Path, tmp_path: Path, file: str) -> None:
    walk(small, tmp_path, file, lambda number: HOSTILE)


def walk(small: Path, folder: Path, file: str, values: Callable[[int], tuple[Any, ...]]) -> None:
    root = linked_copy(small, folder / "copy")
    original = (root / file).read_text()
    data, missed = json.loads(original), []
    (root / file).unlink()  # of a linked copy, whose other files stay as they are
    for number, path in enumerate(places(data)):
        if any(key in NOT_USED for key in path):
            continue
        for value in values(number):
            (root / file).write_text(json.dumps(replaced(data, path, value)))
            if not verdict(root) and scored(file, path) and not same(data, path, value):
                missed.append((path, value))
    (root / file).write_text(original)
    assert missed == []
    assert verdict(root) == []


def same(data: Any, path: tuple, value: Any) -> bool:
    """Whether a value is what was there, as numbers or as nothing: a missing list is an empty one."""
    for key in path:
        data = data[key]
    if {type(data), type(value)} <= {int, float}:
        return abs(data - value) < 1e-9
    return data == value or (not data and not value)


OF_ANOTHER_KIND = (b"[]", b"{}", b"null")
UNREADABLE = (b"", b"{", b"[" * 100_000, b"\xff\xfe", b"9" * 5001, b'{"a":1,"a":2}')
PAIRS = [
    *((file, content) for file in FILES for content in OF_ANOTHER_KIND),
    *zip(FILES, cycle(UNREADABLE), strict=False),  # one function reads them all: each file meets one
]


@pytest.mark.parametrize(
    ("file", "content"),
    [
        pytest.param(*pair, marks=() if pair in PAIRS else pytest.mark.slow)
        for pair in product(FILES, OF_ANOTHER_KIND + UNREADABLE)
    ],
)
def test_no_content_breaks_the_checks(small: Path, tmp_path: Path, file: str, content: bytes) -> None:
    root = linked_copy(small, tmp_path / "copy")
    (root / file).unlink()
    (root / file).write_bytes(content)
    rejected = verdict(root)
    assert rejected or (file == "bop/test_targets_bop19.json" and content == b"[]")


@pytest.mark.parametrize("file", FILES)
def test_a_folder_in_place_of_a_file_is_rejected(small: Path, tmp_path: Path, file: str) -> None:
    root = linked_copy(small, tmp_path / "copy")
    (root / file).unlink()
    (root / file).mkdir()
    assert verdict(root)


@pytest.mark.parametrize("pattern", ["bop/models*/*.ply", "bop/train/000000/*/*.png", "kitti/training/*/*.png"])
def test_no_flipped_bit_passes(small: Path, tmp_path: Path, pattern: str) -> None:
    root = linked_copy(small, tmp_path / "copy")
    for path in sorted(root.glob(pattern))[::3]:
        content = path.read_bytes()
        for place in {0, 20, len(content) // 3, len(content) // 2, len(content) - 20, len(content) - 1}:
            changed = bytearray(content)
            changed[place] ^= 1 << (place % 8)
            path.unlink()
            path.write_bytes(changed)
            assert verdict(root), (path, place)
        path.unlink()
        path.write_bytes(content)
