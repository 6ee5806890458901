"""Which pallet stands under a load: one of the catalog, or one that is in none."""

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from warehouse_sim.errors import PlacementError
from warehouse_sim.scene.packing.drawn_pallets import drawn_pallets
from warehouse_sim.scene.packing.load_config import UnitLoadConfig
from warehouse_sim.schema import ObjectModel

_ROUNDING = 1e-6


def all_pallets(loads: UnitLoadConfig) -> list[ObjectModel]:
    """Return every pallet that loads can stand on, unworn; a name listed twice comes twice."""
    return [*map(loads.pallet, loads.pallets), *_drawn(loads)]


def draw_pallet(
    loads: UnitLoadConfig, rng: np.random.Generator, footprint: Sequence[float] | None = None
) -> ObjectModel:
    """Draw an unworn pallet that fits ``footprint``, its greatest edges along x and y (m); None is any.

    Raises:
        PlacementError: None fits.
    """
    listed, drawn = (_fitting(found, footprint) for found in (map(loads.pallet, loads.pallets), _drawn(loads)))
    if not listed and not drawn:
        names = ", ".join(loads.pallets)
        raise PlacementError(f"none of the pallets {names} fits {footprint}; list a smaller one in loads.pallets")
    # The stream of recipes that list pallets of the catalog only stays what it was: they draw one number.
    if drawn and (not listed or rng.random() < loads.drawn_pallets.share):
        return drawn[int(rng.integers(len(drawn)))]
    return loads.pallet(str(rng.choice([model.name for model in listed])))


def on_these(loads: UnitLoadConfig, pallets: Sequence[ObjectModel]) -> UnitLoadConfig:
    """Return ``loads`` on some of its pallets only."""
    none_else = replace(loads.drawn_pallets, share=0.0)
    return replace(loads, pallets=tuple(model.name for model in pallets), drawn_pallets=none_else)


def _drawn(loads: UnitLoadConfig) -> tuple[ObjectModel, ...]:
    return drawn_pallets(loads.drawn_pallets) if loads.drawn_pallets.share > 0 else ()


def _fitting(pallets: Iterable[ObjectModel], footprint: Sequence[float] | None) -> list[ObjectModel]:
    if footprint is None:
        return list(pallets)
    return [model for model in pallets if np.all(model.size[:2] <= np.array(footprint) + _ROUNDING)]
