"""Settings of a recipe's appearance: which kinds of surface vary, and how."""

from dataclasses import dataclass, fields
from typing import Literal

from warehouse_sim.ranges import ranged
from warehouse_sim.scene.appearance.palettes import PaintConfig
from warehouse_sim.scene.appearance.presets import PRESETS, PresetName

Surfaces = Literal["used", "smooth"]


@dataclass(frozen=True)
@ranged
class AppearanceConfig:
    """What each kind of surface looks like. A hall has one make of rack; each pallet has aged in its own way."""

    preset: PresetName = "catalog"
    """How all that is null below varies: "catalog" not at all, "everyday" as halls differ, "wild" beyond belief."""
    surfaces: Surfaces = "used"
    """Textures of floors, walls, board, plastic and coated steel: "used", uneven at all scales, or "smooth"."""
    racks: PaintConfig | None = None
    """Uprights and frames, all of a scene alike."""
    beams: PaintConfig | None = None
    """Beams of racks, all of a scene alike."""
    guards: PaintConfig | None = None
    """The bright paint of guards and bollards, all of a scene alike."""
    structure: PaintConfig | None = None
    """Steel of the building and of conveyors, all of a scene alike."""
    walls: PaintConfig | None = None
    """Panels and cladding, all of a scene alike."""
    roof: PaintConfig | None = None
    """Sheet of the roof."""
    doors: PaintConfig | None = None
    """Dock doors, all of a scene alike."""
    floors: PaintConfig | None = None
    """The slab or its coat; a low factor on the roughness is a wet or polished floor."""
    markings: PaintConfig | None = None
    """Lines and fields on the floor, by their colour."""
    trucks: PaintConfig | None = None
    """The coloured paint of each truck."""
    clothes: PaintConfig | None = None
    """Vests and trousers of each person."""
    helmets: PaintConfig | None = None
    """Helmet of each person."""
    pallets: PaintConfig | None = None
    """Bare wood of each pallet."""
    pallet_paint: PaintConfig | None = None
    """Painted wood and plastic of each pallet."""
    boards: PaintConfig | None = None
    """Board of the cartons of one article in one load."""
    prints: PaintConfig | None = None
    """Coloured ink on cartons and sacks of one article in one load."""
    tape: PaintConfig | None = None
    """Closing tape of the cartons of one article in one load."""
    sacks: PaintConfig | None = None
    """Paper or cloth of the sacks of one article in one load."""
    totes: PaintConfig | None = None
    """Euro containers of one kind in one load."""
    drums: PaintConfig | None = None
    """Drums of one kind in one load."""
    clutter: PaintConfig | None = None
    """Plastic and paint of each thing that stands about."""
    film: PaintConfig | None = None
    """Stretch film of each load."""

    def resolved(self) -> dict[str, PaintConfig]:
        """Return the kinds of surface that vary, by name."""
        preset = PRESETS[self.preset]
        own = {item.name: getattr(self, item.name) for item in fields(self) if item.name not in ("preset", "surfaces")}
        found = {name: preset.get(name, PaintConfig()) if paint is None else paint for name, paint in own.items()}
        return {name: paint for name, paint in found.items() if paint != PaintConfig()}
