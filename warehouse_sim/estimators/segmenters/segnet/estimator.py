"""A trained segmenter: boxes in, masks with a probability for each pixel out; key points where it knows them."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import torch
from jaxtyping import Bool, Float, Float32
from torch import Tensor

from warehouse_sim.estimators.api import Segmenter
from warehouse_sim.estimators.image import Detection, RgbdImage, require_rgb
from warehouse_sim.estimators.segmenters.segnet.keypoints import Peaks, find_peaks
from warehouse_sim.estimators.segmenters.segnet.network import Said, SegmenterRun
from warehouse_sim.estimators.segmenters.segnet.window import Edges, Window
from warehouse_sim.geometry.boxes import mask_box_xyxy, mask_intersections
from warehouse_sim.learning.compute import cpu_threads, place

_BOXES_AT_ONCE = 64
_LEAST_PROBABILITY = 0.5
"""Of the pixels of a mask."""
_MOST_ALIKE = 0.7
"""Intersection over union of two masks beyond which they are of one object."""
_LEAST_PIXELS = 8
"""Masks of fewer pixels are left out."""


@dataclass(frozen=True, eq=False)
class SeenBoxes:
    """What the network says of some boxes of an image."""

    windows: tuple[Window, ...]
    probability: Float32[np.ndarray, "b h w"]
    """Of the pixels of the crops, 0-1."""
    peaks: Peaks | None
    """Key points on the crops, for networks that find them."""
    kinds: Float32[np.ndarray, "b k"]
    """How likely each kind is, 0-1, for networks that tell them apart."""

    def points(self, index: int) -> tuple[Float[np.ndarray, "k 2"], Float[np.ndarray, " k"]]:
        """Return key points in the image (px), and how likely each is."""
        assert self.peaks is not None
        return self.windows[index].to_image(self.peaks.uv[index]), self.peaks.chance[index]


class TrainedSegmenter(Segmenter):
    """The segmenter of a run folder.

    Args:
        run: Run folder, or folder of a bundled model.

    Raises:
        TrainingError: The folder holds no complete run of a segmenter.
    """

    needs_detections = True
    """It segments the objects in boxes and needs a detector."""

    def __init__(self, run: Path) -> None:
        self.run_config = SegmenterRun.read(run)
        self._network = self.run_config.load_network(run)
        self._device, self._threads = place(self._network, "auto", None)

    @property
    def reads_rgb(self) -> bool:
        """Whether images need colour."""
        return "rgb" in self.run_config.network.reads

    @property
    def reads_depth(self) -> bool:
        """Whether images need depth."""
        return "depth" in self.run_config.network.reads

    def segment(self, image: RgbdImage) -> list[Detection]:
        """Return the image's detections with masks; nothing of an image without any.

        After another segmenter it looks once, where that one's masks are; then a mask is the mean of both, and so are
        the logarithms of kinds.

        Raises:
            InputError: The image lacks colour, which the segmenter reads.
        """
        found = list(image.detections)
        if not found:
            return []
        size_wh = image.camera.width, image.camera.height
        sure = [_sureness(item) for item in found]
        follows = all(sure)
        boxes = [detection_edges(replace(item, box_xyxy=None) if follows else item) for item in found]
        if not follows:
            first = self.look(image, boxes)
            # A detector's box may be off: the network looks again where its first mask says that the object is.
            boxes = [
                mask_edges(window.pasted(crop, size_wh) >= _LEAST_PROBABILITY) or box
                for box, window, crop in zip(boxes, first.windows, first.probability, strict=True)
            ]
        seen = self.look(image, boxes)
        names = self.run_config.network.kinds
        segmented = list[Detection]()
        for number, item in enumerate(found):
            chance, score = seen.windows[number].pasted(seen.probability[number], size_wh), item.score
            likely = dict(zip(names, seen.kinds[number].tolist(), strict=True))
            if follows:
                assert item.mask_probability is not None
                score /= sure[number]
                chance = (chance + item.mask_probability) / 2.0
                likely = agreed(likely, item.kind_likelihood)
            mask, likely = chance >= _LEAST_PROBABILITY, likely or dict(item.kind_likelihood)
            if mask.sum() >= _LEAST_PIXELS:
                score *= float(chance[mask].mean())
                segmented.append(replace(item, mask=mask, mask_probability=chance, score=score, kind_likelihood=likely))
        return without_doubles(segmented)

    @torch.inference_mode()
    def look(self, image: RgbdImage, boxes: Sequence[Edges]) -> SeenBoxes:
        """Return what the network says of boxes of edges (px): the mean of what it says of each and of its mirror.

        Key points are those of the box itself.

        Raises:
            InputError: The image lacks colour, which the segmenter reads.
        """
        if self.reads_rgb:
            require_rgb(image, self.run_config.estimator)
        crop = self.run_config.crop
        windows = tuple(Window.about(box, crop.margin, crop.crop_wh) for box in boxes)
        chances, peaks, kinds = list[Tensor](), list[Peaks](), list[Tensor]()
        with cpu_threads(self._threads):
            for start in range(0, len(windows), _BOXES_AT_ONCE):
                rgb, depth, width = self._tensors(image, windows[start : start + _BOXES_AT_ONCE])
                said: Said = self._network(rgb, depth, width)
                mirrored: Said = self._network(
                    None if rgb is None else rgb.flip(2), None if depth is None else depth.flip(2), width
                )
                mask = torch.sigmoid(said.mask.float()) + torch.sigmoid(mirrored.mask.float()).flip(2)
                chances.append((mask / 2.0).cpu())
                likely = [item.kinds.float().log_softmax(dim=1) for item in (said, mirrored)]
                kinds.append(torch.softmax((likely[0] + likely[1]) / 2.0, dim=1).cpu())
                if said.places.shape[1]:
                    peaks.append(find_peaks(said.places.float()))
        found = Peaks(*(np.concatenate(parts) for parts in zip(*peaks, strict=True))) if peaks else None
        return SeenBoxes(windows, torch.cat(chances).numpy(), found, torch.cat(kinds).numpy())

    def _tensors(self, image: RgbdImage, windows: Sequence[Window]) -> tuple[Tensor | None, Tensor | None, Tensor]:
        reads = self.run_config.network.reads
        rgb = depth = None
        if "rgb" in reads:
            assert image.rgb is not None
            rgb = torch.from_numpy(np.stack([window.smooth(image.rgb) for window in windows])).to(self._device)
        if "depth" in reads:
            depth = torch.from_numpy(np.stack([window.picked(image.depth) for window in windows])).to(self._device)
        width = [(window.edges[2] - window.edges[0]) / image.camera.fx for window in windows]
        return rgb, depth, torch.tensor(width, dtype=torch.float32, device=self._device)


def _sureness(item: Detection) -> float:
    """Return the mean probability of the pixels of a mask, which is part of its score; 0 where no segmenter said it."""
    if item.mask is None or item.mask_probability is None:
        return 0.0
    mask = np.asarray(item.mask, dtype=bool)
    return float(item.mask_probability[mask].mean()) if mask.any() else 0.0


def agreed(likely: Mapping[str, float], others: Mapping[str, float]) -> dict[str, float]:
    """Return how likely each kind is by two who say so: the mean of logarithms, of kinds that both know.

    Where they know none in common, the first is believed.
    """
    root = {name: math.sqrt(chance * others[name]) for name, chance in likely.items() if name in others}
    total = sum(root.values())
    return {name: value / total for name, value in root.items()} if total > 0.0 else dict(likely)


def without_doubles(found: Sequence[Detection]) -> list[Detection]:
    """Return detections with masks but for those that are almost the mask of a better one, in the order given.

    Masks of neighbours may share pixels: of two in a stack, the one whose box is off would take the other's.
    """
    if not found:
        return []
    masks = np.stack([np.asarray(item.mask, dtype=bool) for item in found])
    size = masks.sum(axis=(1, 2))
    shared = mask_intersections(masks, masks)
    alike = shared > _MOST_ALIKE * (size[:, None] + size - shared)
    kept = list[int]()
    for number in np.argsort([-item.score for item in found], kind="stable").tolist():
        if not alike[number, kept].any():
            kept.append(number)
    return [found[number] for number in sorted(kept)]


def detection_edges(item: Detection) -> Edges:
    """Return the box of edges (px) of a detection."""
    if item.box_xyxy is not None:
        left, top, right, bottom = item.box_xyxy
        return left + 0.5, top + 0.5, right + 0.5, bottom + 0.5
    assert item.mask is not None
    return mask_edges(np.asarray(item.mask, dtype=bool)) or (0.0, 0.0, 1.0, 1.0)


def mask_edges(mask: Bool[np.ndarray, "h w"]) -> Edges | None:
    """Return the box of edges (px) of a mask; None of an empty one."""
    box = mask_box_xyxy(mask)
    return box and (float(box[0]), float(box[1]), box[2] + 1.0, box[3] + 1.0)
