"""Which pallet stands under a load, of the catalog or of none, and which carrier is a load of its own."""

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from warehouse_sim.catalog import catalog_object
from warehouse_sim.errors import PlacementError
from warehouse_sim.scene.packing.load_config import UnitLoadConfig, sampled_pallets
from warehouse_sim.schema import ObjectModel

WITHOUT_PALLET = ("gitterbox", "roll_container")
"""Classes that stand on feet or wheels of their own; the others stand on a pallet."""
_ON_FLOOR = ("roll_container",)
"""Classes that stand on the floor and nowhere else."""
_OVER = 0.02
"""How far a carrier may reach over its pallet, both sides together (m)."""


def sample_carrier(
    config: UnitLoadConfig,
    rng: np.random.Generator,
    headroom: float,
    footprint: tuple[float, float] | None,
    most_mass: float,
    on_floor: bool,
) -> tuple[ObjectModel, ObjectModel | None] | None:
    """Draw a carrier and, where it needs one, its pallet; None where none of those listed fits.

    Args:
        config: What the recipe says of loads.
        rng: Stream to draw from.
        headroom: Greatest height over all (m).
        footprint: Greatest edges along x and y (m), any by default.
        most_mass: Greatest mass of all (kg).
        on_floor: Whether it stands on the floor, as roll containers do.
    """
    options: list[tuple[ObjectModel, ObjectModel | None]] = []
    for name in config.carriers:
        model = catalog_object(name)
        for pallet in _pallets(model, config):
            whole = [model] if pallet is None else [pallet, model]
            low = footprint is None or bool(np.all(whole[0].size[:2] <= np.array(footprint) + 1e-6))
            light = sum(piece.mass for piece in whole) <= most_mass
            small = low and sum(float(piece.size[2]) for piece in whole) + 0.01 < headroom
            if small and light and (on_floor or model.class_name not in _ON_FLOOR):
                options.append((model, pallet))
                break
    return options[int(rng.integers(len(options)))] if options else None


def _pallets(model: ObjectModel, config: UnitLoadConfig) -> list[ObjectModel | None]:
    """Return the pallets that a carrier may stand on, those of the recipe first; None for one that needs none."""
    if model.class_name in WITHOUT_PALLET:
        return [None]
    listed = [config.pallet(name) for name in config.pallet_names]
    return [pallet for pallet in listed if np.all(model.size[:2] <= pallet.size[:2] + _OVER)]


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
