"""Draw what a detector on colour finds in photographs of no known camera; they are not part of this package.

python -m benchmarks.front_ends.photographs FOLDER --out DIR [--detector out/front_ends/runs/detector-rgb]
"""

from pathlib import Path

import cv2
import numpy as np
import tyro

from warehouse_sim.estimators.detectors.estimator import DetectConfig, TrainedDetector
from warehouse_sim.estimators.image import Detection, RgbdImage
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.resources import model_dir

_COLORS = {"pallet": (60, 230, 60), "person": (60, 60, 240), "forklift": (240, 140, 40)}
"""BGR."""


def find(detector: TrainedDetector, rgb: np.ndarray) -> list[Detection]:
    """Return what is found in a photograph; a detector on colour asks nothing of the camera."""
    height, width = rgb.shape[:2]
    camera = PinholeCamera.from_focal(width, height, float(max(width, height)))
    return detector.detect(RgbdImage(camera, np.zeros((height, width), dtype=np.float32), (), rgb))


def draw(bgr: np.ndarray, found: list[Detection]) -> np.ndarray:
    """Return a photograph with boxes, classes and scores."""
    canvas = bgr.copy()
    thick = max(2, round(max(canvas.shape) / 500))
    for item in found:
        assert item.box_xyxy is not None
        left, top, right, bottom = (round(edge) for edge in item.box_xyxy)
        color = _COLORS.get(item.class_name, (200, 200, 200))
        cv2.rectangle(canvas, (left, top), (right, bottom), color, thick)
        text = f"{item.class_name} {100 * item.score:.0f} %"
        cv2.putText(
            canvas, text, (left, max(16, top - 6)), cv2.FONT_HERSHEY_SIMPLEX, thick / 3.5, color, thick // 2 + 1
        )
    return canvas


def main(
    folder: tyro.conf.Positional[Path], out: Path, detector: str = "detector-rgb", least_score: float = 0.25
) -> None:
    """Look at all photographs of a folder, print what is found, and write pictures.

    Args:
        folder: Folder of JPEG or PNG files.
        out: Folder for the pictures.
        detector: Bundled detector on colour, or the run folder of one.
        least_score: Detections of lower scores are left out.
    """
    opened = TrainedDetector(model_dir(detector), DetectConfig(least_score=least_score))
    out.mkdir(parents=True, exist_ok=True)
    for path in sorted(item for item in folder.iterdir() if item.suffix.lower() in (".jpg", ".jpeg", ".png")):
        bgr = cv2.imread(str(path))
        found = find(opened, cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB))
        cv2.imwrite(str(out / f"{path.stem}.png"), draw(bgr, found))
        print(f"{path.name}: " + (", ".join(f"{x.class_name} {x.score:.2f}" for x in found) or "nothing"))


if __name__ == "__main__":
    tyro.cli(main)
