"""Where things stand: each layout builds the fixed structure and says which slots can take a unit load."""

from warehouse_sim.scene.layouts.block_storage import BlockStorageConfig
from warehouse_sim.scene.layouts.cantilever import CantileverConfig
from warehouse_sim.scene.layouts.conveyor_pickup import ConveyorPickupConfig
from warehouse_sim.scene.layouts.dock_staging import DockStagingConfig
from warehouse_sim.scene.layouts.drive_in import DriveInConfig
from warehouse_sim.scene.layouts.mezzanine import MezzanineConfig
from warehouse_sim.scene.layouts.mixed import MixedConfig
from warehouse_sim.scene.layouts.rack_aisle import RackAisleConfig
from warehouse_sim.scene.layouts.small_parts import SmallPartsConfig

__all__ = [
    "BlockStorageConfig",
    "CantileverConfig",
    "ConveyorPickupConfig",
    "DockStagingConfig",
    "DriveInConfig",
    "MezzanineConfig",
    "MixedConfig",
    "RackAisleConfig",
    "SmallPartsConfig",
]
