"""The training of an RT-DETR: its loss, step and job, and weights that it begins with, such as published ones.

The loss is the library's, with boxes of which nothing is learnt: neither that they are there nor that they are not.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import safetensors
import safetensors.torch
import torch
from jaxtyping import Bool, Float
from torch import Tensor

from warehouse_sim.errors import TrainingError
from warehouse_sim.estimators.detectors.boxes import BoxRun
from warehouse_sim.estimators.detectors.preparation import Prepared
from warehouse_sim.estimators.detectors.rtdetr.network import (
    EXTRA,
    PURPOSE,
    RTDETR_DETECT,
    SIZES,
    Found,
    RtdetrNetwork,
    RtdetrNetworkConfig,
    RtdetrRun,
)
from warehouse_sim.estimators.detectors.rtdetr.settings import RtdetrConfig
from warehouse_sim.estimators.detectors.task import BoxJob, BoxTask, Groups, ImageBoxTask, ImageOrder, Inputs
from warehouse_sim.estimators.detectors.yolov5.anchors import Targets
from warehouse_sim.learning.compute import on_device
from warehouse_sim.learning.job import Started, starting_weights
from warehouse_sim.learning.records import RunLog
from warehouse_sim.learning.run_folder import WEIGHTS, Source, read_weights
from warehouse_sim.learning.samples.array_store import Arrays
from warehouse_sim.optional import require
from warehouse_sim.resources import model_dir

_COVERED = 0.5
"""Fraction of a box that lies in one of which nothing is learnt, from which on it may be that one."""
_NEVER = -30.0
"""Logit that teaches nothing where nothing is to be found."""
Labels = list[dict[str, Tensor]]
"""Of each image ``class_labels`` (k), ``boxes`` (k 4) and ``ignored`` (n 4); centre and size, fractions of the
canvas."""
Loss = Callable[[Found, Labels], Float[Tensor, ""]]


_WEIGHTS = {"loss_vfl": 1.0, "loss_bbox": 5.0, "loss_giou": 2.0}
"""Of varifocal loss, of differences of centres and sizes, and of 1 - GIoU: the library's own."""


def make_loss(library_config: Any) -> Loss:
    """Return what gives the loss of a batch: that of the last layer, of those before it, and of denoised boxes.

    Zhao et al., "DETRs beat YOLOs on real-time object detection", CVPR 2024. The library's own function lets the
    boxes that are to be denoised compete for the targets of the last layer, where they always win; here they do not.

    Raises:
        MissingPackageError: The library is not installed.
    """
    criterion = _criterion(library_config)
    criterion.weight_dict = _WEIGHTS

    def loss(found: Found, labels: Labels) -> Float[Tensor, ""]:
        parts: dict[str, Tensor] = criterion(_by_layer(found), labels)
        return torch.stack(list(parts.values())).sum()

    return loss


def _by_layer(found: Found) -> dict[str, Any]:
    """Return the output of each layer as the library's criterion wants it; boxes to be denoised come first."""
    groups: Any = found.denoising
    start = groups["dn_num_split"][0] if groups else 0
    layers = [_pair(logits[:, start:], boxes[:, start:]) for logits, boxes in found.layers]
    outputs: dict[str, Any] = {**layers[-1], "auxiliary_outputs": [*layers[:-1], _pair(*found.first)]}
    if groups:
        outputs["dn_auxiliary_outputs"] = [_pair(logits[:, :start], boxes[:, :start]) for logits, boxes in found.layers]
        outputs["denoising_meta_values"] = groups
    return outputs


def _pair(logits: Tensor, boxes: Tensor) -> dict[str, Tensor]:
    return {"logits": logits, "pred_boxes": boxes}


def _criterion(library_config: Any) -> Any:
    module = require("transformers.loss.loss_rt_detr", EXTRA, PURPOSE)

    class Matcher(module.RTDetrHungarianMatcher):
        """The library's, which cannot take a batch without any target."""

        def forward(self, outputs: Any, targets: Labels) -> list[tuple[Tensor, Tensor]]:
            if any(len(target["boxes"]) for target in targets):
                found: list[tuple[Tensor, Tensor]] = super().forward(outputs, targets)
                return found
            return [(torch.zeros(0, dtype=torch.int64), torch.zeros(0, dtype=torch.int64)) for _ in targets]

    class Criterion(module.RTDetrLoss):
        """The library's, but for boxes of which nothing is learnt."""

        def __init__(self, config: Any) -> None:
            super().__init__(config)
            self.matcher = Matcher(config)

        def loss_labels_vfl(self, outputs: Any, targets: Labels, indices: Any, *more: Any, **named: Any) -> Any:
            boxes = outputs["pred_boxes"].detach()
            free = torch.stack([covered(mine, them["ignored"]) for mine, them in zip(boxes, targets, strict=True)])
            free[self._get_source_permutation_idx(indices)] = False
            logits = outputs["logits"].masked_fill(free[..., None], _NEVER)
            return super().loss_labels_vfl({**outputs, "logits": logits}, targets, indices, *more, **named)

    return Criterion(library_config)


def covered(boxes: Float[Tensor, "n 4"], others: Float[Tensor, "k 4"]) -> Bool[Tensor, " n"]:
    """Return which boxes (centre and size) lie at least half in one of the others."""
    if not len(others):
        return torch.zeros(len(boxes), dtype=torch.bool, device=boxes.device)
    low, high = boxes[:, None, :2] - boxes[:, None, 2:] / 2, boxes[:, None, :2] + boxes[:, None, 2:] / 2
    other_low, other_high = others[:, :2] - others[:, 2:] / 2, others[:, :2] + others[:, 2:] / 2
    shared = (torch.minimum(high, other_high) - torch.maximum(low, other_low)).clamp(min=0).prod(dim=2)
    fraction = shared / boxes[:, None, 2:].prod(dim=2).clamp(min=1e-9)
    return (fraction >= _COVERED).any(dim=1)


LIBRARY_WEIGHTS = "model.safetensors"
_NAMED = 4
"""Tensors that stay fresh and are named."""


def start_from(init: str | Path, network: RtdetrNetwork) -> tuple[Source, str]:
    """Copy all weights that the network has, too, in the same shape; return what they were, and a line about it.

    Args:
        init: Bundled name or run folder, a folder that the library's ``save_pretrained`` wrote, or a safetensors file
            with its names.
        network: What begins; weights for other classes or inputs stay fresh.

    Raises:
        UnknownNameError: None of these.
        TrainingError: There are no weights, they cannot be read, or fewer than half of the network's are there.
    """
    path = Path(init)
    if path.is_file():
        file, given = path, _library_weights(path, network)
    elif (path / LIBRARY_WEIGHTS).is_file():
        file = path / LIBRARY_WEIGHTS
        given = _library_weights(file, network)
    else:
        folder = model_dir(init)
        file, given = folder / WEIGHTS, read_weights(folder)
    # Counters of batches are no weights.
    own = {name: value for name, value in network.state_dict().items() if not name.endswith("num_batches_tracked")}
    fitting = {name: given[name] for name, value in own.items() if name in given and given[name].shape == value.shape}
    if len(fitting) < len(own) / 2:
        raise TrainingError(f"{file} fits {len(fitting)} of {len(own)} tensors of the network; begin afresh")
    with torch.no_grad():
        network.load_state_dict(network.state_dict() | fitting)
    fresh = [name for name in own if name not in fitting]
    remark = f"{len(fitting)} of {len(own)} tensors from {file}"
    if fresh:
        more = f" and {len(fresh) - _NAMED} more" if len(fresh) > _NAMED else ""
        remark += f"; fresh: {', '.join(fresh[:_NAMED])}{more}"
    return starting_weights(init, file), remark


def _library_weights(file: Path, network: RtdetrNetwork) -> Mapping[str, Tensor]:
    """Return the tensors of a file of the library under the names of this version of it; published files have older."""
    if file.suffix != ".safetensors":
        raise TrainingError(f"{file}: weights are read from safetensors files only; convert it, pickles run any code")
    try:
        tensors = safetensors.torch.load_file(file)
    except (safetensors.SafetensorError, OSError) as problem:
        raise TrainingError(f"{file} cannot be read: {' '.join(str(problem).split())}") from problem
    library: Any = require("transformers", EXTRA, PURPOSE)
    with _quiet():
        loaded, report = library.RTDetrV2ForObjectDetection.from_pretrained(
            None,
            config=network.model.config,
            state_dict=tensors,
            ignore_mismatched_sizes=True,
            output_loading_info=True,
        )
    absent = {*report["missing_keys"], *(item[0] for item in report["mismatched_keys"])}
    return {name: value for name, value in loaded.state_dict().items() if name not in absent}


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep back the library's own report and bar; one line says it here."""
    logging = require("transformers.utils.logging", EXTRA, PURPOSE)
    level, has_bar = logging.get_verbosity(), logging.is_progress_bar_enabled()
    logging.set_verbosity_error()
    logging.disable_progress_bar()
    try:
        yield
    finally:
        logging.set_verbosity(level)
        if has_bar:
            logging.enable_progress_bar()


class RtdetrTask(ImageBoxTask):
    """Train an RT-DETR; see ``BoxTask`` for the arguments."""

    network: RtdetrNetwork
    max_overlap = RTDETR_DETECT.max_overlap

    def __init__(
        self,
        network: RtdetrNetwork,
        config: RtdetrConfig,
        train: Groups,
        val: Sequence[Arrays],
        class_of: dict[int, int],
        order: ImageOrder,
    ) -> None:
        super().__init__(network, config, train, val, class_of, order)
        self._loss = make_loss(network.model.config)

    def loss(self, inputs: Inputs, targets: Targets) -> Float[Tensor, ""]:
        """Return the weighted sum over all layers."""
        rgb, depth = inputs
        image = depth if rgb is None else rgb
        assert image is not None
        labels = [
            {name: on_device(value, image.device) for name, value in of_image.items()}
            for of_image in as_labels(targets, len(image), (image.shape[2], image.shape[1]))
        ]
        found = self.network(rgb, depth, labels)
        with torch.autocast(image.device.type, enabled=False):
            return self._loss(found, labels)


def as_labels(targets: Targets, images: int, size_wh: tuple[int, int]) -> Labels:
    """Return the targets of each image on a canvas of ``size_wh`` (px) as the library wants them."""
    centre, size = (targets.boxes[:, :2] + targets.boxes[:, 2:]) / 2, targets.boxes[:, 2:] - targets.boxes[:, :2]
    boxes = torch.cat([centre, size], dim=1) / targets.boxes.new_tensor(size_wh * 2)
    labels: Labels = []
    for number in range(images):
        mine = targets.image == number
        requested, ignored = mine & targets.wanted, mine & ~targets.wanted
        labels.append({
            "class_labels": targets.class_index[requested], "boxes": boxes[requested], "ignored": boxes[ignored],
        })  # fmt: skip
    return labels


@dataclass(frozen=True)
class RtdetrJob(BoxJob):
    """A training of an RT-DETR."""

    config: RtdetrConfig

    run_config: ClassVar[type[BoxRun]] = RtdetrRun
    task: ClassVar[type[BoxTask]] = RtdetrTask

    @property
    def is_small(self) -> bool:
        """Whether the network gains little from several threads."""
        return self.config.size == "tiny"

    def sizes(self, prepared: Prepared) -> RtdetrNetworkConfig:
        """Return the widths of the size, for the classes."""
        return RtdetrNetworkConfig(**SIZES[self.config.size], classes=len(prepared.classes))

    def begin_with(self, init: str | Path, started: Started, log: RunLog) -> Source:
        """Copy weights of another run, or of the library, and say how many fitted."""
        assert isinstance(started.task, RtdetrTask)
        begun, remark = start_from(init, started.task.network)
        log.note(remark)
        return begun
