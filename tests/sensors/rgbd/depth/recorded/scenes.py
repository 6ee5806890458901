"""A pallet face of the catalog where a recorded one stood, read by a depth camera of the project."""

from dataclasses import replace

import numpy as np
from jaxtyping import Float

from tests.sensors.rgbd.depth.recorded.statistics import Face
from warehouse_sim.catalog.materials import materials_of
from warehouse_sim.catalog.pallets import pallet
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import Transform, invert, make_transform
from warehouse_sim.render import open_renderer
from warehouse_sim.render.conformance.scenes import box_model
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.schema import ObjectInstance, ObjectModel, SceneSpec
from warehouse_sim.sensors.rgbd.depth import DepthModel
from warehouse_sim.sensors.surfaces import see_surfaces
from warehouse_sim.sensors.view import Capture

PALLET = "plastic_runners_blue"
"""Of the catalog, as the recorded ones are of plastic: 1200 mm wide, with two pockets."""
FLOORS = {"mirror": "epoxy_grey", "plain": "concrete"}
_BEHIND = 1.0
"""From the pallet's front to a stack of cartons behind it (m)."""


def simulated_face(recorded: Face, model: DepthModel, mirror_floor: bool, seed: int) -> Face:
    """Return what a camera reads of a catalog pallet in the recorded place, as many frames as there are recorded ones.

    Args:
        recorded: Gives intrinsics, the front's place, the direction down and the floor.
        model: Of the camera.
        mirror_floor: Whether the floor is glossy.
        seed: Of the noise of the frames.
    """
    height, width = recorded.mask.shape
    K = recorded.K
    camera = replace(
        PinholeCamera.from_focal(width, height, float(K[0, 0])), fy=float(K[1, 1]), cx=float(K[0, 2]), cy=float(K[1, 2])
    )
    T_camera_world = _world(recorded)
    pallet_model = pallet(PALLET)
    scene = _scene(pallet_model, FLOORS["mirror" if mirror_floor else "plain"])
    place = invert(T_camera_world)
    with open_renderer("raster") as renderer:
        renderer.load(scene)
        buffers = renderer.render(camera, place, normals=True)
    surfaces = see_surfaces(scene, RayCaster(scene), camera, place, model.needs_reflections)
    capture = Capture(camera, surfaces=surfaces)
    streams = np.random.default_rng(seed).spawn(len(recorded.depths))
    depths = [model.read(buffers, capture, rng) for rng in streams]
    T_camera_dock = T_camera_world @ _T_world_dock(pallet_model)
    return Face(
        name=recorded.name,
        K=K,
        depths=tuple(np.rint(1000 * depth).astype(float) / 1000 for depth in depths),
        docks=(T_camera_dock,) * len(depths),
        outline_px=_pixels(_rectangle(pallet_model), T_camera_world, camera),
        pockets_px=tuple(
            _pixels(_opening(T, size), T_camera_world, camera)
            for T, size in ((item.T_object_pocket, item.size) for item in pallet_model.pockets if item.face == "-y")
        ),
        mask=buffers.instance_mask == 2,
        down=recorded.down,
        floor_distance=recorded.floor_distance,
    )


def _world(recorded: Face) -> Transform:
    """Return ``T_camera_world``: origin on the floor below the middle of the front, y inwards, z up."""
    dock = recorded.docks[0]
    up = -recorded.down
    inwards = dock[:3, 0] - (dock[:3, 0] @ up) * up
    inwards /= np.linalg.norm(inwards)
    middle = dock[:3, 3]
    on_floor = middle + (recorded.floor_distance - middle @ recorded.down) * recorded.down
    return make_transform(np.column_stack([np.cross(inwards, up), inwards, up]), on_floor)


def _scene(model: ObjectModel, floor: str) -> SceneSpec:
    ground = box_model("floor", (12.0, 12.0, 0.1), floor, "floor", 90)
    stack = box_model("stack", (1.6, 0.4, 1.2), "kraft", "carton", 91)
    placed = (
        (ground, (0.0, 0.0, -0.05)),
        (model, (0.0, model.size[1] / 2, model.size[2] / 2)),
        (stack, (0.7, _BEHIND + 0.2, 0.6)),
    )
    return SceneSpec(
        scene_index=0,
        seed=0,
        models={item.name: item for item, _ in placed},
        materials=materials_of([item for item, _ in placed]),
        instances=tuple(
            ObjectInstance(number, item.name, make_transform(None, np.array(at, float)))
            for number, (item, at) in enumerate(placed, start=1)
        ),
        lights=(),
        viewpoints=(),
    )


def _T_world_dock(model: ObjectModel) -> Transform:
    """Return the frame of the front: x inwards, y to the left, z up, midway between the pockets."""
    heights = [item.T_object_pocket[2, 3] for item in model.pockets if item.face == "-y"]
    R = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    return make_transform(R, np.array([0.0, 0.0, float(np.mean(heights)) + model.size[2] / 2]))


def _rectangle(model: ObjectModel) -> Float[np.ndarray, "4 3"]:
    x, top = model.size[0] / 2, model.size[2]
    return np.array([[-x, 0, top], [x, 0, top], [x, 0, 0], [-x, 0, 0]])


def _opening(T_object_pocket: Transform, size: Float[np.ndarray, " 3"]) -> Float[np.ndarray, "4 3"]:
    """Return the corners of a pocket's opening in the world (m), the pallet's front at y = 0."""
    centre = T_object_pocket[:3, 3]
    model = pallet(PALLET)
    x, z = size[1] / 2, size[2] / 2
    middle = np.array([centre[0], 0.0, centre[2] + model.size[2] / 2])
    return middle + np.array([[-x, 0, z], [x, 0, z], [x, 0, -z], [-x, 0, -z]])


def _pixels(points: Float[np.ndarray, "n 3"], T_camera_world: Transform, camera: PinholeCamera) -> np.ndarray:
    there = points @ T_camera_world[:3, :3].T + T_camera_world[:3, 3]
    return np.asarray(camera.project(there))
