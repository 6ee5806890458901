"""What three depth cameras read of one scene, and how far off they are.

python examples/06_sensors.py
"""

from pathlib import Path

import cv2
import numpy as np

import warehouse_sim as ws

Path("out/examples").mkdir(parents=True, exist_ok=True)
scene = ws.Scene("smoke", seed=2).settle()
readings = {}
for name in ("ideal", "d435", "tof_industrial"):
    camera = ws.Camera(width=480, height=270, focal_px=330, depth=name)
    (shot,) = scene.render(camera, views=1)
    readings[name] = shot.depth  # metres along the optical axis, 0 = no reading

ideal, images = readings["ideal"], []
for name, depth in readings.items():
    both = (depth > 0) & (ideal > 0) & (ideal < 6)
    off = 1000 * np.abs(depth - ideal)[both]
    print(
        f"{name}: reads {np.mean(depth[ideal > 0] > 0):.0%}, off by {np.median(off):.1f} mm (median, nearer than 6 m)"
    )
    near = np.clip(depth / 6 * 255, 0, 255).astype(np.uint8)
    image = cv2.applyColorMap(near, cv2.COLORMAP_TURBO) * (depth > 0)[..., None]
    images.append(cv2.putText(image, name, (10, 28), cv2.FONT_HERSHEY_SIMPLEX, 0.8, (255, 255, 255), 2, cv2.LINE_AA))
cv2.imwrite("out/examples/06_sensors.png", np.hstack(images))
