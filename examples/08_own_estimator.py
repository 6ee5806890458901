"""Score a function of one's own beside a baseline, and draw what it found.

python examples/08_own_estimator.py
"""

import cv2
import numpy as np

import warehouse_sim as ws


def middle_of_the_points(image):
    """Return each pallet at the median of its points, level and straight ahead: the least that one can do."""
    found = []
    for item in image.detections:  # ground-truth masks, unless others are chosen
        v, u = np.nonzero(item.mask & (image.depth > 0))
        points = np.linalg.inv(image.camera.K) @ np.stack([u, v, np.ones(len(u))]) * image.depth[v, u]
        T_camera_object = np.eye(4)
        T_camera_object[:3, :3] = [[0, -1, 0], [0, 0, -1], [1, 0, 0]]  # its x ahead, its z up
        T_camera_object[:3, 3] = np.median(points, axis=1)
        found.append(ws.PoseEstimate(image.scene_id, image.image_id, item.model, 0.5, T_camera_object))
    return found


data = ws.generate("smoke", "out/examples/scored", scenes=2, formats="bop", overwrite=True)
for estimator in (middle_of_the_points, "rectangle-fit"):
    scores = data.evaluate(estimator)
    print(f"{scores['method']}: {scores.metrics['add_10pct']:.0%} within 10 % of the diameter")

obs = data.split("test")[0]
image = obs.rgb[..., ::-1].copy()
for pose in ws.predict(middle_of_the_points, data, split="test"):
    if (pose.scene_id, pose.image_id) == (obs.scene_id, obs.image_id):
        x, y, z = obs.camera.K @ pose.T_camera_object[:3, 3]
        cv2.drawMarker(image, (int(x / z), int(y / z)), (0, 0, 255), cv2.MARKER_CROSS, 30, 3)
cv2.imwrite("out/examples/08_own_estimator.png", image)
