"""DenseFusion (Wang et al., CVPR 2019) as one composition: image branch, point branch, heads, refiner."""

from dataclasses import dataclass

import torch
from jaxtyping import Float, Int, UInt8
from torch import Tensor, nn

from warehouse_sim.learning.networks.heads import HeadConfig, Hypotheses, PoseHeads
from warehouse_sim.learning.networks.image import ImageConfig, build_image_branch
from warehouse_sim.learning.networks.points import PointBranch, PointConfig
from warehouse_sim.learning.networks.refiner import Refiner, RefinerConfig
from warehouse_sim.learning.rotations import compose, matrix_from_quat_wxyz


@dataclass(frozen=True)
class DenseFusionConfig:
    """Sizes of a network of the DenseFusion family."""

    points: PointConfig
    """The point branch."""
    heads: HeadConfig
    """The per-point heads."""
    refiner: RefinerConfig
    """The refiner."""
    image: ImageConfig | None = None
    """The image branch; none for networks that read the cloud alone."""


class DenseFusion(nn.Module):
    """Estimate the pose of each object of a batch from its cloud and, if configured, its colour crop.

    Shapes with N points, image side S, embedding E, local features F, pooled features G, C classes::

        rgb (B,3,S,S) -> embedding (B,E,S,S) -> at the points (B,N,E)
        points (B,N,3) [+ embedding] -> local (B,N,F), pooled (B,G) -> heads (B,N,C*(4|3|1)) -> (B,N,4|3|1)
        refiner: cloud in the estimate's frame (B,N,3) [+ embedding] -> (B,G) -> correction (B,4), (B,3)

    All lengths are normalised: an object's diameter is 2.

    Args:
        config: Sizes.
        classes: Number of CAD geometries that the network knows.
    """

    def __init__(self, config: DenseFusionConfig, classes: int) -> None:
        super().__init__()
        self.config = config
        channels = config.image.embedding if config.image else 0
        self.image = build_image_branch(config.image) if config.image else None
        self.points = PointBranch(config.points, channels)
        self.heads = PoseHeads(config.heads, self.points.local_channels, self.points.global_channels, classes)
        self.refiner = Refiner(config.refiner, channels, classes)

    def embed(self, rgb: UInt8[Tensor, "b s s 3"] | None, pixel: Int[Tensor, "b n"]) -> Float[Tensor, "b n e"] | None:
        """Return the colour embedding at the points; None without an image branch.

        Args:
            rgb: Crops, 0-255.
            pixel: Row-major index into the crop of the pixel that each point came from.
        """
        if self.image is None or rgb is None:
            return None
        maps = self.image(rgb.permute(0, 3, 1, 2).float() / 127.5 - 1.0).flatten(2)
        return torch.gather(maps, 2, pixel[:, None].expand(-1, maps.shape[1], -1)).transpose(1, 2)

    def forward(
        self,
        points: Float[Tensor, "b n 3"],
        colour: Float[Tensor, "b n e"] | None,
        class_index: Int[Tensor, " b"],
    ) -> Hypotheses:
        """Return one pose a point, in normalised units.

        Args:
            points: Clouds about their centre, normalised.
            colour: What ``embed`` returned.
            class_index: Class of each object.
        """
        local, whole = self.points(points, colour)
        return self.heads(local, whole, points, class_index)

    def refine(
        self,
        rotation: Float[Tensor, "b 3 3"],
        translation: Float[Tensor, "b 3"],
        points: Float[Tensor, "b n 3"],
        colour: Float[Tensor, "b n e"] | None,
        class_index: Int[Tensor, " b"],
    ) -> tuple[Float[Tensor, "b 3 3"], Float[Tensor, "b 3"]]:
        """Return the pose corrected once; the input pose and colours receive no gradient."""
        rotation, translation = rotation.detach(), translation.detach()
        in_estimate = (points.float() - translation[:, None]) @ rotation
        quat, shift = self.refiner(in_estimate, None if colour is None else colour.detach(), class_index)
        return compose(rotation, translation, matrix_from_quat_wxyz(quat), shift)
