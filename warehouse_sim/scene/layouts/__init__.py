"""Where things stand: each layout builds the fixed structure and says which slots can take a unit load."""

from warehouse_sim.scene.layouts.block_storage import BlockStorageConfig
from warehouse_sim.scene.layouts.conveyor_pickup import ConveyorPickupConfig
from warehouse_sim.scene.layouts.dock_staging import DockStagingConfig
from warehouse_sim.scene.layouts.mixed import MixedConfig
from warehouse_sim.scene.layouts.rack_aisle import RackAisleConfig

__all__ = ["BlockStorageConfig", "ConveyorPickupConfig", "DockStagingConfig", "MixedConfig", "RackAisleConfig"]
