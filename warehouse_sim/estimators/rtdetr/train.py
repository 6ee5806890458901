"""What the training of an RT-DETR has of its own."""

from dataclasses import dataclass
from pathlib import Path

from torch import nn

from warehouse_sim.estimators.detection.training.preparation import Prepared
from warehouse_sim.estimators.detection.training.train import BoxJob
from warehouse_sim.estimators.images.order import GroupedOrder
from warehouse_sim.estimators.rtdetr.network import SIZES, RtdetrNetwork, RtdetrNetworkConfig
from warehouse_sim.estimators.rtdetr.run_config import RtdetrRunConfig, read_config
from warehouse_sim.estimators.rtdetr.settings import RtdetrConfig
from warehouse_sim.estimators.rtdetr.start import start_from
from warehouse_sim.estimators.rtdetr.task import RtdetrTask
from warehouse_sim.learning.run_folder import StartingWeights, package_version
from warehouse_sim.learning.run_log import RunLog


@dataclass(frozen=True)
class RtdetrJob(BoxJob):
    """A training of an RT-DETR."""

    config: RtdetrConfig

    @property
    def is_small(self) -> bool:
        """Whether the network gains little from several threads."""
        return self.config.size == "tiny"

    def read_old(self) -> RtdetrRunConfig:
        """Read the configuration of the run that is gone on with."""
        return read_config(self.run)

    def make(self, prepared: Prepared, order: GroupedOrder) -> tuple[RtdetrTask, RtdetrRunConfig]:
        """Return the training of a fresh network, and the resolved configuration."""
        sizes = RtdetrNetworkConfig(**SIZES[self.config.size], classes=len(prepared.classes))
        network = RtdetrNetwork(sizes, prepared.reading)
        task = RtdetrTask(network, self.config, prepared.images, prepared.class_of, order)
        data, reading = prepared.datasets, prepared.reading
        config = RtdetrRunConfig(self.name, package_version(), data, prepared.classes, reading, sizes, self.config)
        return task, config

    def begin_with(self, init: str | Path, network: nn.Module, log: RunLog) -> StartingWeights:
        """Copy weights of another run, or of the library, and say how many fitted."""
        assert isinstance(network, RtdetrNetwork)
        started, remark = start_from(init, network)
        log.note(remark)
        return started
