"""One picture of a warehouse with its labels, in memory: no dataset is written.

python examples/01_first_picture.py
"""

import warehouse_sim as ws

scene = ws.Scene("dock_staging", seed=1)  # any name that `warehouse-sim list recipes` prints
(shot,) = scene.settle().render(views=1)
print(f"image {shot.rgb.shape}, depth to {shot.depth.max():.1f} m")
for item in shot.objects:
    print(f"{item.name}: {item.T_camera_object[2, 3]:.2f} m ahead, {item.visible_fraction:.0%} visible")
shot.draw("out/examples/01_first_picture.png")
