"""Every kind of difference between two folders is told, and a manifest may only gain keys."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from tests.same_bytes import compare, differences


@pytest.fixture
def folders(tmp_path: Path) -> tuple[Path, Path]:
    roots = tmp_path / "before", tmp_path / "after"
    for root in roots:
        (root / "smoke").mkdir(parents=True)
        cv2.imwrite(str(root / "smoke/a.png"), np.zeros((2, 5, 3), np.uint8))
        (root / "smoke/a.txt").write_text("a")
        (root / "smoke/manifest.json").write_text(json.dumps({"seed": 0, "recipe": {"scenes": 3}}))
    return roots


def test_equal_folders_do_not_differ(folders: tuple[Path, Path]) -> None:
    assert differences(*folders) == []
    assert compare(*folders) == 0


def test_files_that_came_and_went_are_named(folders: tuple[Path, Path]) -> None:
    (folders[0] / "smoke/gone").touch()
    (folders[1] / "smoke/came").touch()
    assert differences(*folders) == ["smoke/gone: missing", "smoke/came: new"]
    assert compare(*folders) == 1


def test_other_bytes_are_measured_where_they_are_pixels(folders: tuple[Path, Path]) -> None:
    image = np.zeros((2, 5, 3), np.uint8)
    image[0, 0] = 30
    cv2.imwrite(str(folders[1] / "smoke/a.png"), image)
    (folders[1] / "smoke/a.txt").write_text("b")
    pixels, text = differences(*folders)
    assert pixels == "smoke/a.png: differs by 30 at most, 3.0000 on average, in 10.00% of the values"
    assert text == "smoke/a.txt: differs"


def test_a_manifest_may_gain_keys_but_not_lose_or_change_them(folders: tuple[Path, Path]) -> None:
    manifest = folders[1] / "smoke/manifest.json"
    manifest.write_text(json.dumps({"seed": 0, "recipe": {"scenes": 3, "new": 1}, "contents": {}}))
    assert differences(*folders) == []
    manifest.write_text(json.dumps({"recipe": {"scenes": 4}}))
    assert differences(*folders) == [
        "smoke/manifest.json: manifest.seed is missing",
        "smoke/manifest.json: manifest.recipe.scenes was 3, is 4",
    ]
