"""From a recipe to one observation in memory, without writing a dataset.

python examples/one_observation.py
"""

from warehouse_sim import load_recipe, observe_scene, open_renderer, sample_scene, settle_scene

recipe = load_recipe("demo")
scene = sample_scene(recipe.scene, seed=0, scene_index=0)
settled, report = settle_scene(scene, recipe.settle)
report.require_ok()

with open_renderer("raster") as renderer:
    observation = next(observe_scene(settled, recipe.sensors, renderer))

rgb, depth, scan = observation.rgbd.rgb, observation.rgbd.depth, observation.lidar
print(f"image {rgb.shape}, depth to {depth.max():.1f} m, {len(scan.points)} LiDAR points")
for label in observation.annotations:
    distance = label.T_camera_object[2, 3]
    print(f"{label.class_name} {label.instance_id}: {distance:.2f} m ahead, {label.visible_fraction:.0%} visible")
