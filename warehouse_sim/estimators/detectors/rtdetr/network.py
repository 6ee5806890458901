"""The library's network with our channels before it and our boxes behind it."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

import torch
from jaxtyping import Float, UInt8
from torch import Tensor, nn

from warehouse_sim.estimators.detectors.boxes import BoxNetwork, BoxRun
from warehouse_sim.estimators.detectors.estimator import DetectConfig, TrainedDetector
from warehouse_sim.estimators.detectors.rtdetr.settings import RtdetrConfig, RtdetrSize
from warehouse_sim.estimators.images.encoding import channel_count, encode
from warehouse_sim.estimators.images.settings import ImageConfig
from warehouse_sim.optional import require, require_extra
from warehouse_sim.ranges import Range, ranged

EXTRA, PURPOSE = "detectors", "for RT-DETR"


@dataclass(frozen=True)
@ranged
class RtdetrNetworkConfig:
    """Sizes of an RT-DETR."""

    stages: Annotated[tuple[int, ...], Range(1, 1000)] = (2, 2, 2, 2)
    """Blocks of the backbone, a residual network, at strides 4, 8, 16, 32."""
    widths: Annotated[tuple[int, ...], Range(1, 100_000)] = (64, 128, 256, 512)
    """Channels of these."""
    stem: Annotated[int, Range(2, 100_000)] = 64
    """Channels before the first stage, even, 2-100,000."""
    block: Literal["basic", "bottleneck"] = "basic"
    """Kind of the blocks."""
    width: Annotated[int, Range(8, 100_000)] = 256
    """Channels of encoder and decoder, a multiple of 8, 8-100,000."""
    expansion: Annotated[float, Range(0.01, 10)] = 0.5
    """Factor on the encoder's fusion blocks, 0.01-10."""
    decoder_layers: Annotated[int, Range(1, 100)] = 3
    """Refinements of the boxes, 1-100."""
    queries: Annotated[int, Range(1, 10_000)] = 300
    """Boxes of an image, 1-10,000."""
    classes: Annotated[int, Range(1, 10_000)] = 1
    """Number of classes, 1-10,000."""

    def __post_init__(self) -> None:
        if not len(self.stages) == len(self.widths) == 4:
            raise ValueError(f"stages and widths must be four each, found {self.stages} and {self.widths}")


SIZES: Mapping[RtdetrSize, dict[str, Any]] = {
    "tiny": {
        "stages": (1, 1, 1, 1), "widths": (16, 32, 64, 96), "stem": 16, "width": 64,
        "decoder_layers": 2, "queries": 100,
    },
    "r18": {"decoder_layers": 3},
    "r34": {"stages": (3, 4, 6, 3), "decoder_layers": 4},
    "r50": {
        "stages": (3, 4, 6, 3), "widths": (256, 512, 1024, 2048), "block": "bottleneck", "expansion": 1.0,
        "decoder_layers": 6,
    },
}  # fmt: skip
"""The last three are as the library converts rtdetr_v2_r18vd, _r34vd and _r50vd, of 20, 31 and 42 million weights."""


Pair = tuple[Float[Tensor, "b q k"], Float[Tensor, "b q 4"]]
"""Logits of classes, and boxes: centre and size as fractions of the canvas."""


@dataclass(frozen=True, eq=False)
class Found:
    """What the layers of the decoder give."""

    layers: tuple[Pair, ...]
    """The last is the answer; in training each begins with the boxes that are to be denoised."""
    first: Pair
    """What the decoder began with."""
    size_wh: tuple[int, int]
    """Of the canvas (px)."""
    denoising: Any = None
    """What the library's loss must know of the boxes that are to be denoised."""


class RtdetrNetwork(BoxNetwork):
    """Detects in batches of images of one size.

    Args:
        config: Sizes.
        images: What is read.

    Raises:
        MissingPackageError: The library is not installed.
    """

    def __init__(self, config: RtdetrNetworkConfig, images: ImageConfig) -> None:
        super().__init__(config.classes)
        self.config, self.images = config, images
        # The heads of the decoder's layers are below the decoder, too; under two names no safetensors file takes them.
        self.model = make_detr(config, channel_count(images.reads)).model
        _begin_afresh(self.model)

    def forward(
        self,
        rgb: UInt8[Tensor, "b h w 3"] | None,
        depth: Float[Tensor, "b h w"] | None,
        labels: list[dict[str, Tensor]] | None = None,
    ) -> Found:
        """Return what the layers give.

        Args:
            rgb: Colours, if they are read.
            depth: Canonical depth (m), if it is read.
            labels: Of each image ``class_labels`` (k) and ``boxes`` (k 4), centre and size as fractions of the canvas;
                in training they are disturbed, and are to be denoised.
        """
        # The library takes the arithmetic of its anchors from its features: in 16 bits boxes would be off by pixels.
        with torch.autocast((depth if rgb is None else rgb).device.type, enabled=False):  # type: ignore[union-attr]
            channels = encode(self.images.reads, rgb, depth)
            found = self.model(pixel_values=channels, labels=labels)
        logits, boxes = found.intermediate_logits, found.intermediate_reference_points
        layers = tuple((logits[:, layer], boxes[:, layer]) for layer in range(logits.shape[1]))
        size = channels.shape[3], channels.shape[2]
        return Found(layers, (found.enc_topk_logits, found.enc_topk_bboxes), size, found.denoising_meta_values)

    def decode(self, raw: Found) -> tuple[Float[Tensor, "b q 4"], Float[Tensor, "b q k"]]:
        """Return boxes (edges on the canvas, px) and the score of each class."""
        logits, boxes = raw.layers[-1]
        boxes = boxes * boxes.new_tensor(raw.size_wh * 2)
        centre, half = boxes[..., :2], boxes[..., 2:] / 2
        return torch.cat([centre - half, centre + half], dim=-1), torch.sigmoid(logits)


def make_detr(config: RtdetrNetworkConfig, channels: int) -> Any:
    """Return the library's network for images of ``channels`` with weights as the library begins.

    Raises:
        MissingPackageError: The library is not installed.
    """
    require_extra(EXTRA, PURPOSE)
    library = require("transformers", EXTRA, PURPOSE)
    backbone = library.RTDetrResNetConfig(
        num_channels=channels,
        embedding_size=config.stem,
        hidden_sizes=list(config.widths),
        depths=list(config.stages),
        layer_type=config.block,
        out_indices=[2, 3, 4],
    )
    return library.RTDetrV2ForObjectDetection(
        library.RTDetrV2Config(
            backbone_config=backbone,
            # Frozen statistics are for backbones that were trained before.
            freeze_backbone_batch_norms=False,
            encoder_in_channels=list(config.widths[1:]),
            encoder_hidden_dim=config.width,
            encoder_ffn_dim=4 * config.width,
            d_model=config.width,
            decoder_in_channels=[config.width] * 3,
            decoder_ffn_dim=4 * config.width,
            decoder_layers=config.decoder_layers,
            hidden_expansion=config.expansion,
            num_queries=config.queries,
            num_labels=config.classes,
        )
    )


def _begin_afresh(detr: Any) -> None:
    """Begin as the authors' code does where the library leaves weights near zero, which only suits loaded ones.

    Scales of normalisation of 0.01 and matrices of a standard deviation of 0.01 let hardly any signal through.
    """
    special = ("score_head", "class_embed", "sampling_offsets", "attention_weights", "value_proj", "output_proj")
    for name, module in detr.named_modules():
        if isinstance(module, nn.BatchNorm2d):
            module.reset_parameters()
        elif isinstance(module, nn.Linear) and not any(part in name for part in special):
            if name.endswith("_proj"):
                nn.init.xavier_uniform_(module.weight)
                nn.init.zeros_(module.bias)
            else:
                module.reset_parameters()
        elif isinstance(module, nn.Conv2d) and ".backbone." not in f".{name}":
            module.reset_parameters()
    for head in (*detr.decoder.bbox_embed, detr.enc_bbox_head):
        # The first boxes are the anchors.
        nn.init.zeros_(head.layers[-1].weight)
        nn.init.zeros_(head.layers[-1].bias)


@dataclass(frozen=True, kw_only=True)
class RtdetrRun(BoxRun):
    """Everything that defines a trained RT-DETR but its weights."""

    images: ImageConfig
    """What it reads."""
    network: RtdetrNetworkConfig
    """Sizes of the network."""
    train: RtdetrConfig
    """How it was trained."""
    kind: str = "rtdetr"

    def make_network(self) -> RtdetrNetwork:
        """Return the network with fresh weights.

        Raises:
            MissingPackageError: The library is not installed.
        """
        return RtdetrNetwork(self.network, self.images)


RTDETR_DETECT = DetectConfig(max_overlap=0.9)
"""Each object is taught to one box only: what overlaps less is another object, such as pallets behind each other."""


class TrainedRtdetr(TrainedDetector):
    """The RT-DETR of a run folder.

    Args:
        run: Run folder, or folder of a bundled model.
        config: What counts as found.

    Raises:
        TrainingError: The folder holds no complete run of an RT-DETR.
        MissingPackageError: The library is not installed.
    """

    opens: ClassVar[type[BoxRun]] = RtdetrRun

    def __init__(self, run: Path, config: DetectConfig = RTDETR_DETECT) -> None:
        super().__init__(run, config)
