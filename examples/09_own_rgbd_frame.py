"""Poses of the objects in your own RGB-D image: arrays and intrinsics in, poses out.

python examples/09_own_rgbd_frame.py [ESTIMATOR]      # a bundled name or a run folder
"""

import sys
from pathlib import Path

import cv2
import numpy as np

from warehouse_sim import Detection, RgbdImage, load_estimator

folder, out = Path(__file__).with_name("own_rgbd_frame"), Path("out/examples")
rgb = cv2.cvtColor(cv2.imread(str(folder / "rgb.jpg")), cv2.COLOR_BGR2RGB)
depth = cv2.imread(str(folder / "depth.png"), cv2.IMREAD_UNCHANGED) / 1000.0  # millimetres in the file, metres here
mask = cv2.imread(str(folder / "mask.png"), cv2.IMREAD_GRAYSCALE) > 0  # from any detector
K = np.array([[721.5377, 0.0, 80.5], [0.0, 721.5377, 124.5], [0.0, 0.0, 1.0]])

estimator = load_estimator(sys.argv[1] if len(sys.argv) > 1 else "densefusion-pointcloud")
picture = rgb[..., ::-1].copy()
for pose in estimator.estimate(RgbdImage.from_arrays(depth, K, [Detection(mask, "epal1")], rgb)):
    T = pose.T_camera_object
    x, y, z = T[:3, 3]
    error = "unknown" if pose.predicted_error is None else f"{100 * pose.predicted_error:.1f} cm"
    print(f"{pose.name} at x {x:.2f}, y {y:.2f}, z {z:.2f} m; score {pose.score:.2f}, expected error {error}")
    print(np.round(T, 3))
    turn, _ = cv2.Rodrigues(T[:3, :3])
    cv2.drawFrameAxes(picture, K, None, turn, T[:3, 3], 0.4, 2)  # of the pallet: x red, y green, z blue
out.mkdir(parents=True, exist_ok=True)
cv2.imwrite(str(out / "09_own_rgbd_frame.png"), picture)
