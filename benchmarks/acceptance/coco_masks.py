"""Whether every mask of COCO, decoded by pycocotools, is BOP's PNG, and how far YOLO's polygons are from it.

python -m benchmarks.acceptance.coco_masks --write
"""

import contextlib
import io
import tempfile
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import tyro
from pycocotools.coco import COCO

from benchmarks.result import RESULTS, rounded, write_result
from warehouse_sim.generation.generate import generate
from warehouse_sim.generation.plan import GenerateConfig
from warehouse_sim.generation.recipe import load_recipe

RECIPES = ("smoke", "industrial", "selective_rack")
_FORMATS = ("bop", "coco", "yolo")


def main(write: bool = False) -> None:
    """Compare all masks of one scene of each recipe.

    Args:
        write: Store the result.
    """
    rows = []
    for recipe in RECIPES:
        with tempfile.TemporaryDirectory() as folder:
            root = Path(folder) / "data"
            generate(load_recipe(recipe), root, GenerateConfig(scenes=1, formats=_FORMATS))
            row = {"name": recipe, **compare(root)}
        rows.append(row)
        print(row)
    if write:
        write_result(RESULTS / "coco_masks.json", "python -m benchmarks.acceptance.coco_masks --write", rounded(rows))


def compare(root: Path) -> dict[str, float | int | str]:
    """Return the fraction of equal masks of a dataset in all three formats, and the overlap (IoU) of its polygons."""
    equal, overlaps = [], []
    for visible, whole, visible_png, whole_png, polygon in _masks(root):
        equal += [np.array_equal(visible, visible_png), np.array_equal(whole, whole_png)]
        overlaps.append((polygon & visible_png).sum() / (polygon | visible_png).sum())
    return {
        "value": float(np.mean(equal)),
        "unit": "fraction of COCO's masks that equal BOP's PNG",
        "masks": len(equal),
        "polygon_iou_mean": float(np.mean(overlaps)),
        "polygon_iou_least": float(np.min(overlaps)),
        "polygons_equal": float(np.mean(np.array(overlaps) == 1.0)),
    }


def _masks(root: Path) -> Iterator[tuple[np.ndarray, ...]]:
    """Yield of each target COCO's visible and whole mask, those of BOP, and YOLO's polygon filled."""
    for path in sorted((root / "coco/annotations").glob("instances_amodal_*.json")):
        split = path.stem.removeprefix("instances_amodal_")
        with contextlib.redirect_stdout(io.StringIO()):
            whole, coco = COCO(str(path)), COCO(str(path.with_name(f"instances_{split}.json")))
        for image in coco.imgs.values():
            name, scene = Path(image["file_name"]).stem, root / "bop" / split / f"{image['scene_id']:06d}"
            lines = (root / f"yolo/segment/labels/{split}/{name}.txt").read_text().splitlines()
            for index, (row, line) in enumerate(zip(coco.imgToAnns[image["id"]], lines, strict=True)):
                masks = [coco.annToMask(row), whole.annToMask(whole.anns[row["id"]])]
                for kind in ("mask_visib", "mask"):
                    png = scene / kind / f"{image['observation']:06d}_{index:06d}.png"
                    masks.append(cv2.imread(str(png), cv2.IMREAD_UNCHANGED) // 255)
                corners = np.array(line.split()[1:], dtype=np.float32).reshape(-1, 2)
                filled = np.zeros(masks[0].shape, dtype=np.uint8)
                cv2.fillPoly(filled, [(corners * [image["width"], image["height"]]).astype(np.int32)], 1)
                yield tuple(mask.astype(bool) for mask in (*masks, filled))


if __name__ == "__main__":
    tyro.cli(main)
