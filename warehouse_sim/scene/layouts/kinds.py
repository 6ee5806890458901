"""The layouts that a recipe can name."""

from warehouse_sim.scene.layouts.block_storage import BlockStorageConfig
from warehouse_sim.scene.layouts.conveyor_pickup import ConveyorPickupConfig
from warehouse_sim.scene.layouts.dock_staging import DockStagingConfig
from warehouse_sim.scene.layouts.mixed import MixedConfig
from warehouse_sim.scene.layouts.rack_aisle import RackAisleConfig
from warehouse_sim.scene.layouts.site import Layout

LAYOUTS: dict[str, type[Layout]] = {
    layout.kind: layout
    for layout in (RackAisleConfig, BlockStorageConfig, DockStagingConfig, ConveyorPickupConfig, MixedConfig)
}
"""Value of ``layout.kind`` in a recipe -> its settings."""
