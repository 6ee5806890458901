"""An object of one's own, with labels like any other: here a tool trolley.

python examples/04_own_object.py
"""

from pathlib import Path

import warehouse_sim as ws

trolley = Path(__file__).parent / "custom_object" / "trolley.yaml"  # beside its mesh, see docs/custom_objects.md
recipe = ws.recipe("smoke")
recipe.add(trolley, places=["floor"], count=(2, 3))
recipe.save("out/examples/with_trolleys.yaml")  # scenes with it, for `warehouse-sim generate`

scene = ws.Scene()
scene.add(trolley, x=1.0, yaw_deg=60)
scene.add("epal1", x=1.2, y=-1.2)
shot = scene.settle().render(
    ws.Camera(width=640, height=480, focal_px=500), at=(-1.2, 0.4, 1.3), look_at=(1, -0.4, 0.4)
)
for item in shot.objects:
    print(f"{item.name}, a {item.class_name}, {item.T_camera_object[2, 3]:.2f} m ahead")
shot.draw("out/examples/04_own_object.png")
