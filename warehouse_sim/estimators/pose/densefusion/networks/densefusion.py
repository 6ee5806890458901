"""The DenseFusion family (Wang et al., CVPR 2019) as one composition: images, fusion, points, heads, refiner."""

from dataclasses import dataclass

import torch
from jaxtyping import Float
from torch import Tensor, nn
from torch.nn.functional import logsigmoid

from warehouse_sim.estimators.pose.densefusion.losses import inlier_loss
from warehouse_sim.estimators.pose.densefusion.networks.heads import (
    CoordinateHeads,
    HeadConfig,
    InlierHead,
    PoseHeads,
)
from warehouse_sim.estimators.pose.densefusion.networks.image import (
    AttentionConfig,
    AttentionFusion,
    ImageBranch,
    ImageConfig,
)
from warehouse_sim.estimators.pose.densefusion.networks.interface import GroundTruth, Inliers, NetworkInput, Proposal
from warehouse_sim.estimators.pose.densefusion.networks.points import PointBranch, PointConfig, local_features
from warehouse_sim.estimators.pose.densefusion.networks.refiner import Refiner, RefinerConfig
from warehouse_sim.estimators.pose.densefusion.networks.rotations import compose, matrix_from_quat_wxyz
from warehouse_sim.estimators.pose.densefusion.objects import ObjectShape, ShapeTensors
from warehouse_sim.estimators.pose.densefusion.settings import CropConfig, LossConfig, TrainConfig
from warehouse_sim.learning.run_folder import RunConfig
from warehouse_sim.ranges import ranged

_INLIER_WEIGHT = 0.1
"""Of telling the object's points from others, in the loss."""


@dataclass(frozen=True)
@ranged
class DenseFusionConfig:
    """Parts and sizes of a network of the DenseFusion family."""

    points: PointConfig
    """The point branch."""
    heads: HeadConfig
    """The per-point heads."""
    refiner: RefinerConfig | None = None
    """The refiner; none where training has no corrections."""
    images: tuple[ImageConfig, ...] = ()
    """The image branches; none for networks that read the cloud alone."""
    fusion: AttentionConfig | None = None
    """How several images are fused at the points; without it their embeddings are joined channel-wise."""
    inliers: bool = False
    """Whether it distinguishes points around the mask from the object's; else all points count as the object's."""
    upright: bool = False
    """Whether clouds stand upright where gravity is known, and an input says where they do."""

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

    @property
    def remarks(self) -> int:
        """Channels beside the coordinates of each point: whether the mask holds it, whether gravity is known."""
        return int(self.inliers) + int(self.upright)


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
        self.points = PointBranch(config.points, channels, config.remarks)
        self.inliers = InlierHead(self.points.second_channels, classes) if config.inliers else None
        kinds: dict[str, type[PoseHeads | CoordinateHeads]] = {"poses": PoseHeads, "coordinates": CoordinateHeads}
        build_heads = kinds[config.heads.predicts]
        self.heads = build_heads(config.heads, self.points.local_channels, self.points.global_channels, classes)
        self.refiner = Refiner(config.refiner, channels, classes) if config.refiner else None

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
        first, second = self.points.layers(self._remarked(inputs), embedding)
        inlier_logit: Tensor | None = None
        if self.inliers is not None:
            assert inputs.inside is not None
            inlier_logit = self.inliers(torch.cat(second, dim=-1), inputs.inside, inputs.class_index)
        trust = None if inlier_logit is None else torch.sigmoid(inlier_logit)
        whole = self.points.pool(second, trust)
        local = local_features(first, second, wanted)
        believed = None if trust is None else trust[:, :wanted]
        found = self.heads(local, whole, inputs.points[:, :wanted], inputs.class_index, believed)
        return found if inlier_logit is None else _weighted(found, inlier_logit)

    def _remarked(self, inputs: NetworkInput) -> Float[Tensor, "b n c"]:
        """Return the points with what else is known of them."""
        parts = [inputs.points]
        if self.config.inliers:
            if inputs.inside is None:
                raise ValueError("this network reads what is around masks, but the input says of no point if it is in")
            parts.append(inputs.inside[..., None])
        if self.config.upright:
            if inputs.level is None:
                raise ValueError("this network reads whether gravity is known, but the input lacks it")
            parts.append(inputs.level[:, None, None].expand(-1, inputs.points.shape[1], 1))
        return parts[0] if len(parts) == 1 else torch.cat(parts, dim=-1)

    def forward(self, inputs: NetworkInput) -> Proposal:
        """Return the poses that are proposed for each object, before refinement."""
        return self.propose(inputs, self.embed(inputs))

    def loss(self, proposal: Proposal, gt: GroundTruth, shapes: ShapeTensors, config: LossConfig) -> Float[Tensor, ""]:
        """Return the loss of what ``propose`` returned."""
        if proposal.inliers is None:
            return self.heads.loss(proposal, gt, shapes, config)
        inliers = proposal.inliers
        assert gt.belongs is not None
        plain = proposal._replace(hypotheses=proposal.hypotheses._replace(logit=inliers.pose_logit))
        told_apart = inlier_loss(inliers.logit, gt.belongs)
        return self.heads.loss(plain, gt, shapes, config) + _INLIER_WEIGHT * told_apart

    def refine(
        self,
        rotation: Float[Tensor, "b 3 3"],
        translation: Float[Tensor, "b 3"],
        inputs: NetworkInput,
        embedding: Float[Tensor, "b n e"] | None,
        proposal: Proposal | None = None,
    ) -> tuple[Float[Tensor, "b 3 3"], Float[Tensor, "b 3"]]:
        """Return the pose corrected once, as it is without a refiner.

        The given pose, the images and the proposal receive no gradient.

        Args:
            rotation: Of the pose.
            translation: Of the pose, normalised.
            inputs: The batch.
            embedding: What ``embed`` returned for it.
            proposal: What ``propose`` returned for it; needed where the network tells the object's points from others.
        """
        if self.refiner is None:
            return rotation, translation
        trust: Tensor | None = None
        if self.inliers is not None:
            assert proposal is not None
            assert proposal.inliers is not None
            trust = torch.sigmoid(proposal.inliers.logit).detach()
        rotation, translation = rotation.detach(), translation.detach()
        with torch.autocast(rotation.device.type, enabled=False):
            in_estimate = (inputs.points.float() - translation[:, None]) @ rotation
        detached = None if embedding is None else embedding.detach()
        quat, shift = self.refiner(in_estimate, detached, inputs.class_index, trust)
        with torch.autocast(rotation.device.type, enabled=False):
            return compose(rotation, translation, matrix_from_quat_wxyz(quat), shift)


def _weighted(found: Proposal, inlier_logit: Float[Tensor, "b n"]) -> Proposal:
    """Return a proposal whose poses count with the trust in their points, which are the first of all.

    One pose that is fitted to all points has weighted them already.
    """
    pose_logit = found.hypotheses.logit
    inliers = Inliers(inlier_logit, pose_logit)
    if found.coordinates is not None:
        return found._replace(inliers=inliers)
    # ln of the odds of a product of two probabilities.
    log_both = logsigmoid(pose_logit.float()) + logsigmoid(inlier_logit[:, : pose_logit.shape[1]])
    logit = log_both - torch.log1p(-log_both.exp().clamp(max=1.0 - 1e-7))
    return found._replace(hypotheses=found.hypotheses._replace(logit=logit), inliers=inliers)


@dataclass(frozen=True, kw_only=True)
class PoseRun(RunConfig):
    """Everything that defines a trained estimator but its weights."""

    objects: tuple[ObjectShape, ...]
    """Known objects, in the order of the network's classes."""
    network: DenseFusionConfig
    """Sizes of the network."""
    crop: CropConfig
    """How targets are cut out."""
    train: TrainConfig
    """How it was trained."""
    kind: str = "densefusion"

    @property
    def refines(self) -> bool:
        """Whether its refiner was trained."""
        return self.network.refiner is not None and self.train.refiner_iterations > 0

    def make_network(self) -> DenseFusion:
        """Return the network with fresh weights."""
        return DenseFusion(self.network, len(self.objects))
