"""A trained detector: images in, boxes with classes and scores out."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
import torch

from warehouse_sim.estimators.api import Detector
from warehouse_sim.estimators.detectors.boxes import Kept, fuse, suppress, voted
from warehouse_sim.estimators.detectors.yolov5.network import DetectorNetwork, DetectorRun
from warehouse_sim.estimators.image import Detection, RgbdImage, require_rgb
from warehouse_sim.estimators.images.letterbox import Letterbox
from warehouse_sim.estimators.images.rows import canonical_mm
from warehouse_sim.estimators.images.settings import DepthSource
from warehouse_sim.learning.compute import cpu_threads, place
from warehouse_sim.ranges import Fraction, Range, ranged

MOST_DETECTIONS = 300
"""Of an image."""
_SMALL, _LARGE = 1.0, 1.5
"""Sizes at which an image is looked at, over the one trained with. The second places edges of small things better."""
_LOOKS = ((_SMALL, False), (_LARGE, True))
"""How a network of depth looks at an image: the size, and whether at its mirror image."""
_LOOKS_AT_COLOUR = ((_SMALL, False), (_LARGE, False), (_SMALL, True), (_LARGE, True))
"""How one of colour alone does, which is less sure of edges."""
_SAME_PLACE = 0.7
"""Intersection over union from which on boxes of colour alone are of one place."""


@dataclass(frozen=True)
@ranged
class DetectConfig:
    """What counts as found."""

    min_score: Fraction = 0.17
    """Detections of lower scores are left out, 0-1; of an image the mean of its looks, of which some may miss."""
    max_overlap: Fraction = 0.6
    """Intersection over union with a better one of the same class from which on a detection is left out, 0-1."""
    device: Literal["auto", "cpu", "cuda"] = "auto"
    """Where the network runs; auto takes a GPU if there is one."""
    threads: Annotated[int, Range(1, 1024)] | None = None
    """Processor threads of the network, 1-1,024; by default torch's own number, one for the smallest."""


class TrainedDetector(Detector):
    """The detector of a run folder.

    Args:
        run: Run folder, or folder of a bundled model.
        config: What counts as found.

    Raises:
        TrainingError: The folder holds no complete run of a detector.
    """

    def __init__(self, run: Path, config: DetectConfig = DetectConfig()) -> None:
        self.run_config, self.config = DetectorRun.read(run), config
        self._network: DetectorNetwork = self.run_config.load_network(run)
        self._device, self._threads = place(self._network, config.device, config.threads)

    def leave_out_below(self, min_score: float) -> None:
        """Leave out from now on what is found with a score below ``min_score`` (0-1)."""
        self.config = replace(self.config, min_score=min_score)

    @property
    def classes(self) -> tuple[str, ...]:
        """The classes that it distinguishes."""
        return self.run_config.classes

    @property
    def depth_source(self) -> DepthSource:
        """Whose depth it was trained with."""
        return self.run_config.images.depth_source

    @property
    def reads_rgb(self) -> bool:
        """Whether images need colour."""
        return "rgb" in self.run_config.images.reads

    @property
    def reads_depth(self) -> bool:
        """Whether images need depth."""
        return "depth" in self.run_config.images.reads

    @torch.inference_mode()
    def detect(self, image: RgbdImage) -> list[Detection]:
        """Return what is found, the best first.

        Raises:
            InputError: The image lacks colour, which the detector reads.
        """
        if self.reads_rgb:
            require_rgb(image, self.run_config.estimator)
        looks = _LOOKS if self.reads_depth else _LOOKS_AT_COLOUR
        least = self.config.min_score / len(looks)
        seen = [self._look(image, size, mirrored, least) for size, mirrored in looks]
        found = fuse(seen, self.config.min_score, self.config.max_overlap)
        by_object = self.run_config.train.labels == "object"
        # Pixel centres are integers: an edge is half a pixel beyond the centre of the outermost pixel.
        return [
            Detection(
                model=self.classes[number] if by_object else None,
                score=float(score),
                box_xyxy=(left - 0.5, top - 0.5, right - 0.5, bottom - 0.5),
                class_name="" if by_object else self.classes[number],
            )
            for (left, top, right, bottom), score, number in zip(
                found.boxes.tolist(), found.scores, found.classes, strict=True
            )
            if right > left and bottom > top
        ]

    def _look(self, image: RgbdImage, size: float, mirrored: bool, least: float) -> Kept:
        """Return what is found at a multiple of the size that the network is trained with; edges of the image.

        What one look finds counts for all of them: a mean over them reaches the least score with ``least``.
        """
        width, height = self.run_config.images.input_wh
        box = Letterbox.fit((image.camera.width, image.camera.height), (round(width * size), round(height * size)))
        rgb = depth = None
        if image.rgb is not None and self.reads_rgb:
            rgb = torch.from_numpy(box.smooth(image.rgb))[None].to(self._device)
        if self.reads_depth:
            steps = canonical_mm(box.picked(image.depth), box.focal_px(image.camera))
            depth = torch.from_numpy(steps.astype("float32") / 1000.0)[None].to(self._device)
        if mirrored:
            rgb, depth = (None if part is None else part.flip(2) for part in (rgb, depth))
        with cpu_threads(self._threads):
            all_boxes, all_scores = self._network.decode(self._network(rgb, depth))
        boxes, scores = all_boxes[0].cpu().double().numpy(), all_scores[0].cpu().double().numpy()
        if mirrored:
            boxes = np.column_stack(
                [box.size_wh[0] - boxes[:, 2], boxes[:, 1], box.size_wh[0] - boxes[:, 0], boxes[:, 3]]
            )
        sure = scores.max(axis=1) > least
        boxes, scores = boxes[sure], scores[sure]
        kept = suppress(boxes, scores, least, self.config.max_overlap, MOST_DETECTIONS)
        if not self.reads_depth:
            kept = voted(kept, boxes, scores, _SAME_PLACE)
        return kept._replace(boxes=box.off_canvas(kept.boxes))
