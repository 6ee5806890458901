"""Do cameras stand free and see what was requested? A thousand viewpoints of each kind, checked in settled scenes.

    python -m benchmarks.acceptance.viewpoint_requests            # prints the rows
    python -m benchmarks.acceptance.viewpoint_requests --write    # and stores results/viewpoint_requests.json

Rays (Embree) through the settled meshes say how near the nearest surface is
and which targets the KITTI camera shows at a quarter of its resolution; the separating axis test says how near vehicles
come to collision boxes. A target counts as in view with at least 4 of those pixels (64 at full resolution).
"""

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import tyro

from benchmarks.result import RESULTS, write_result
from warehouse_sim.errors import SettleError
from warehouse_sim.generation.recipe import Recipe, load_recipe
from warehouse_sim.generation.sampled import sample_settled_scene
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import transform_points
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.scene.viewpoints import FreeSpace, ViewpointsConfig
from warehouse_sim.scene.viewpoints.mountings import MOUNTINGS
from warehouse_sim.schema import SceneSpec, Viewpoint

SINGLE = ("level", "forklift_mast", "forklift_forks", "forklift_guard", "amr", "free")
DRIVES = (
    ("drive", "forklift_guard"),
    ("drive", "amr"),
    ("turn_in", "forklift_forks"),
    ("approach", "forklift_mast"),
    ("approach", "forklift_forks"),
)
PER_SCENE = 20
ENOUGH_PIXELS = 4
FLAT = 0.05
"""What lies lower (m) is the floor or a mark on it: vehicles drive over it, and cameras may be near it."""
_DIRECTIONS = np.random.default_rng(0).normal(size=(1500, 3))
_DIRECTIONS /= np.linalg.norm(_DIRECTIONS, axis=1, keepdims=True)


@dataclass
class Tally:
    """What was found about the viewpoints of one kind."""

    views: int = 0
    scenes: int = 0
    failed: int = 0
    lacking: int = 0
    struck: int = 0
    inside: int = 0
    surface: list[float] = field(default_factory=list)
    boxes: list[float] = field(default_factory=list)
    bodies: list[float] = field(default_factory=list)
    seconds: float = 0.0

    def rows(self, name: str) -> list[dict[str, float | str]]:
        """Return the rows of the result."""
        values: dict[str, float] = {
            "viewpoints": self.views,
            "scenes": self.scenes,
            "scenes without such viewpoints": self.failed,
            "cameras inside an object": self.inside,
            "viewpoints without the targets requested": self.lacking,
            "vehicles struck by goods that fell after they were placed": self.struck,
            "least distance from camera to surface, m": round(min(self.surface), 3),
            "least distance from camera to collision box, m": round(min(self.boxes), 3),
            "ms to choose one, scene and settling included": round(1000 * self.seconds / self.views, 1),
        }
        if self.bodies:
            values["least gap between vehicle and object, m"] = round(min(self.bodies), 3)
        return [{"name": f"{name}: {key}", "value": value} for key, value in values.items()]


def tally(recipe: Recipe, config: ViewpointsConfig, count: int, seed: int) -> Tally:
    """Choose ``count`` viewpoints in settled scenes of ``recipe`` and check them."""
    scene_recipe = replace(recipe.scene, viewpoints=config, observations_per_scene=PER_SCENE)
    recipe, found, index = replace(recipe, scene=scene_recipe), Tally(), 0
    camera = recipe.sensors.make_camera()
    quarter = camera.crop(0, 0, camera.width // 4, camera.height // 4, 0.25)
    while found.views < count:
        start = time.process_time()
        try:
            sampled = sample_settled_scene(recipe, seed, index)
        except SettleError:
            found.failed += 1
            continue
        finally:
            index += 1
            found.seconds += time.process_time() - start
        found.scenes += 1
        check(sampled.scene, config, sampled.report.fallen, quarter, found)
    return found


def check(
    scene: SceneSpec, config: ViewpointsConfig, fallen: Sequence[int], camera: PinholeCamera, found: Tally
) -> None:
    """Check all viewpoints of a settled scene, in which the objects ``fallen`` fell over."""
    caster, space = RayCaster(scene), FreeSpace.of_scene(scene)
    raised, loose = space.solids.extents[1][:, 2] > FLAT, np.isin(space.solids.owner, fallen)
    solid, standing = space.solids.boxes.subset(raised), space.solids.boxes.subset(raised & ~loose)
    litter = space.solids.boxes.subset(raised & loose)
    targets = {item.instance_id for item in space.targets}
    for view in scene.viewpoints:
        found.views += 1
        eye = view.T_world_camera[:3, 3]
        hits = caster.cast(np.broadcast_to(eye, _DIRECTIONS.shape), _DIRECTIONS)
        met = np.isfinite(hits.distance)
        height = eye[2] + np.where(met, hits.distance, 0.0) * _DIRECTIONS[:, 2]
        found.surface.append(float(hits.distance[met & (height > FLAT)].min()))
        found.boxes.append(float(solid.distances_to(eye).min()))
        # Inside a closed body every ray first meets the back of a surface.
        backs = (hits.normals * _DIRECTIONS).sum(axis=1) > 0.0
        found.inside += bool(backs.mean() > 0.5 or found.boxes[-1] == 0.0)
        rays = transform_points(view.T_world_camera, camera.rays().reshape(-1, 3)) - eye
        seen, pixels = np.unique(caster.cast(np.broadcast_to(eye, rays.shape), rays).instance_ids, return_counts=True)
        shown = {int(item) for item, count in zip(seen, pixels, strict=True) if count >= ENOUGH_PIXELS} & targets
        found.lacking += view.target not in shown or len(shown) < config.min_targets
        found.bodies += list(body_gaps(view, standing))
        found.struck += any(gap <= 0.0 for gap in body_gaps(view, litter))


def body_gaps(view: Viewpoint, solid: BoxStack) -> Iterator[float]:
    """Yield the gap (m) between the vehicle's body and the nearest box within half a metre of it."""
    vehicle = MOUNTINGS[view.kind].vehicle if view.kind in MOUNTINGS else None
    if vehicle is None or view.T_world_vehicle is None:
        return
    body = BoxStack.of(vehicle.boxes(view.T_world_vehicle)[:1])
    pairs = body.pairs(solid, 0.5)
    if len(pairs):
        yield float(body.separation(solid, pairs).distance.min())


def requests() -> dict[str, ViewpointsConfig]:
    """Return what is requested, by name: two targets in each single view, one in each frame of a drive."""
    found = {kind: ViewpointsConfig(kind=kind, min_targets=2) for kind in SINGLE}
    for way, kind in DRIVES:
        elevation = 13.0 if way == "approach" else 10.0
        found[f"{way} {kind}"] = ViewpointsConfig(kind=kind, trajectory=way, max_elevation_deg=elevation)
    return found


def main(
    names: tuple[str, ...] = (), recipe: str = "industrial-v1", count: int = 1000, seed: int = 0, write: bool = False
) -> None:
    """Measure and print.

    Args:
        names: What to measure, such as "amr" or "turn_in forklift_forks"; everything by default.
        recipe: Name or path of the recipe whose scenes are looked at.
        count: Viewpoints of each kind.
        seed: Seed of the dataset.
        write: Store the result file.
    """
    loaded, requested = load_recipe(recipe), requests()
    rows: list[dict[str, float | str]] = []
    for name in names or requested:
        rows += (found := tally(loaded, requested[name], count, seed).rows(name))
        for row in found:
            print(f"{row['name']:75s} {row['value']}", flush=True)
    if write:
        command = f"python -m benchmarks.acceptance.viewpoint_requests --recipe {recipe} --count {count} --seed {seed}"
        write_result(RESULTS / "viewpoint_requests.json", command, rows)


if __name__ == "__main__":
    tyro.cli(main)
