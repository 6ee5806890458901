"""What few denoised paths cost and how near they come to many: time, noise and sharpness of parts of real views.

    python -m benchmarks.acceptance.photoreal            # prints the table
    python -m benchmarks.acceptance.photoreal --write    # and stores the result

A whole frame is traced by few paths and denoised; parts of it are traced by many, with another seed, and denoised from
there as well, which leaves them without grain. Shade is what the reference shows darker than a quarter of its white.
"""

import time
from dataclasses import dataclass, replace

import cv2
import numpy as np
import tyro
from jaxtyping import Float

from benchmarks.result import RESULTS, rounded, write_result
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.generation.scene import prepare_scene
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.render import open_renderer
from warehouse_sim.schema import SceneSpec, Viewpoint

CAMERA = PinholeCamera.from_focal(640, 480, 460.0)
SHADE = 64
"""Code below which the reference is in shade."""


@dataclass(frozen=True)
class Part:
    """A part of a view that shows one thing above all."""

    name: str
    recipe: str
    seed: int
    scene: int
    view: int
    window: tuple[int, int, int, int]
    """Left, top, width and height (px)."""


PARTS = (
    Part("print", "selective_rack", 4711, 5, 0, (100, 115, 170, 90)),
    Part("film", "selective_rack", 4711, 5, 0, (295, 10, 140, 160)),
    Part("shadowed wall", "selective_rack", 4711, 5, 0, (360, 225, 110, 120)),
    Part("dock", "dock_staging", 0, 0, 0, (240, 180, 160, 120)),
    Part("pallets", "mixed_pallets", 0, 1, 0, (240, 180, 160, 120)),
)


def measure(part: Part, samples: int, many: int) -> dict[str, float | str]:
    """Return what is measured of one part.

    Args:
        part: Of which view.
        samples: Paths a pixel of the image.
        many: Paths a pixel of the reference.
    """
    prepared = prepare_scene(load_recipe(part.recipe), part.seed, part.scene).scene
    view = prepared.viewpoints[part.view]
    scene = prepared.seen_from(view)
    left, top, width, height = part.window
    frame, seconds = _frame(scene, view, samples)
    image = frame[top : top + height, left : left + width]
    camera = CAMERA.crop(left, top, width, height)
    reference = {}
    for clean in (False, True):
        with open_renderer("pathtrace", samples=many, seed=1, denoise=clean) as renderer:
            renderer.load(scene)
            reference[clean] = renderer.render(camera, view.T_world_camera).rgb.astype(float)
    difference, shade = np.abs(image - reference[True]), reference[True].max(axis=-1) < SHADE
    return {
        "name": part.name,
        "view": f"{part.recipe}, seed {part.seed}, scene {part.scene}, view {part.view}",
        "CPU-s a frame": seconds,
        "mean difference (codes)": float(difference.mean()),
        "mean difference in shade (codes)": float(difference[shade].mean()) if shade.any() else 0.0,
        "share in shade": float(shade.mean()),
        "mean difference of 8 x 8 means to noisy paths (codes)": _block_difference(image, reference[False]),
        "sharpness over the reference's": _sharpness(image) / _sharpness(reference[True]),
        "bright dots": _dots(image),
    }


def _frame(scene: SceneSpec, view: Viewpoint, samples: int) -> tuple[Float[np.ndarray, "h w 3"], float]:
    """Return a denoised frame and its CPU time (s), with the scene there and the kernels compiled."""
    with open_renderer("pathtrace", samples=samples, denoise=True) as renderer:
        renderer.load(scene)
        renderer.render(replace(CAMERA, width=64, height=48, cx=31.5, cy=23.5), view.T_world_camera)
        start = time.process_time()
        image = renderer.render(CAMERA, view.T_world_camera).rgb.astype(float)
        return image, time.process_time() - start


def _sharpness(image: Float[np.ndarray, "h w 3"]) -> float:
    """Return the mean size of the gradient (codes a pixel)."""
    return float(np.abs(np.diff(image, axis=0)).mean() + np.abs(np.diff(image, axis=1)).mean())


def _block_difference(image: Float[np.ndarray, "h w 3"], noisy: Float[np.ndarray, "h w 3"]) -> float:
    size = (image.shape[1] // 8, image.shape[0] // 8)
    means = [cv2.resize(item, size, interpolation=cv2.INTER_AREA) for item in (image, noisy)]
    return float(np.abs(means[0] - means[1]).mean())


def _dots(image: Float[np.ndarray, "h w 3"]) -> int:
    """Return the number of pixels 60 codes brighter than all eight around them: fireflies."""
    grey = image.mean(axis=-1)
    ring = np.array([[1, 1, 1], [1, 0, 1], [1, 1, 1]], np.uint8)
    return int((grey > cv2.dilate(grey, ring) + 60.0).sum())


def main(samples: int = 16, many: int = 256, parts: int = len(PARTS), write: bool = False) -> None:
    """Measure parts of views.

    Args:
        samples: Paths a pixel of the image.
        many: Paths a pixel of the reference.
        parts: How many parts.
        write: Store the result.
    """
    rows: list[dict[str, float | str]] = []
    for part in PARTS[:parts]:
        measured = rounded(measure(part, samples, many))
        of = {key: measured.pop(key) for key in ("name", "view")}
        rows += [
            {"name": f"{of['name']}: {what}", "view": of["view"], "value": value} for what, value in measured.items()
        ]
        print(of, measured, flush=True)
    if write:
        command = f"python -m benchmarks.acceptance.photoreal --samples {samples} --many {many} --parts {parts} --write"
        write_result(RESULTS / "photoreal.json", command, rows)


if __name__ == "__main__":
    tyro.cli(main)
