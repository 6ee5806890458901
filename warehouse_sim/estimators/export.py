"""Trained networks as ONNX files, for programs without torch: inputs and outputs are plain tensors."""

import json
import logging
import warnings
from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn

from warehouse_sim.errors import TrainingError
from warehouse_sim.estimators.detectors.yolov5.network import DetectorNetwork, DetectorRun
from warehouse_sim.estimators.images.encoding import CANONICAL_FOCAL_PX
from warehouse_sim.estimators.images.letterbox import Letterbox
from warehouse_sim.estimators.lidar.sweep.compose import MARGIN
from warehouse_sim.estimators.lidar.sweep.network import SweepNetwork, SweepRun
from warehouse_sim.estimators.pose.densefusion.networks.densefusion import DenseFusion, PoseRun
from warehouse_sim.estimators.pose.densefusion.networks.interface import NetworkInput
from warehouse_sim.estimators.pose.densefusion.networks.rotations import matrix_from_quat_wxyz
from warehouse_sim.estimators.segmenters.segnet.network import SegmenterNetwork, SegmenterRun
from warehouse_sim.learning.run_folder import RunConfig, read_kind
from warehouse_sim.optional import require
from warehouse_sim.output import make_folder, write_bytes

Inputs = dict[str, Tensor]


class Portable(nn.Module, ABC):
    """A network that takes tensors by name and returns a tuple of them.

    Args:
        config: What defines the network.
        network: The network, trained.
    """

    tolerance: float
    """Largest difference from torch that is accepted."""

    def __init__(self, config: RunConfig, network: nn.Module) -> None:
        super().__init__()
        self.config, self.network = config, network

    @property
    @abstractmethod
    def outputs(self) -> tuple[str, ...]:
        """Names of what it returns."""

    @abstractmethod
    def random_inputs(self, batch: int, seed: int = 0) -> Inputs:
        """Return random inputs, of the shapes and ranges that real ones have."""

    @abstractmethod
    def metadata(self) -> dict[str, str]:
        """Return what is needed to prepare inputs and to read outputs."""


class PortableDetector(Portable):
    """A detector: canvas in, boxes and scores of all cells out, before suppression."""

    config: DetectorRun
    network: DetectorNetwork
    outputs = ("boxes", "scores")
    """Edges on the canvas (b n 4, px) and the score of each class (b n c, 0-1)."""
    tolerance = 5e-2
    """In pixels and scores."""

    def forward(self, rgb: Tensor | None = None, depth: Tensor | None = None) -> tuple[Tensor, Tensor]:
        """Return what ``outputs`` names, of uint8 (b h w 3) and canonical metres (b h w)."""
        return self.network.decode(self.network(rgb, depth))

    def random_inputs(self, batch: int, seed: int = 0) -> Inputs:
        """Return images of the shape of ``input_wh``."""
        generator = torch.Generator().manual_seed(seed)
        inputs = _colours(self.config.images.reads, batch, self._size_wh(), generator)
        if "depth" in self.config.images.reads:
            width, height = self._size_wh()
            inputs["depth"] = 20.0 * torch.rand((batch, height, width), generator=generator)
        return inputs

    def metadata(self) -> dict[str, str]:
        """Return classes, and how images become what is read."""
        return {
            "detector": self.config.estimator,
            "classes": json.dumps(self.config.classes),
            "size_wh": json.dumps(self._size_wh()),
            "depth": f"metres times {CANONICAL_FOCAL_PX:g} over the focal length on the canvas (px), 0 = no reading",
            "layout": "the image scaled evenly into the upper left of the canvas; boxes are edges on the canvas (px)",
        }

    def _size_wh(self) -> tuple[int, int]:
        return Letterbox.fit(self.config.images.input_wh, self.config.images.input_wh).size_wh


class PortableSegmenter(Portable):
    """A segmenter: crops of boxes in, a probability for each pixel and maps of key points out."""

    config: SegmenterRun
    network: SegmenterNetwork
    tolerance = 1e-3
    """In probabilities and logits."""

    @property
    def outputs(self) -> tuple[str, ...]:
        """Probability of each pixel (b h w), logits of key points (b p h w), likelihoods of kinds (b k)."""
        config = self.config.network
        return "mask", *(("points",) if config.keypoints else ()), *(("kinds",) if config.kinds else ())

    def forward(self, width_rad: Tensor, rgb: Tensor | None = None, depth: Tensor | None = None) -> tuple[Tensor, ...]:
        """Return what ``outputs`` names."""
        mask, points, kinds = self.network(rgb, depth, width_rad)
        config = self.network.config
        more = ((points,) if config.keypoints else ()) + ((torch.softmax(kinds, dim=1),) if config.kinds else ())
        return torch.sigmoid(mask), *more

    def random_inputs(self, batch: int, seed: int = 0) -> Inputs:
        """Return crops, and how wide they are seen."""
        generator = torch.Generator().manual_seed(seed)
        reads, (width, height) = self.config.network.reads, self.config.crop.crop_wh
        inputs: Inputs = {"width_rad": 0.1 + 0.3 * torch.rand(batch, generator=generator)}
        inputs |= _colours(reads, batch, (width, height), generator)
        if "depth" in reads:
            inputs["depth"] = 2.0 + 2.0 * torch.rand((batch, height, width), generator=generator)
        return inputs

    def metadata(self) -> dict[str, str]:
        """Return how boxes become crops."""
        return {
            "segmenter": self.config.estimator,
            "crop_wh": json.dumps(self.config.crop.crop_wh),
            "margin": str(self.config.crop.margin),
            "kinds": json.dumps(self.config.network.kinds),
            "width_rad": "width of the crop (px of the image) over the focal length (px)",
        }


class PortableSweepDetector(Portable):
    """A detector of sweeps: whole turns with a margin at both ends in, boxes before suppression and pixels out."""

    config: SweepRun
    network: SweepNetwork
    outputs = ("boxes", "scores", "pixels")
    """Edges on the image with its margins (b n 4, px), the score of each class (b n c, 0-1), whether each pixel shows
    an object (b h w, 0-1)."""
    tolerance = 5e-2
    """In pixels and scores."""

    def forward(self, range_m: Tensor, height_m: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Return what ``outputs`` names, of ranges (b h w, m, 0 = no reading) and heights (b h w, m, NaN = unknown)."""
        raw = self.network(None, torch.stack([range_m, height_m], dim=1))
        boxes, scores = self.network.decode(raw)
        return boxes, scores, torch.sigmoid(raw.pixels)

    def random_inputs(self, batch: int, seed: int = 0) -> Inputs:
        """Return turns."""
        generator = torch.Generator().manual_seed(seed)
        shape = batch, self.config.images.rows, self.config.images.columns + 2 * MARGIN
        height = 4.0 * torch.rand(shape, generator=generator) - 0.5
        height[:, :, ::7] = np.nan
        return {"range_m": 30.0 * torch.rand(shape, generator=generator), "height_m": height}

    def metadata(self) -> dict[str, str]:
        """Return classes, and how sweeps become what is read."""
        images, (low, high) = self.config.images, self.config.images.elevation_deg
        return {
            "detector": self.config.estimator,
            "classes": json.dumps(self.config.classes),
            "size_wh": json.dumps([images.columns + 2 * MARGIN, images.rows]),
            "columns": f"{images.columns} of a turn, azimuth falling from 180 deg, ahead in the middle; "
            f"{MARGIN} of the other end are repeated before the first and after the last",
            "rows": f"elevation falling from {high:g} to {low:g} deg",
            "range_m": "nearest reading of a pixel, 0 = none",
            "height_m": "of that reading above the floor, NaN = unknown",
        }


class PortableNetwork(Portable):
    """A network of poses: proposals and one pass of its refiner, if any; lengths as those of ``NetworkInput``."""

    config: PoseRun
    network: DenseFusion
    outputs = ("rotations", "translations", "confidences", "rotation", "translation")
    """Proposals (b m 3 3), (b m 3), (b m), and the most confident one (b 3 3), (b 3) after the pass."""
    tolerance = 1e-4
    """In rotation matrices, confidences and half diameters."""

    def forward(
        self,
        points: Tensor,
        pixel: Tensor,
        class_index: Tensor,
        rgb: Tensor | None = None,
        depth: Tensor | None = None,
        inside: Tensor | None = None,
        level: Tensor | None = None,
    ) -> tuple[Tensor, ...]:
        """Return what ``outputs`` names."""
        inputs = NetworkInput(points, pixel, class_index, rgb, depth, inside, level)
        embedding = self.network.embed(inputs)
        proposal = self.network.propose(inputs, embedding)
        found = proposal.hypotheses
        rotation, translation = self.network.refine(*found.most_confident(), inputs, embedding, proposal)
        rotations = matrix_from_quat_wxyz(found.quat_wxyz)
        return rotations, found.translation, torch.sigmoid(found.logit), rotation, translation

    def random_inputs(self, batch: int, seed: int = 0) -> Inputs:
        """Return points of some objects, and what else the network reads of them."""
        generator = torch.Generator().manual_seed(seed)
        network, side = self.config.network, self.config.network.side_px or 1
        count = network.points.count
        inputs = {
            "points": torch.randn((batch, count, 3), generator=generator) * 0.4,
            "pixel": torch.randint(0, side**2, (batch, count), generator=generator),
            "class_index": torch.randint(0, len(self.config.objects), (batch,), generator=generator),
        }
        inputs |= _colours(("rgb",) if network.reads_rgb else (), batch, (side, side), generator)
        if network.reads_depth:
            ahead = torch.randn((batch, side, side), generator=generator).clamp(-3.0, 3.0)
            reading = torch.rand((batch, side, side), generator=generator) < 0.9
            inputs["depth"] = torch.stack([ahead * reading, reading.float()], dim=-1)
        if network.inliers is not None:
            inputs["inside"] = (torch.rand((batch, count), generator=generator) < 0.75).float()
        if network.upright:
            inputs["level"] = (torch.rand(batch, generator=generator) < 0.7).float()
        return inputs

    def metadata(self) -> dict[str, str]:
        """Return the objects in the order of the classes with their diameters (m), and what is read of each."""
        known = self.config.objects
        objects = [{"obj_id": item.obj_id, "name": item.name, "diameter": item.diameter} for item in known]
        return {
            "estimator": self.config.estimator,
            "objects": json.dumps(objects),
            "points": str(self.config.network.points.count),
            "side_px": str(self.config.network.side_px or 0),
            "units": "lengths about the median point, in half diameters of the object",
        }


_KINDS: dict[str, tuple[type[RunConfig], type[Portable]]] = {
    "detector": (DetectorRun, PortableDetector),
    "segmenter": (SegmenterRun, PortableSegmenter),
    "sweep-detector": (SweepRun, PortableSweepDetector),
}
"""What is exported of the run folders of each kind; of others it is a network of poses."""


def export_run(run: Path, out: Path) -> float:
    """Write the network of a run folder with a free batch axis, and return the largest difference from torch.

    Args:
        run: Run folder, or folder of a bundled model.
        out: File to write.

    Raises:
        MissingPackageError: onnx, onnxscript, or onnxruntime is not installed.
        TrainingError: The folder holds no complete run, or the file does not compute what torch computes.
    """
    opens, portable = _KINDS.get(read_kind(run), (PoseRun, PortableNetwork))
    config = opens.read(run)
    return export_network(portable(config, config.load_network(run)).eval(), out)


def _colours(reads: Sequence[str], batch: int, size_wh: tuple[int, int], generator: torch.Generator) -> Inputs:
    """Return random colours where they are read."""
    shape = batch, size_wh[1], size_wh[0], 3
    return {"rgb": torch.randint(0, 256, shape, generator=generator, dtype=torch.uint8)} if "rgb" in reads else {}


def export_network(network: Portable, out: Path) -> float:
    """Write a network with a free batch axis, compare the file with torch, and return the largest difference.

    Raises:
        MissingPackageError: onnx, onnxscript or onnxruntime is not installed.
        TrainingError: The file does not compute what torch computes; nothing is written.
    """
    onnx, onnxruntime = (require(name, "export", "to export a network") for name in ("onnx", "onnxruntime"))
    require("onnxscript", "export", "to export a network")
    # Not of one length: the first batch is traced, the second compared.
    example, other = network.random_inputs(2), network.random_inputs(3)
    free = {name: {0: torch.export.Dim("batch")} for name in example}
    with torch.no_grad(), _quiet():
        # Strict: the other way of tracing takes the length of a batch for a constant.
        traced = torch.export.export(network, (), kwargs=example, dynamic_shapes=free, strict=True)
        program = torch.onnx.export(
            traced, input_names=list(example), output_names=network.outputs, dynamo=True, verbose=False
        )
    assert program is not None
    model = program.model_proto
    onnx.helper.set_model_props(model, network.metadata())
    session = onnxruntime.InferenceSession(model.SerializeToString(), providers=["CPUExecutionProvider"])
    difference = _difference(network, session, other)
    if not difference <= network.tolerance:
        raise TrainingError(f"{out}: the exported network differs from torch by {difference:.1e}; nothing was written")
    make_folder(out.parent)
    write_bytes(out, model.SerializeToString())
    return difference


def _difference(network: nn.Module, session: Any, inputs: Inputs) -> float:
    known = {item.name for item in session.get_inputs()}
    found = session.run(None, {name: value.numpy() for name, value in inputs.items() if name in known})
    with torch.no_grad():
        expected = network(**inputs)
    return max(float((torch.from_numpy(a) - b).abs().max()) for a, b in zip(found, expected, strict=True))


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep back what the exporter says of packages that are not installed and of its own future."""
    logger = logging.getLogger("torch.onnx")
    level = logger.level
    logger.setLevel(logging.ERROR)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        logger.setLevel(level)
