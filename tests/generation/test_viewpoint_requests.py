"""Do cameras stand free and see what was requested? Viewpoints of each kind, checked in settled scenes.

Rays (Embree) through the settled meshes say how near the nearest surface is and which targets the KITTI camera shows
at a quarter of its resolution; the separating axis test says how near vehicles come to collision boxes: neither chose
the viewpoints. A target counts as in view with at least 4 of those pixels (64 at full resolution).
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from warehouse_sim.errors import SettleError
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.generation.scene import sample_settled_scene
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import transform_points
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.scene.viewpoints.config import ViewpointsConfig
from warehouse_sim.scene.viewpoints.free_space import FreeSpace
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
PER_SCENE, COUNT = 20, 100
ENOUGH_PIXELS = 4
FLAT = 0.05
"""What lies lower (m) is the floor or a mark on it: vehicles drive over it, and cameras may be near it."""
_DIRECTIONS = np.random.default_rng(0).normal(size=(1500, 3))
_DIRECTIONS /= np.linalg.norm(_DIRECTIONS, axis=1, keepdims=True)


@dataclass
class Tally:
    """What was found about the viewpoints of one kind."""

    views: int = 0
    lacking: int = 0
    inside: int = 0
    surface: list[float] = field(default_factory=list)
    bodies: list[float] = field(default_factory=list)


def requests() -> dict[str, ViewpointsConfig]:
    """Return what is requested, by name: two targets in each single view, one in each frame of a drive."""
    found = {kind: ViewpointsConfig(kind=kind, min_targets=2) for kind in SINGLE}
    for way, kind in DRIVES:
        elevation = 13.0 if way == "approach" else 10.0
        found[f"{way} {kind}"] = ViewpointsConfig(kind=kind, trajectory=way, max_elevation_deg=elevation)
    return found


@pytest.mark.slow
@pytest.mark.parametrize("name", requests())
def test_cameras_stand_free_and_see_their_targets(name: str) -> None:
    """Of a thousand of each kind none stood in an object or lacked its targets, nor came a vehicle nearer than 8 cm."""
    config, recipe, found, index = requests()[name], load_recipe("industrial-v1"), Tally(), 0
    scene_recipe = replace(recipe.scene, viewpoints=config, observations_per_scene=PER_SCENE)
    recipe, camera = replace(recipe, scene=scene_recipe), recipe.sensors.make_camera()
    quarter = camera.crop(0, 0, camera.width // 4, camera.height // 4, 0.25)
    while found.views < COUNT:
        try:
            sampled = sample_settled_scene(recipe, 0, index)
        except SettleError:
            continue
        finally:
            index += 1
        check(sampled.scene, config, frozenset(sampled.report.fallen), quarter, found)
    assert found.inside == 0
    assert found.lacking == 0
    assert min(found.surface) > 0.5
    assert min(found.bodies, default=1.0) > 0.05


def check(
    scene: SceneSpec, config: ViewpointsConfig, fallen: frozenset[int], camera: PinholeCamera, found: Tally
) -> None:
    """Check all viewpoints of a settled scene; objects that fell over may lie where a vehicle stands."""
    caster, space = RayCaster(scene), FreeSpace.of_scene(scene)
    raised, loose = space.solids.extents[1][:, 2] > FLAT, np.isin(space.solids.owner, list(fallen))
    solid, standing = space.solids.boxes.subset(raised), space.solids.boxes.subset(raised & ~loose)
    targets = {item.instance_id for item in space.targets}
    for view in scene.viewpoints:
        found.views += 1
        eye = view.T_world_camera[:3, 3]
        hits = caster.cast(np.broadcast_to(eye, _DIRECTIONS.shape), _DIRECTIONS)
        met = np.isfinite(hits.distance)
        height = eye[2] + np.where(met, hits.distance, 0.0) * _DIRECTIONS[:, 2]
        found.surface.append(float(hits.distance[met & (height > FLAT)].min()))
        # Inside a closed body every ray first meets the back of a surface.
        backs = (hits.normals * _DIRECTIONS).sum(axis=1) > 0.0
        found.inside += bool(backs.mean() > 0.5 or solid.distances_to(eye).min() == 0.0)
        rays = transform_points(view.T_world_camera, camera.rays().reshape(-1, 3)) - eye
        seen, pixels = np.unique(caster.cast(np.broadcast_to(eye, rays.shape), rays).instance_ids, return_counts=True)
        shown = {int(item) for item, count in zip(seen, pixels, strict=True) if count >= ENOUGH_PIXELS} & targets
        found.lacking += view.target not in shown or len(shown) < config.min_targets
        found.bodies += list(body_gaps(view, standing))


def body_gaps(view: Viewpoint, solid: BoxStack) -> Iterator[float]:
    """Yield the gap (m) between the vehicle's body and the nearest box within half a metre of it."""
    vehicle = MOUNTINGS[view.kind].vehicle if view.kind in MOUNTINGS else None
    if vehicle is None or view.T_world_vehicle is None:
        return
    body = BoxStack.of(vehicle.boxes(view.T_world_vehicle)[:1])
    pairs = body.pairs(solid, 0.5)
    if len(pairs):
        yield float(body.separation(solid, pairs).distance.min())
