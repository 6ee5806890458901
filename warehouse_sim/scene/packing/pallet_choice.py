"""Which pallet stands under a load: one of the catalog, or one that is in none."""

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from warehouse_sim.errors import PlacementError
from warehouse_sim.scene.packing.load_config import UnitLoadConfig
from warehouse_sim.scene.packing.sampled_pallets import sampled_pallets
from warehouse_sim.schema import ObjectModel

_ROUNDING = 1e-6


def all_pallets(loads: UnitLoadConfig) -> list[ObjectModel]:
    """Return every pallet that loads can stand on, undamaged; a name listed twice comes twice."""
    return [*map(loads.pallet, loads.pallets), *_sampled(loads)]


def sample_pallet(
    loads: UnitLoadConfig, rng: np.random.Generator, footprint: Sequence[float] | None = None
) -> ObjectModel:
    """Draw an undamaged pallet that fits ``footprint``, its greatest edges along x and y (m); None is any.

    Raises:
        PlacementError: None fits.
    """
    listed, sampled = (_fitting(found, footprint) for found in (map(loads.pallet, loads.pallets), _sampled(loads)))
    if not listed and not sampled:
        names = ", ".join(loads.pallets)
        raise PlacementError(f"none of the pallets {names} fits {footprint}; list a smaller one in loads.pallets")
    # The stream of recipes that list pallets of the catalog only stays what it was: they draw one number.
    if sampled and (not listed or rng.random() < loads.sampled_pallets.fraction):
        return sampled[int(rng.integers(len(sampled)))]
    return loads.pallet(str(rng.choice([model.name for model in listed])))


def on_these(loads: UnitLoadConfig, pallets: Sequence[ObjectModel]) -> UnitLoadConfig:
    """Return ``loads`` on some of its pallets only."""
    none_else = replace(loads.sampled_pallets, fraction=0.0)
    return replace(loads, pallets=tuple(model.name for model in pallets), sampled_pallets=none_else)


def _sampled(loads: UnitLoadConfig) -> tuple[ObjectModel, ...]:
    return sampled_pallets(loads.sampled_pallets) if loads.sampled_pallets.fraction > 0 else ()


def _fitting(pallets: Iterable[ObjectModel], footprint: Sequence[float] | None) -> list[ObjectModel]:
    if footprint is None:
        return list(pallets)
    return [model for model in pallets if np.all(model.size[:2] <= np.array(footprint) + _ROUNDING)]
