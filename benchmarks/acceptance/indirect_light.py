"""How near the light of the raster backend comes to a path tracer's, in the open and in shadow.

    python -m benchmarks.acceptance.indirect_light            # prints the table: some five CPU-minutes
    python -m benchmarks.acceptance.indirect_light --write    # and stores the result

Twelve views of five recipes are drawn by both, of the same scene, lights and exposure: by the raster backend in full
size, by the path tracer at a quarter of it, so that a block of 32 x 32 px is the mean of 8,192 paths at 128 a pixel.
Compared is luminance before the tone curve. A raster image holds 8 bits after that
curve: each view is drawn at several exposures, and each pixel is read from the brightest that does not clip it.
A pixel lies in shadow where exact rays find no lamp: neither its centre nor its rim.
"""

import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import tyro
from jaxtyping import Bool, Float, UInt8

from benchmarks.result import RESULTS, rounded, write_result
from warehouse_sim.color import LUMINANCE, linear_from_srgb
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.generation.scene import prepare_scene
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.render import open_renderer
from warehouse_sim.render.display import inverse_tone_map
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.render.renderer import Renderer
from warehouse_sim.scene.lighting.photometry import relative_intensity
from warehouse_sim.schema import Light, SceneSpec

VIEWS = {"selective_rack": 3, "dock_staging": 3, "industrial": 2, "block_storage": 2, "conveyor_pickup": 2}
"""Recipe -> number of views."""
SCALE = 4
"""Sides of the camera's image over those of the compared one."""
BLOCK_PX = 32 // SCALE
WITHIN = 1.25
BRIGHTEST = 235
"""Codes from here on are too near to white to be read back."""
BRACKET = (64.0, 16.0, 4.0, 1.0, 0.25, 1 / 16)
"""Exposures that a view is drawn at, times the scene's."""
LEAST_FRACTION = 0.25
"""Fraction of a block's pixels that must lie in shadow for its shadow to count."""
_LIFT = 5e-3  # metres off surfaces at which rays to lamps start


@dataclass(frozen=True)
class Row:
    """One view."""

    recipe: str
    view: int
    ratios: Float[np.ndarray, " n"]
    """Luminance of each block over the path tracer's."""
    shadow_ratios: Float[np.ndarray, " m"]
    """The same of the shadow in each block that holds enough of it."""
    shadow_fraction: float
    """Of the view's pixels."""
    paths_cpu_s: float


@dataclass(frozen=True, eq=False)
class View:
    """One view to compare."""

    recipe: str
    number: int
    scene: SceneSpec
    camera: PinholeCamera
    """Of the raster image."""
    small: PinholeCamera
    """Of the path traced image."""
    T_world_camera: Transform


def views_of(seed: int) -> Iterator[View]:
    """Draw the scenes and yield their views, those of one scene together."""
    for name, count in VIEWS.items():
        recipe = load_recipe(name)
        scene, full = prepare_scene(recipe, seed, 0).scene, recipe.sensors.make_camera().pinhole
        small = full.crop(0, 0, full.width // SCALE, full.height // SCALE, 1 / SCALE)
        camera = full.crop(0, 0, small.width * SCALE, small.height * SCALE)
        for number in range(count):
            place = scene.viewpoints[number * (len(scene.viewpoints) // count)]
            yield View(name, number, scene, camera, small, place.T_world_camera)


def measure(views: Iterable[View], seed: int, samples: int, references: Path | None) -> Iterator[Row]:
    """Draw each view by both backends; images of paths are kept in ``references`` and read from there."""
    with open_renderer("raster") as raster, open_renderer("pathtrace", samples=samples) as paths:
        for view in views:
            file = references / f"{view.recipe}-{seed}-{view.number}-{samples}.npz" if references else None
            if file is not None and file.is_file():
                with np.load(file) as stored:
                    expected, spent = stored["luminance"].astype(float), float(stored["cpu_s"])
            else:
                start = time.process_time()
                paths.load(view.scene)
                expected = paths.luminance(view.small, view.T_world_camera)
                spent = time.process_time() - start
                if file is not None:
                    file.parent.mkdir(parents=True, exist_ok=True)
                    np.savez(file, luminance=expected.astype(np.float32), cpu_s=spent)
            got = smaller(raster_luminance(raster, view))
            shade = in_shadow(view.scene, view.small, view.T_world_camera)
            pair = got @ LUMINANCE, expected @ LUMINANCE
            every, shadow = block_ratios(*pair, np.ones_like(shade)), block_ratios(*pair, shade)
            yield Row(view.recipe, view.number, every, shadow, float(shade.mean()), spent)


def raster_luminance(raster: Renderer, view: View) -> Float[np.ndarray, "h w 3"]:
    """Return the luminance (cd/m^2) of three channels that the raster backend draws."""
    got = np.zeros((view.camera.height, view.camera.width, 3))
    taken = np.zeros(got.shape[:2], bool)
    for factor in BRACKET:
        exposure = view.scene.exposure * factor
        raster.load(replace(view.scene, exposure=exposure))
        rgb = raster.render(view.camera, view.T_world_camera).rgb
        new = ~taken & (rgb.max(axis=2) < BRIGHTEST)
        got[new] = linear(rgb[new]) / exposure
        taken |= new
    return got


def smaller(image: Float[np.ndarray, "h w 3"]) -> Float[np.ndarray, "h4 w4 3"]:
    """Return the means of squares of pixels."""
    height, width = image.shape[0] // SCALE, image.shape[1] // SCALE
    return image.reshape(height, SCALE, width, SCALE, 3).mean(axis=(1, 3))


def linear(rgb: UInt8[np.ndarray, "*shape"]) -> Float[np.ndarray, "*shape"]:
    """Return the linear values that a displayed image was made of."""
    return inverse_tone_map(linear_from_srgb(rgb / 255.0))


def in_shadow(scene: SceneSpec, camera: PinholeCamera, T_world_camera: Transform) -> Bool[np.ndarray, "h w"]:
    """Return the pixels whose surface no lamp reaches."""
    caster, rays = RayCaster(scene), camera.rays().reshape(-1, 3) @ T_world_camera[:3, :3].T
    seen = caster.cast(np.tile(T_world_camera[:3, 3], (len(rays), 1)), rays)
    found = np.isfinite(seen.distance)
    # Seen from either side.
    normals = np.where(((seen.normals * rays).sum(axis=1) > 0.0)[:, None], -seen.normals, seen.normals)[found]
    points = T_world_camera[:3, 3] + rays[found] * seen.distance[found, None].astype(float) + _LIFT * normals
    lit = np.zeros(len(points), bool)
    for light in scene.lights:
        for place in _places_on(light):
            way = place - points
            away = -way / np.linalg.norm(way, axis=1, keepdims=True)
            shines = relative_intensity(light, away @ np.asarray(light.direction, float), away) > 0.0
            towards = (np.einsum("ij,ij->i", way, normals) > 0.0) & shines
            rows = np.flatnonzero(~lit & towards)
            free = caster.cast(points[rows], way[rows]).distance >= 1.0
            lit[rows[free | (not light.casts_shadow)]] = True
    shade = np.zeros(found.size, bool)
    shade[found] = ~lit
    return shade.reshape(camera.height, camera.width)


def _places_on(light: Light) -> Float[np.ndarray, "5 3"]:
    """Return the centre of a light and four points of its rim (m)."""
    side = np.cross(light.direction, np.eye(3)[int(np.argmin(np.abs(light.direction)))])
    side /= np.linalg.norm(side)
    other = np.cross(light.direction, side)
    return np.asarray(light.position, float) + light.radius * np.array([0 * side, side, -side, other, -other])


def block_ratios(
    got: Float[np.ndarray, "h w"], expected: Float[np.ndarray, "h w"], counted: Bool[np.ndarray, "h w"]
) -> Float[np.ndarray, " n"]:
    """Return the means of blocks over those expected, of the pixels that count, where enough of a block do."""
    rows, columns = (size // BLOCK_PX * BLOCK_PX for size in got.shape)
    sums = [
        (image * counted)[:rows, :columns]
        .reshape(rows // BLOCK_PX, BLOCK_PX, columns // BLOCK_PX, BLOCK_PX)
        .sum(axis=(1, 3))
        for image in (got, expected, np.ones_like(got))
    ]
    enough = (sums[2] >= LEAST_FRACTION * BLOCK_PX**2) & (sums[1] > 0.0)
    return sums[0][enough] / sums[1][enough]


def within(ratios: Float[np.ndarray, " n"]) -> float:
    """Return the fraction (%) of ratios that lie within the bound."""
    return 100.0 * float(((ratios < WITHIN) & (ratios > 1.0 / WITHIN)).mean()) if len(ratios) else 100.0


def table(rows: list[Row]) -> dict[str, float]:
    """Return what was measured by name."""
    values: dict[str, float] = {"views": len(rows)}
    groups = {"all": rows} | {name: [row for row in rows if row.recipe == name] for name in VIEWS}
    for name, mine in groups.items():
        ratios = np.concatenate([row.ratios for row in mine])
        shadow = np.concatenate([row.shadow_ratios for row in mine])
        values |= {
            f"{name}: blocks": len(ratios),
            f"{name}: blocks within {WITHIN} (%)": within(ratios),
            f"{name}: median ratio": float(np.median(ratios)),
            f"{name}: blocks with shadow": len(shadow),
            f"{name}: shadow within {WITHIN} (%)": within(shadow),
            f"{name}: median ratio in shadow": float(np.median(shadow)),
            f"{name}: shadow's 5th and 95th percentile, ratio of": float(
                np.percentile(shadow, 95) / np.percentile(shadow, 5)
            ),
        }
    values["path tracer: CPU-s a view"] = float(np.median([row.paths_cpu_s for row in rows]))
    return values


def main(seed: int = 4711, samples: int = 128, references: Path | None = None, write: bool = False) -> None:
    """Compare twelve views of five recipes.

    Args:
        seed: Seed of the scenes.
        samples: Paths a pixel.
        references: Folder that keeps the path traced images between two runs of this command.
        write: Store the result.
    """
    values = table(list(measure(views_of(seed), seed, samples, references)))
    for name, value in values.items():
        print(f"{name:60s} {value:.4g}")
    if write:
        measured = [{"name": name, "value": value} for name, value in values.items()]
        command = f"python -m benchmarks.acceptance.indirect_light --seed {seed} --samples {samples} --write"
        write_result(RESULTS / "indirect_light.json", command, rounded(measured))


if __name__ == "__main__":
    tyro.cli(main)
