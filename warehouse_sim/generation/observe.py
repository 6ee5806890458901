"""A settled scene becomes observations: render -> sense -> annotate, one viewpoint after the other."""

from collections.abc import Iterator

from warehouse_sim.annotate import annotate, targets_in_view
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.render.renderer import Renderer
from warehouse_sim.scene.streams import scene_rng
from warehouse_sim.schema import Observation, SceneSpec
from warehouse_sim.sensors.lidar import scan
from warehouse_sim.sensors.rgbd import read_rgbd
from warehouse_sim.sensors.rig import RigConfig


def observe_scene(scene: SceneSpec, rig: RigConfig, renderer: Renderer) -> Iterator[Observation]:
    """Yield one observation for each viewpoint of a settled scene.

    Args:
        scene: What to look at.
        rig: Camera, depth noise and LiDAR.
        renderer: Draws; the scene is loaded into it here.
    """
    renderer.load(scene)
    raycaster = RayCaster(scene) if rig.lidar is not None else None
    camera, T_camera_lidar = rig.make_camera(), rig.T_camera_lidar()
    for index, viewpoint in enumerate(scene.viewpoints):
        T_world_camera = viewpoint.T_world_camera
        buffers = renderer.render(camera, T_world_camera)
        rgbd = read_rgbd(buffers, rig.rgbd, scene_rng(scene.seed, scene.scene_index, f"rgbd {index}"))
        lidar = None
        if raycaster is not None and rig.lidar is not None:
            rng = scene_rng(scene.seed, scene.scene_index, f"lidar {index}")
            lidar = scan(raycaster, rig.lidar, T_world_camera @ T_camera_lidar, rng)
        targets = targets_in_view(scene, camera, T_world_camera)
        silhouettes = renderer.silhouettes(camera, T_world_camera, targets)
        yield Observation(
            scene_index=scene.scene_index,
            observation_index=index,
            camera=camera,
            T_world_camera=T_world_camera,
            T_camera_lidar=T_camera_lidar,
            rgbd=rgbd,
            buffers=buffers,
            lidar=lidar,
            annotations=annotate(scene, camera, T_world_camera, buffers, rgbd.depth, silhouettes, targets),
        )
