"""The same views by every render backend, and how far each is from the path tracer.

    python -m docs.figures.looks                 # images to docs/images/looks, tables to docs/looks.md, numbers to
                                               # benchmarks/results/looks.json
    python -m docs.figures.looks --samples 8 --out /tmp/looks      # a quick look, elsewhere

The path tracer's images are kept in ``cache`` and used again while scene, camera and number of paths stay the same.
"""

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import tyro
from jaxtyping import UInt8

from benchmarks.speed.result import rounded, write_result
from docs.figures.color_difference import ciede2000, lab_from_srgb
from warehouse_sim.errors import WarehouseSimError
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.generation.scene import sample_settled_scene
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.render import open_renderer
from warehouse_sim.render.display import to_display
from warehouse_sim.schema import SceneSpec, Viewpoint

ROOT = Path(__file__).parents[2]
PEERS = ("raster", "mujoco", "pyrender")
_BEGIN, _END = "<!-- written by docs/figures/looks.py -->", "<!-- end -->"
_LARGEST_FILE = 118_000  # bytes, so that twenty images stay below 2.4 MB


@dataclass(frozen=True)
class View:
    """One image of the gallery."""

    recipe: str
    viewpoint: int
    scene_index: int = 0
    seed: int = 0


VIEWS = (
    View("selective_rack", 7),
    View("industrial", 2),
    View("block_storage", 1, scene_index=1),
    View("dock_staging", 11),
    View("conveyor_pickup", 8),
)


@dataclass(frozen=True, eq=False)
class Subject:
    """A view with what is seen in it."""

    view: View
    scene: SceneSpec
    viewpoint: Viewpoint
    camera: PinholeCamera


@dataclass(frozen=True, eq=False)
class Reference:
    """The path tracer's image of a view."""

    rgb: UInt8[np.ndarray, "h w 3"]
    noise: float
    """Mean absolute error (0-255) that its randomness leaves, from two independent halves."""


def main(samples: int = 128, out: Path = ROOT, cache: Path = Path("out/looks"), only: tuple[str, ...] = ()) -> None:
    """Draw all views and compare.

    Args:
        samples: Paths a pixel of the reference.
        out: Folder in which docs/ and benchmarks/results/ are written.
        cache: Folder of the path tracer's images.
        only: Recipes to draw; all when omitted, and only then docs/looks.md is written.
    """
    images, results = out / "docs" / "images" / "looks", out / "benchmarks" / "results"
    for folder in (images, results, cache):
        folder.mkdir(parents=True, exist_ok=True)
    subjects = [load(view) for view in VIEWS if not only or view.recipe in only]
    references = [reference(subject, samples, cache) for subject in subjects]
    rendered = {name: list(draw(name, subjects)) for name in PEERS}
    rows = []
    for number, (subject, ideal) in enumerate(zip(subjects, references, strict=True)):
        save_jpeg(images / f"{subject.view.recipe}_pathtrace.jpg", ideal.rgb)
        rows.append({"name": f"{subject.view.recipe}/pathtrace noise", "value": ideal.noise})
        for name in PEERS:
            image = rendered[name][number]
            if image is not None:
                save_jpeg(images / f"{subject.view.recipe}_{name}.jpg", image)
                rows.append({"name": f"{subject.view.recipe}/{name}", **difference(image, ideal.rgb)})
    for row in rounded(rows):
        print(row)
    if not only:
        command = f"python -m docs.figures.looks --samples {samples}"
        write_result(results / "looks.json", command, rounded(rows))
        write_page(out / "docs" / "looks.md", rounded(rows), command)


def load(view: View) -> Subject:
    """Sample and settle the scene of ``view``, under the light of its viewpoint."""
    recipe = load_recipe(view.recipe)
    scene = sample_settled_scene(recipe, seed=view.seed, scene_index=view.scene_index).scene
    viewpoint = scene.viewpoints[view.viewpoint]
    return Subject(view, scene.seen_from(viewpoint), viewpoint, recipe.sensors.make_camera())


def reference(subject: Subject, samples: int, cache: Path) -> Reference:
    """Return the path tracer's image, from ``cache`` if it is there."""
    path = cache / f"{subject.view.recipe}-{samples}-{fingerprint(subject)}.npz"
    if not path.is_file():
        halves = []
        for seed in (0, 1):
            with open_renderer("pathtrace", samples=max(samples // 2, 1), seed=seed) as renderer:
                renderer.load(subject.scene)
                light: Any = renderer
                halves.append(
                    light.luminance(subject.camera, subject.viewpoint.T_world_camera) * subject.scene.exposure
                )
        np.savez_compressed(path, halves=np.array(halves, np.float32))
        print(f"{subject.view.recipe}: traced")
    first, second = np.load(path)["halves"].astype(float)
    # The halves differ by sqrt(2) times their error, and their mean's error is smaller by sqrt(2).
    noise = np.abs(to_display(first).astype(float) - to_display(second)).mean() / 2.0
    return Reference(to_display((first + second) / 2.0), float(noise))


def fingerprint(subject: Subject) -> str:
    """Return a hash of all that the image depends on."""
    scene, total = subject.scene, hashlib.sha256()
    total.update(repr((subject.camera, sorted(scene.materials.items()), scene.ambient, scene.exposure)).encode())
    total.update(repr([vars(light) for light in scene.lights]).encode())
    total.update(subject.viewpoint.T_world_camera.tobytes())
    for instance in scene.instances:
        total.update(instance.T_world_object.tobytes())
        for part in scene.model_of(instance).parts:
            total.update(part.material.encode() + part.T_object_part.tobytes() + np.asarray(part.scale).tobytes())
            total.update(part.mesh.vertices.tobytes())
    return total.hexdigest()[:16]


def draw(name: str, subjects: list[Subject]) -> Iterator[UInt8[np.ndarray, "h w 3"] | None]:
    """Yield the image of each subject by the backend ``name``, or None where it cannot draw."""
    try:
        with open_renderer(name) as renderer:
            for subject in subjects:
                renderer.load(subject.scene)
                yield renderer.render(subject.camera, subject.viewpoint.T_world_camera).rgb
    except (WarehouseSimError, ImportError) as error:
        print(f"{name} is left out: {error}")
        yield from [None] * len(subjects)


def difference(image: UInt8[np.ndarray, "h w 3"], ideal: UInt8[np.ndarray, "h w 3"]) -> dict[str, float]:
    """Return the mean absolute difference of sRGB codes, the mean CIEDE2000, and how much brighter it is."""
    apart = image.astype(float) - ideal
    return {
        "value": float(np.abs(apart).mean()),
        "ciede2000": float(ciede2000(lab_from_srgb(image), lab_from_srgb(ideal)).mean()),
        "brighter": float(apart.mean()),
    }


def save_jpeg(path: Path, rgb: UInt8[np.ndarray, "h w 3"]) -> None:
    """Store an image at the best quality that keeps it small."""
    for quality in range(95, 40, -3):
        done, data = cv2.imencode(".jpg", np.ascontiguousarray(rgb[..., ::-1]), [cv2.IMWRITE_JPEG_QUALITY, quality])
        if done and len(data) <= _LARGEST_FILE:
            break
    path.write_bytes(data.tobytes())


def write_page(path: Path, rows: list[dict[str, Any]], command: str) -> None:
    """Replace what stands between the markers of ``path``."""
    before, _, rest = path.read_text(encoding="utf-8").partition(_BEGIN)
    _, _, after = rest.partition(_END)
    by_name = {row["name"]: row for row in rows}
    lines = ["| view | " + " | ".join(PEERS) + " | noise of the reference |", "|---|" + "---:|" * (len(PEERS) + 1)]
    for view in VIEWS:
        cells = [_cell(by_name.get(f"{view.recipe}/{name}")) for name in PEERS]
        noise = by_name[f"{view.recipe}/pathtrace noise"]["value"]
        lines.append(f"| `{view.recipe}` | " + " | ".join(cells) + f" | {noise:.1f} |")
    for view in VIEWS:
        where = f"seed {view.seed}, scene {view.scene_index}, viewpoint {view.viewpoint}"
        lines += ["", f"## {view.recipe}: {where}", "", "| pathtrace | raster |", "|---|---|"]
        names = ("pathtrace", *PEERS)
        cells = [f"![{name}](images/looks/{view.recipe}_{name}.jpg)" for name in names]
        lines += [f"| {cells[0]} | {cells[1]} |", f"| {cells[2]} | {cells[3]} |", "| mujoco | pyrender |"]
    text = "\n".join([_BEGIN, f"Command: `{command}`", "", *lines, _END])
    path.write_text(before + text + after, encoding="utf-8")


def _cell(row: dict[str, Any] | None) -> str:
    return "not here" if row is None else f"{row['value']:.1f} / {row['ciede2000']:.1f} ({row['brighter']:+.1f})"


if __name__ == "__main__":
    tyro.cli(main)
