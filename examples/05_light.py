"""The same view in four kinds of light; geometry and labels stay.

python examples/05_light.py
"""

from pathlib import Path

import cv2
import numpy as np

import warehouse_sim as ws

NAMES = ("nominal", "dim", "backlit", "night")

Path("out/examples").mkdir(parents=True, exist_ok=True)
scene = ws.Scene("smoke", seed=2).settle()
images = []
for name in NAMES:
    scene.light(name)
    (shot,) = scene.render(ws.Camera(width=480, height=270, focal_px=330), views=1)
    print(f"{name}: mean of the image {shot.rgb.mean():.0f}, {len(shot.objects)} objects with labels")
    image = shot.rgb[..., ::-1].copy()  # OpenCV takes BGR
    cv2.putText(image, name, (10, 28), cv2.FONT_HERSHEY_SIMPLEX, 0.8, (255, 255, 255), 2, cv2.LINE_AA)
    images.append(image)
cv2.imwrite("out/examples/05_light.png", np.vstack([np.hstack(images[:2]), np.hstack(images[2:])]))
