"""A scene recipe: the distribution that scenes are drawn from. Every setting has a default."""

from dataclasses import dataclass, field

from warehouse_sim.scene.layouts.rack_aisle import RackAisleConfig
from warehouse_sim.scene.lighting import LightingConfig
from warehouse_sim.scene.shelving import ShelvingConfig
from warehouse_sim.scene.staging import StagingConfig
from warehouse_sim.scene.unit_load import UnitLoadConfig
from warehouse_sim.scene.viewpoints import ViewpointsConfig


@dataclass(frozen=True)
class SceneRecipe:
    """What a scene holds and from where it is seen."""

    layout: RackAisleConfig = field(default_factory=RackAisleConfig)
    """Rack and aisle."""
    loads: UnitLoadConfig = field(default_factory=UnitLoadConfig)
    """Pallets and the cartons on them, in the rack and on the floor."""
    shelving: ShelvingConfig = field(default_factory=ShelvingConfig)
    """Loads in the rack."""
    staging: StagingConfig = field(default_factory=StagingConfig)
    """Loads on the floor of the aisle."""
    lights: LightingConfig = field(default_factory=LightingConfig)
    """Lamps, daylight and exposure."""
    viewpoints: ViewpointsConfig = field(default_factory=ViewpointsConfig)
    """The forklift's camera."""
    observations_per_scene: int = 8
    """Viewpoints of each scene, 1-1000."""
    targets: tuple[str, ...] = ("pallet",)
    """Class names whose objects get full labels."""

    def __post_init__(self) -> None:
        if not 1 <= self.observations_per_scene <= 1000:
            raise ValueError(f"observations_per_scene must be 1-1000, found {self.observations_per_scene}")
        unknown = [name for name in self.targets if name not in ("pallet", "carton")]
        if unknown or not self.targets:
            raise ValueError(f"targets must list classes of load objects (pallet, carton), found {list(self.targets)}")
