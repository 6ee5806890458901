"""From a recipe to one observation in memory, without writing a dataset.

python examples/one_observation.py
"""

from warehouse_sim.generation.observe import observe_scene
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.generation.scene import prepare_scene
from warehouse_sim.render import open_renderer

recipe = load_recipe("demo")
prepared = prepare_scene(recipe, seed=0, scene_index=0)

with open_renderer("raster") as renderer:
    observation = next(observe_scene(prepared.scene, recipe.sensors, renderer))

rgb, depth, scan = observation.rgbd.rgb, observation.rgbd.depth, observation.lidar
print(f"image {rgb.shape}, depth to {depth.max():.1f} m, {len(scan.points)} LiDAR points")
print(f"{observation.conditions.floor_lux:.0f} lx on the floor, exposed at EV {observation.conditions.exposure_ev:.1f}")
for label in observation.annotations:
    distance = label.T_camera_object[2, 3]
    print(f"{label.class_name} {label.instance_id}: {distance:.2f} m ahead, {label.visible_fraction:.0%} visible")
