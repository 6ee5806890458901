"""Settings of a recipe's appearance: which kinds of surface vary, and how; named ways in which all of them do."""

from dataclasses import dataclass, field, fields
from typing import Annotated, Literal

from warehouse_sim.ranges import Fraction, Range, ranged
from warehouse_sim.scene.appearance.surfaces import SURFACES
from warehouse_sim.scene.distribution import Distribution


@dataclass(frozen=True)
@ranged
class PaintConfig:
    """How one kind of surface varies; as it stands here, it does not."""

    fraction: Fraction = 0.0
    """Fraction of the things that have another colour than the catalog's, 0-1: one that is common for such things."""
    any_hue: Fraction = 0.0
    """Fraction of those that have any colour at all instead of a common one, 0-1."""
    value: Annotated[Distribution, Range(0.1, 4)] = field(default=Distribution.constant(1.0))
    """Factor on the albedo, 0.1-4; no channel passes 0.9."""
    hue_deg: Annotated[Distribution, Range(-180, 180, "deg")] = field(default=Distribution.constant(0.0))
    """Turn of the hue (deg), -180 to 180."""
    roughness: Annotated[Distribution, Range(0.1, 4)] = field(default=Distribution.constant(1.0))
    """Factor on the roughness, 0.1-4; no roughness passes 1."""
    dirt: Annotated[Distribution, Range(0, 1)] = field(default=Distribution.constant(0.0))
    """How much dust and grime lies on it, 0-1; from 0.35 on the texture is a stained and scratched one."""
    swap: Fraction = 0.0
    """Fraction of the things that have the texture of some other material, 0-1."""


PresetName = Literal["catalog", "everyday", "wild"]


def _varied(
    fraction: float = 0.0,
    dirt: float = 0.0,
    value: tuple[float, float] = (0.85, 1.12),
    hue_deg: float = 4.0,
    roughness: tuple[float, float] = (0.8, 1.25),
) -> PaintConfig:
    """Return a kind of surface that ``fraction`` of the things are painted again on, with dirt from 0 to ``dirt``."""
    return PaintConfig(
        fraction=fraction,
        value=Distribution.uniform(*value),
        hue_deg=Distribution.uniform(-hue_deg, hue_deg),
        roughness=Distribution.uniform(*roughness),
        dirt=Distribution.uniform(0.0, dirt),
    )


_WILD = PaintConfig(
    fraction=1.0,
    any_hue=1.0,
    value=Distribution.uniform(0.5, 1.6),
    roughness=Distribution.uniform(0.3, 1.8),
    dirt=Distribution.uniform(0.0, 0.5),
    swap=0.4,
)

PRESETS: dict[PresetName, dict[str, PaintConfig]] = {
    "catalog": {},
    "everyday": {
        "racks": _varied(0.75, 0.5),
        "beams": _varied(0.75, 0.5),
        "guards": _varied(0.3, 0.8),
        "structure": _varied(0.6, 0.4),
        "walls": _varied(0.8, 0.6),
        "roof": _varied(0.6, 0.3),
        "doors": _varied(0.6, 0.5),
        "floors": _varied(0.7, 0.9, value=(0.8, 1.25), roughness=(0.5, 1.2)),
        "markings": _varied(0.2, 0.8, value=(0.6, 1.05)),
        "trucks": _varied(0.8, 0.5),
        "clothes": _varied(0.4, 0.3),
        "helmets": _varied(0.8, 0.3),
        "pallets": _varied(0.0, 0.8, value=(0.6, 1.2), hue_deg=8.0),
        "pallet_paint": _varied(0.25, 0.7),
        "boards": _varied(0.7, 0.45, value=(0.9, 1.08)),
        "prints": _varied(0.7, value=(0.8, 1.3)),
        "tape": _varied(0.6),
        "sacks": _varied(0.6, 0.4),
        "totes": _varied(0.7, 0.5),
        "drums": _varied(0.6, 0.4),
        "clutter": _varied(0.8, 0.8),
        "film": _varied(0.6, hue_deg=0.0),
    },
    "wild": {name: _WILD for name in SURFACES if name != "film"},
}
"""Value of ``appearance.preset`` -> how each kind of surface varies; what is not there looks as in the catalog."""

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
