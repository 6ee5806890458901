"""Photographs: what COCO's own tools read of the file, and what is said of photographs that are none."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from pycocotools.coco import COCO

from warehouse_sim.cli.main import main
from warehouse_sim.errors import InputError
from warehouse_sim.estimators.predict.photographs import find_in_photographs


@pytest.fixture(scope="module")
def photographs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder, rng = tmp_path_factory.mktemp("photographs"), np.random.default_rng(0)
    (folder / "below").mkdir()
    for name, shape in (("a.jpg", (240, 320)), ("below/b.PNG", (500, 300))):
        cv2.imwrite(str(folder / name), rng.integers(0, 255, (*shape, 3), dtype=np.uint8))
    (folder / "notes.txt").write_text("no photograph")
    return folder


def test_cocos_tools_read_every_photograph_and_what_was_found(photographs: Path, tmp_path: Path) -> None:
    out = tmp_path / "found.json"
    main(["detect", "detector-rgb", "--images", str(photographs), "--out", str(out), "--min-score", "0.0"])
    coco = COCO(str(out))
    sizes = {item["file_name"]: (item["width"], item["height"]) for item in coco.dataset["images"]}
    assert sizes == {"a.jpg": (320, 240), "below/b.PNG": (300, 500)}
    rows = coco.dataset["annotations"]
    assert rows
    assert {row["category_id"] for row in rows} <= set(coco.getCatIds())
    for row in rows:
        left, top, width, height = row["bbox"]
        image = coco.loadImgs(row["image_id"])[0]
        assert min(left, top) >= 0
        assert left + width <= image["width"] + 1e-6
        assert top + height <= image["height"] + 1e-6
        assert 0.0 <= row["score"] <= 1.0


def test_fewer_are_found_above_a_higher_score(photographs: Path) -> None:
    many, few = (find_in_photographs("detector-rgb", photographs, min_score=least) for least in (0.0, 0.01))
    assert len(few["annotations"]) < len(many["annotations"])
    assert all(row["score"] >= 0.0099 for row in few["annotations"])
    assert [item["file_name"] for item in few["images"]] == [item["file_name"] for item in many["images"]]


def test_what_is_no_photograph_is_named(photographs: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="detector-depth reads depth, which photographs lack"):
        find_in_photographs("detector-depth", photographs)
    with pytest.raises(InputError, match="holds no photograph"):
        find_in_photographs("detector-rgb", tmp_path)
    (tmp_path / "cut.jpg").write_bytes((photographs / "a.jpg").read_bytes()[:200])
    with pytest.raises(InputError, match=r"cut.jpg: is no image that can be read"):
        find_in_photographs("detector-rgb", tmp_path)
    assert json.dumps(find_in_photographs("detector-rgb", photographs))
