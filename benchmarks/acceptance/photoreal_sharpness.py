"""Whether few denoised paths keep what many paths without a denoiser show, and what noise they leave.

    python -m benchmarks.acceptance.photoreal_sharpness            # prints the table
    python -m benchmarks.acceptance.photoreal_sharpness --write    # and stores the result

Windows of one view of ``industrial-v1`` (print, film, a shadowed wall), which is frozen, are traced alone. Paths
without a denoiser leave noise, whose gradients would count as sharpness; of two images with other seeds only what they
share is the scene's. So the gradient energy of the scene is the mean product of the gradients of two halves of the
reference, and what a denoised image keeps of it is the mean product of its gradients with theirs: neither grows with
noise, nor with edges that the denoiser makes up. The energy of the denoised image itself stands beside them.
"""

import numpy as np
import tyro
from jaxtyping import Float

from benchmarks.acceptance.photoreal import CAMERA, Part
from benchmarks.result import RESULTS, rounded, write_result
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.generation.scene import prepare_scene
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.render import open_renderer
from warehouse_sim.schema import SceneSpec, Viewpoint

WINDOWS = (
    Part("print", "industrial-v1", 0, 1, 4, (6, 212, 92, 112)),
    Part("film", "industrial-v1", 0, 1, 4, (6, 2, 100, 76)),
    Part("shadowed wall", "industrial-v1", 0, 1, 4, (230, 350, 120, 80)),
)
"""Of one view, whose scene is made once, and of a frozen recipe, so that they go on showing what they are named."""
SHADE = 96
"""Code below which all channels of the reference are in shade."""

Image = Float[np.ndarray, "h w 3"]


def measure(few: tuple[Image, Image], many: tuple[Image, Image]) -> dict[str, float]:
    """Return what two denoised images of few paths keep of the scene, and the noise in them.

    Args:
        few: Denoised, of two seeds (codes).
        many: Halves of the reference without a denoiser, of two seeds (codes).
    """
    clean = [gradients(image) for image in few]
    halves = [gradients(image) for image in many]
    scene = float(np.mean(halves[0] * halves[1]))
    kept = np.mean([np.mean(a * b) for a in clean for b in halves])
    shade = np.mean(many, axis=0).max(axis=-1) < SHADE
    noise = (few[0] - few[1])[shade]
    return {
        "gradient energy kept, over the reference's": float(kept) / scene,
        "own gradient energy, over the reference's": float(np.mean([np.mean(item**2) for item in clean])) / scene,
        "share in shade": float(shade.mean()),
        "noise in shade (codes, rms)": float(np.sqrt(np.mean(noise**2) / 2)) if shade.any() else 0.0,
    }


def gradients(image: Image) -> Float[np.ndarray, " n"]:
    """Return all differences of neighbours (codes a pixel), along rows and columns."""
    return np.concatenate([np.diff(image, axis=axis).ravel() for axis in (0, 1)])


def _centre(part: Part, width: int, height: int) -> PinholeCamera:
    left, top, across, down = part.window
    width, height = min(width, across), min(height, down)
    return CAMERA.crop(left + (across - width) // 2, top + (down - height) // 2, width, height)


def _traced(scene: SceneSpec, view: Viewpoint, cameras: list[PinholeCamera], **options: int | bool) -> list[Image]:
    with open_renderer("pathtrace", **options) as renderer:
        renderer.load(scene)
        return [renderer.render(camera, view.T_world_camera).rgb.astype(float) for camera in cameras]


def main(samples: int = 16, many: int = 256, width: int = 96, height: int = 72, write: bool = False) -> None:
    """Measure windows of one view.

    Args:
        samples: Paths a pixel of the denoised images.
        many: Paths a pixel of the reference, both halves together.
        width: Widest window (px), cut around the centre of its part.
        height: Highest window (px).
        write: Store the result.
    """
    first = WINDOWS[0]
    prepared = prepare_scene(load_recipe(first.recipe), first.seed, first.scene).scene
    view = prepared.viewpoints[first.view]
    scene, cameras = prepared.seen_from(view), [_centre(part, width, height) for part in WINDOWS]
    few = [_traced(scene, view, cameras, samples=samples, denoise=True, seed=seed) for seed in (0, 1)]
    halves = [_traced(scene, view, cameras, samples=many // 2, seed=seed) for seed in (2, 3)]
    rows = []
    for number, part in enumerate(WINDOWS):
        values = rounded(measure((few[0][number], few[1][number]), (halves[0][number], halves[1][number])))
        print(part.name, values, flush=True)
        rows += [{"name": f"{part.name}: {what}", "value": value} for what, value in values.items()]
    if write:
        command = (
            f"python -m benchmarks.acceptance.photoreal_sharpness --samples {samples} --many {many}"
            f" --width {width} --height {height} --write"
        )
        of = f"{first.recipe}, seed {first.seed}, scene {first.scene}, view {first.view}"
        write_result(RESULTS / "photoreal_sharpness.json", command, rows, view=of)


if __name__ == "__main__":
    tyro.cli(main)
