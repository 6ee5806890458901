"""Every annotation of scene_gt_coco.json decodes, by COCO's own tools, to the PNG of its visible mask."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from pycocotools import mask as coco_mask

from warehouse_sim.generation.generate import generate
from warehouse_sim.generation.plan import GenerateConfig
from warehouse_sim.generation.recipe import load_recipe

pytestmark = pytest.mark.gl


def masks_that_decode(root: Path) -> int:
    """Compare all annotations of a dataset with their masks; return how many there are."""
    count = 0
    for table in sorted(root.glob("bop/*/*/scene_gt_coco.json")):
        masks = sorted((table.parent / "mask_visib").iterdir())
        for annotation, path in zip(json.loads(table.read_text())["annotations"], masks, strict=True):
            runs = annotation["segmentation"]
            decoded = coco_mask.decode(coco_mask.frPyObjects(runs, *runs["size"]))
            assert np.array_equal(decoded * 255, cv2.imread(str(path), cv2.IMREAD_UNCHANGED)), path
            assert annotation["area"] == decoded.sum(), path
            count += 1
    return count


def test_masks_of_the_smallest_recipe(shared) -> None:
    assert masks_that_decode(shared.dataset(scenes=3)) >= 4


@pytest.mark.slow
@pytest.mark.parametrize(("recipe", "at_least"), [("demo", 100), ("industrial", 300), ("block_storage", 300)])
def test_masks_of_three_recipes(tmp_path: Path, recipe: str, at_least: int) -> None:
    generate(load_recipe(recipe), tmp_path / "data", GenerateConfig(scenes=3, formats=("bop",), workers=2))
    assert masks_that_decode(tmp_path / "data") >= at_least
