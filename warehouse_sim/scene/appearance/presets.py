"""Named ways in which all surfaces of a scene vary."""

from typing import Literal

from warehouse_sim.scene.appearance.palettes import PaintConfig
from warehouse_sim.scene.appearance.surfaces import SURFACES
from warehouse_sim.scene.distribution import Distribution

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
