"""A scene put together by hand, seen by a camera of one's own.

python examples/03_own_scene.py
"""

import warehouse_sim as ws

scene = ws.Scene()  # an empty hall; metres, z up
scene.add("shelf_bay", x=2.5)
scene.add("epal1", x=0.8, yaw_deg=20)
for x, y in ((0.52, -0.1), (1.08, 0.1), (0.8, 0.0)):
    scene.add("carton_600x400x300", x=x, y=y, yaw_deg=20)  # each stands on what is under it
scene.light("nominal", lux=300)
camera = ws.Camera(width=640, height=480, focal_px=500)
shot = scene.settle().render(camera, at=(-2.2, -0.8, 1.4), look_at=(0.9, 0.0, 0.4))
for item in shot.objects:
    print(item.name, item.T_camera_object[:3, 3].round(3))
shot.draw("out/examples/03_own_scene.png")
