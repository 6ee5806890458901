"""The DenseFusion family (Wang et al., CVPR 2019) as one composition: images, fusion, points, heads, refiner."""

from dataclasses import dataclass

import torch
from jaxtyping import Float
from torch import Tensor, nn

from warehouse_sim.estimators.pose.densefusion.networks.attention import AttentionConfig, AttentionFusion
from warehouse_sim.estimators.pose.densefusion.networks.coordinates import CoordinateHeads
from warehouse_sim.estimators.pose.densefusion.networks.heads import HeadConfig, PoseHeads
from warehouse_sim.estimators.pose.densefusion.networks.image import ImageBranch, ImageConfig
from warehouse_sim.estimators.pose.densefusion.networks.inputs import NetworkInput, Truth
from warehouse_sim.estimators.pose.densefusion.networks.points import PointBranch, PointConfig
from warehouse_sim.estimators.pose.densefusion.networks.proposal import Proposal
from warehouse_sim.estimators.pose.densefusion.networks.refiner import Refiner, RefinerConfig
from warehouse_sim.estimators.pose.densefusion.objects import ShapeTensors
from warehouse_sim.estimators.pose.densefusion.rotations import compose, matrix_from_quat_wxyz
from warehouse_sim.estimators.pose.densefusion.settings import LossConfig
from warehouse_sim.ranges import ranged


@dataclass(frozen=True)
@ranged
class DenseFusionConfig:
    """Parts and sizes of a network of the DenseFusion family."""

    points: PointConfig
    """The point branch."""
    heads: HeadConfig
    """The per-point heads."""
    refiner: RefinerConfig
    """The refiner."""
    images: tuple[ImageConfig, ...] = ()
    """The image branches; none for networks that read the cloud alone."""
    fusion: AttentionConfig | None = None
    """How several images are fused at the points; without it their embeddings are joined channel-wise."""

    def __post_init__(self) -> None:
        if len({image.side_px for image in self.images}) > 1:
            raise ValueError(f"all images need crops of one size, found {[image.side_px for image in self.images]}")
        if self.fusion and not self.images:
            raise ValueError("attention fuses images, but there are none")

    @property
    def side_px(self) -> int | None:
        """Side of the square crops in pixels; None for networks that read the cloud alone."""
        return self.images[0].side_px if self.images else None

    @property
    def reads_rgb(self) -> bool:
        """Whether colour crops are needed."""
        return any("rgb" in image.reads for image in self.images)

    @property
    def reads_depth(self) -> bool:
        """Whether depth crops are needed."""
        return any("depth" in image.reads for image in self.images)


class DenseFusion(nn.Module):
    """Estimate the pose of each object of a batch from its cloud and, if configured, its colour and depth crops.

    Shapes with N points, crop side S, embedding E, local features F, pooled features G::

        each image (B,S,S,3|2|5) -> embedding at the points (B,N,32); fused -> (B,N,E)
        points (B,N,3) [+ embedding] -> local (B,N,F), pooled (B,G) -> heads, of the object's class -> (B,N,4|3|1)
        refiner: cloud in the estimate's frame (B,N,3) [+ embedding] -> (B,G) -> correction (B,4), (B,3)

    All lengths are normalised: an object's diameter is 2.

    Args:
        config: Parts and sizes.
        classes: Number of CAD geometries that the network knows.
    """

    def __init__(self, config: DenseFusionConfig, classes: int) -> None:
        super().__init__()
        self.config = config
        sizes = tuple(image.embedding for image in config.images)
        self.images = nn.ModuleList(ImageBranch(image) for image in config.images)
        self.fusion = AttentionFusion(config.fusion, sizes) if config.fusion else None
        channels = config.fusion.embedding if config.fusion else sum(sizes)
        self.points = PointBranch(config.points, channels)
        kinds: dict[str, type[PoseHeads | CoordinateHeads]] = {"poses": PoseHeads, "coordinates": CoordinateHeads}
        build_heads = kinds[config.heads.predicts]
        self.heads = build_heads(config.heads, self.points.local_channels, self.points.global_channels, classes)
        self.refiner = Refiner(config.refiner, channels, classes)

    def embed(self, inputs: NetworkInput) -> Float[Tensor, "b n e"] | None:
        """Return what the images say at each point; None for networks that read the cloud alone."""
        if not self.images:
            return None
        embeddings = [branch(inputs) for branch in self.images]
        if self.fusion is not None:
            return self.fusion(embeddings, inputs.points)
        return embeddings[0] if len(embeddings) == 1 else torch.cat(embeddings, dim=-1)

    def propose(self, inputs: NetworkInput, embedding: Float[Tensor, "b n e"] | None) -> Proposal:
        """Return the poses that are proposed for each object, in normalised units.

        Args:
            inputs: The batch.
            embedding: What ``embed`` returned for it.
        """
        # Points are in random order: the first few are a fair sample.
        wanted = self.config.heads.training_points if self.training else None
        local, whole = self.points(inputs.points, embedding, wanted)
        return self.heads(local, whole, inputs.points[:, :wanted], inputs.class_index)

    def forward(self, inputs: NetworkInput) -> Proposal:
        """Return the poses that are proposed for each object, before refinement."""
        return self.propose(inputs, self.embed(inputs))

    def loss(self, proposal: Proposal, truth: Truth, shapes: ShapeTensors, config: LossConfig) -> Float[Tensor, ""]:
        """Return the loss of what ``propose`` returned."""
        return self.heads.loss(proposal, truth, shapes, config)

    def refine(
        self,
        rotation: Float[Tensor, "b 3 3"],
        translation: Float[Tensor, "b 3"],
        inputs: NetworkInput,
        embedding: Float[Tensor, "b n e"] | None,
    ) -> tuple[Float[Tensor, "b 3 3"], Float[Tensor, "b 3"]]:
        """Return the pose corrected once; the given pose and the images receive no gradient."""
        rotation, translation = rotation.detach(), translation.detach()
        with torch.autocast(rotation.device.type, enabled=False):
            in_estimate = (inputs.points.float() - translation[:, None]) @ rotation
        detached = None if embedding is None else embedding.detach()
        quat, shift = self.refiner(in_estimate, detached, inputs.class_index)
        with torch.autocast(rotation.device.type, enabled=False):
            return compose(rotation, translation, matrix_from_quat_wxyz(quat), shift)
