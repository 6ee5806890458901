"""How varied are the images? Edges, flat blocks, brightness, hues, and how much views of one recipe look alike.

    python -m benchmarks.acceptance.image_statistics                      # prints; some 200 scenes, an image each
    python -m benchmarks.acceptance.image_statistics --write              # and stores results/image_statistics.json
    python -m benchmarks.acceptance.image_statistics --folder PHOTOS      # the same numbers of any folder of images

One image a scene, so that no two of them share a hall. Images are what the renderer gives: noise of a camera would pass
for texture. Each number is taken as follows:

- edge density: fraction of edge pixels of Canny (60, 150) in grey, scaled to 216 x 162 by areas; mean over images;
- flat blocks: fraction of 16 x 16 px blocks of the full image whose grey has a standard deviation below 3; mean;
- L* p99: 99th percentile of CIE L* of an image; mean;
- hue entropy: bits of the histogram of hues (30 bins) of all coloured pixels (S > 77, V > 38 of 255) of all images;
- correlation: mean correlation of the 32 x 24 grey thumbnails of two images of one recipe, over all pairs.
"""

import math
import sys
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from itertools import combinations
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import tyro
from jaxtyping import Float, UInt8

from benchmarks.result import RESULTS, rounded, write_result
from warehouse_sim.generation.observe import observe_scene
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.generation.scene import prepare_scene
from warehouse_sim.render import open_renderer
from warehouse_sim.resources import find_recipe, recipe_names
from warehouse_sim.yaml_file import read_yaml

NO_WAREHOUSE = ("smoke", "demo", "industrial-v1", "domain_random", "photoreal")
"""Recipes that stand for no warehouse of their own: miniatures, a frozen set, what is wild by design, mixtures."""
BLOCK_PX, THUMBNAIL, EDGE_SIZE = 16, (32, 24), (216, 162)
Image = UInt8[np.ndarray, "h w 3"]


def main(
    recipes: tuple[str, ...] = (),
    images: int = 200,
    seed: int = 4711,
    workers: int = 2,
    folder: Path | None = None,
    keep: Path | None = None,
    write: bool = False,
) -> None:
    """Measure.

    Args:
        recipes: Which; by default every recipe of a warehouse, and ``domain_random`` apart.
        images: Over all recipes together; ``domain_random`` gets as many again.
        seed: Of the scenes.
        workers: Processes.
        folder: Measure the images there instead (png, jpg), as one recipe.
        keep: Folder for the images, to look at.
        write: Store the result.
    """
    if folder is not None:
        found = [cv2.imread(str(path)) for path in sorted(folder.iterdir()) if path.suffix in (".png", ".jpg")]
        _show([_row(folder.name, [Numbers.of(cv2.cvtColor(image, cv2.COLOR_BGR2RGB)) for image in found])])
        return
    names = list(recipes) or warehouse_recipes()
    each = math.ceil(images / len(names))
    jobs = [(name, seed, index, keep) for name in names for index in range(each)]
    if not recipes:
        jobs += [("domain_random", seed, index, keep) for index in range(images)]
    measured: dict[str, list[Numbers]] = {}
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        for (name, *_), numbers in zip(jobs, pool.map(_measured, jobs), strict=True):
            measured.setdefault(name, []).append(numbers)
            print(f"{name}: {len(measured[name])}", file=sys.stderr)
    rows = [_row(name, found) for name, found in measured.items()]
    together = [item for name in names for item in measured[name]]
    overall = _row("all warehouses", together) | {"correlation": float(np.mean([row["correlation"] for row in rows]))}
    _show([overall, *rows])
    if write:
        command = "python -m benchmarks.acceptance.image_statistics --write"
        stored = [{"name": row.pop("name"), "value": row["edge_density"], **rounded(row)} for row in [overall, *rows]]
        write_result(RESULTS / "image_statistics.json", command, stored, seed=seed, images=images)


def warehouse_recipes() -> list[str]:
    """Return the shipped recipes that stand for a warehouse of their own: no training sets that extend others."""
    return [name for name in recipe_names() if name not in NO_WAREHOUSE and not _extends(name)]


class Numbers:
    """What is measured of one image; histograms and thumbnails add up over images."""

    def __init__(self, edges: float, flat: float, brightest: float, hues: Float[np.ndarray, "30"], small: Any) -> None:
        self.edges, self.flat, self.brightest, self.hues, self.small = edges, flat, brightest, hues, small

    @classmethod
    def of(cls, rgb: Image) -> "Numbers":
        """Measure one image, sRGB."""
        grey = cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY)
        edges = cv2.Canny(cv2.resize(grey, EDGE_SIZE, interpolation=cv2.INTER_AREA), 60, 150)
        hue, saturation, value = cv2.split(cv2.cvtColor(rgb, cv2.COLOR_RGB2HSV))
        colored = hue[(saturation > 77) & (value > 38)]
        lightness = cv2.cvtColor(rgb.astype(np.float32) / 255.0, cv2.COLOR_RGB2LAB)[..., 0]
        small = cv2.resize(grey, THUMBNAIL, interpolation=cv2.INTER_AREA).astype(float).ravel()
        return cls(
            edges=float((edges > 0).mean()),
            flat=float((_block_deviations(grey) < 3.0).mean()),
            brightest=float(np.percentile(lightness, 99)),
            hues=np.histogram(colored, bins=30, range=(0, 180))[0].astype(float),
            small=(small - small.mean()) / max(small.std(), 1e-9),
        )


def hue_entropy(counts: Float[np.ndarray, "30"]) -> float:
    """Return the entropy (bits) of a histogram; at most log2(30) = 4.91."""
    fraction = counts[counts > 0] / counts.sum()
    return float(-(fraction * np.log2(fraction)).sum())


def _block_deviations(grey: UInt8[np.ndarray, "h w"]) -> Float[np.ndarray, " n"]:
    rows, columns = grey.shape[0] // BLOCK_PX, grey.shape[1] // BLOCK_PX
    cut = grey[: rows * BLOCK_PX, : columns * BLOCK_PX].astype(float)
    return cut.reshape(rows, BLOCK_PX, columns, BLOCK_PX).std(axis=(1, 3)).ravel()


def _row(name: str, found: Sequence[Numbers]) -> dict[str, Any]:
    pairs = [float((a.small * b.small).mean()) for a, b in combinations(found, 2)]
    return {
        "name": name,
        "images": len(found),
        "edge_density": float(np.mean([item.edges for item in found])),
        "flat_blocks": float(np.mean([item.flat for item in found])),
        "lightness_p99": float(np.mean([item.brightest for item in found])),
        "hue_entropy": hue_entropy(np.sum([item.hues for item in found], axis=0)),
        "correlation": float(np.mean(pairs)) if pairs else 0.0,
    }


def _measured(job: tuple[str, int, int, Path | None]) -> Numbers:
    name, seed, index, keep = job
    recipe = load_recipe(name)
    scene = prepare_scene(recipe, seed, index).scene
    # The same view of each scene would be chosen for the same purpose; they take turns.
    scene = replace(scene, viewpoints=(scene.viewpoints[index % len(scene.viewpoints)],))
    rig = replace(recipe.sensors, lidar=None, lidar_mount=None, lidars={}, right=None, more={})
    with open_renderer("raster") as renderer:
        rgb = next(observe_scene(scene, rig, renderer)).buffers.rgb
    if keep is not None:
        keep.mkdir(parents=True, exist_ok=True)
        cv2.imwrite(str(keep / f"{name}_{index:03d}.png"), rgb[..., ::-1])
    return Numbers.of(rgb)


def _extends(name: str) -> bool:
    return "extends" in read_yaml(find_recipe(name))


def _show(rows: Sequence[dict[str, Any]]) -> None:
    for row in rows:
        fractions = f"edges {row['edge_density']:.3f}  flat {row['flat_blocks']:.1%}  L* p99 {row['lightness_p99']:.1f}"
        likeness = f"hues {row['hue_entropy']:.2f} bits  correlation {row['correlation']:.3f}"
        print(f"{row['name']:24} {row['images']:4d} images  {fractions}  {likeness}")


if __name__ == "__main__":
    tyro.cli(main, description=__doc__)
