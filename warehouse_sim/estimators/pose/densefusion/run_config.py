"""What defines a trained network of the family but its weights, as ``config.yaml`` of its run folder."""

from dataclasses import dataclass

from warehouse_sim.estimators.pose.densefusion.crops.config import CropConfig
from warehouse_sim.estimators.pose.densefusion.networks.densefusion import DenseFusion, DenseFusionConfig
from warehouse_sim.estimators.pose.densefusion.objects import ObjectShape
from warehouse_sim.estimators.pose.densefusion.settings import TrainConfig
from warehouse_sim.learning.run_folder import RunConfig


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

    def make_network(self) -> DenseFusion:
        """Return the network with fresh weights."""
        return DenseFusion(self.network, len(self.objects))
