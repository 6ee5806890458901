"""What a pallet carries: which goods, how many layers, in which pattern."""

import zlib
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.loads.sacks import shapes_of
from warehouse_sim.catalog.loads.strength import bears
from warehouse_sim.errors import PlacementError
from warehouse_sim.geometry.pose import Transform
from warehouse_sim.scene.packing.bearing import LEAST_LAYER, layer_fraction, without_overload
from warehouse_sim.scene.packing.load_config import UnitLoadConfig
from warehouse_sim.scene.packing.mixed import Rests, pack_mixed
from warehouse_sim.scene.packing.patterns import Cycle, Pattern, how_many, pattern_layers, possible_patterns
from warehouse_sim.scene.packing.stacking import Tier, stack_tiers
from warehouse_sim.schema import ObjectModel

_CARRYING_FRACTION, _CARRYING_LAYERS = 0.93, 4
"""A load that carries another fills this fraction of its pallet, and each piece bears so many of its like."""
Goods = list[tuple[ObjectModel, Transform]]
"""Models and their poses over the surface that carries them, whose middle is the origin."""


@dataclass(frozen=True)
class LoadSpace:
    """What a load may take."""

    area: tuple[float, float]
    """Edges of the surface along x and y, overhang included (m)."""
    height: float
    """Free height over it (m)."""
    payload: float
    """Greatest mass (kg)."""


def sample_goods(space: LoadSpace, config: UnitLoadConfig, rng: np.random.Generator) -> Goods:
    """Draw the goods of a loaded pallet; no piece bears more than its stacking strength.

    Raises:
        PlacementError: Nothing that the recipe lists fits ``space``, or pieces cannot be jittered as asked.
    """
    names, rule = _kind(config, rng), config.stacking.crush_rule
    if names is config.cartons and config.mixed_fraction > 0.0 and rng.random() < config.mixed_fraction:
        return without_overload(_mixed(space, config, rng), crush_rule=rule)
    return without_overload(_equal(names, space, config, rng), crush_rule=rule)


def one_article(space: LoadSpace, config: UnitLoadConfig, rng: np.random.Generator) -> UnitLoadConfig:
    """Draw one article as the recipe's shares say: ``config`` with one stock-keeping unit in one pattern.

    Raises:
        PlacementError: Nothing of the kind that is sampled fits ``space``.
    """
    names = _kind(config, rng)
    model = catalog_object(str(rng.choice(_that_stack(names, space, config))))
    listed = _listed_patterns(model, space, config)
    if names is config.goods:
        one_name = next(name for name in names if catalog_object(name) is model)
        alone = replace(
            config, goods=(one_name,), tote_fraction=0.0, drum_fraction=0.0, sack_fraction=0.0, goods_fraction=1.0
        )
        return replace(alone, patterns=(listed[int(rng.integers(len(listed)))],))
    kind, one = model.class_name, (model.name,)
    return replace(
        config,
        goods_fraction=0.0,
        tote_fraction=float(kind == "tote"),
        drum_fraction=float(kind == "drum"),
        sack_fraction=float(kind == "sack"),
        mixed_fraction=0.0,
        cartons=one if kind == "carton" else config.cartons,
        totes=one if kind == "tote" else config.totes,
        drums=one if kind == "drum" else config.drums,
        sacks=one if kind == "sack" else config.sacks,
        patterns=(listed[int(rng.integers(len(listed)))],),
    )


def that_carry(config: UnitLoadConfig, deck: tuple[float, float]) -> UnitLoadConfig:
    """Return ``config`` with the articles of which a layer on a ``deck`` (m) carries another load; all where none does.

    Drums carry none: their tops leave too much of a pallet without support.
    """
    lists = (config.cartons, config.totes, config.sacks, config.goods)
    cartons, totes, sacks, goods = (_carrying(names, deck) or names for names in lists)
    return replace(config, cartons=cartons, totes=totes, sacks=sacks, goods=goods)


def _carrying(names: Sequence[str], deck: tuple[float, float]) -> tuple[str, ...]:
    chosen = []
    for name in names:
        model = catalog_object(name)
        layer = pattern_layers("column", model.size, deck, 0.0)
        fraction = len(layer[0]) * model.size[0] * model.size[1] / (deck[0] * deck[1]) if layer else 0.0
        if fraction >= _CARRYING_FRACTION and bears(model) >= _CARRYING_LAYERS * model.mass:
            chosen.append(name)
    return tuple(chosen)


def _kind(config: UnitLoadConfig, rng: np.random.Generator) -> tuple[str, ...]:
    """Draw which list of the recipe the goods come from."""
    kinds = (
        *(
            (config.tote_fraction, config.totes),
            (config.drum_fraction, config.drums),
            (config.sack_fraction, config.sacks),
        ),
        (config.goods_fraction, config.goods),
    )
    if not any(fraction for fraction, _ in kinds):
        return config.cartons
    left = rng.random()
    for fraction, names in kinds:
        if left < fraction:
            return names
        left -= fraction
    return config.cartons


def _equal(names: tuple[str, ...], space: LoadSpace, config: UnitLoadConfig, rng: np.random.Generator) -> Goods:
    """Draw layers of one kind of piece."""
    model = catalog_object(str(rng.choice(_that_stack(names, space, config))))
    cycle = _cycle(model, space, config, rng)
    wanted = min(config.height.sample(rng), space.height)
    per_layer = max(map(len, cycle))
    limit = int(space.payload / (model.mass * per_layer))
    layers = max(1, min(int(wanted / model.size[2]), config.max_cartons // per_layer, limit))
    is_round = model.class_name == "drum"
    tiers = [Tier(model.size, cycle[level % len(cycle)], is_round) for level in range(layers)]
    poses = [T for tier in stack_tiers(tiers, config.stacking, rng) for T in tier]
    if model.class_name == "sack" and config.sack_shapes:
        return [(_one_of_its_shapes(model.name, T), T) for T in poses]
    return [(model, T) for T in poses]


def _one_of_its_shapes(name: str, T_floor_piece: Transform) -> ObjectModel:
    """Return a shape of a sack that its place decides, so that nothing else is sampled for it."""
    shapes = shapes_of(name)
    return catalog_object(shapes[zlib.crc32(T_floor_piece.tobytes()) % len(shapes)])


def _that_stack(names: Sequence[str], space: LoadSpace, config: UnitLoadConfig) -> list[str]:
    """Return those of ``names`` that fit ``space`` and, under the crush rule, bear their like; all that fit if none do.

    Raises:
        PlacementError: None fits.
    """
    fitting = _that_fit(names, space)
    if not config.stacking.crush_rule:
        return fitting
    return [name for name in fitting if bears(model := catalog_object(name)) >= model.mass] or fitting


def _that_fit(names: Sequence[str], space: LoadSpace) -> list[str]:
    """Return those of ``names`` of which a layer fits ``space``.

    Raises:
        PlacementError: There are none.
    """
    fitting = []
    for name in names:
        model = catalog_object(name)
        layer = pattern_layers("column", model.size, space.area, 0.0)
        if layer and model.size[2] <= space.height and model.mass * len(layer[0]) <= space.payload:
            fitting.append(name)
    if not fitting:
        shown = ", ".join(names[:3]) + (", ..." if len(names) > 3 else "")
        raise PlacementError(
            f"none of {shown} fits {space.area[0]:.2f} x {space.area[1]:.2f} m, {space.height:.2f} m high, with at "
            f"most {space.payload:.0f} kg, above a pallet; raise beam_levels or list smaller, lower or lighter goods"
        )
    return fitting


def _cycle(model: ObjectModel, space: LoadSpace, config: UnitLoadConfig, rng: np.random.Generator) -> Cycle:
    """Draw the pattern among those of the recipe that the piece's size allows; columns when it allows none."""
    listed = _listed_patterns(model, space, config)
    # Pieces without corners stand in columns: nothing about them interlocks.
    chosen = listed[int(rng.integers(len(listed)))] if len(listed) > 1 and model.class_name != "drum" else listed[0]
    return pattern_layers(chosen, model.size, space.area, config.stacking.gap_mm / 1000)


def _listed_patterns(model: ObjectModel, space: LoadSpace, config: UnitLoadConfig) -> list[Pattern]:
    """Return those patterns of the recipe that the piece's size allows; columns when it allows none."""
    gap = config.stacking.gap_mm / 1000
    possible = possible_patterns(model.size, space.area, gap)
    if config.stacking.crush_rule:
        possible = tuple(
            pattern for pattern in possible if _layers_bear(pattern_layers(pattern, model.size, space.area, gap), model)
        )
    return [pattern for pattern in config.patterns if pattern in possible] or ["column"]


def _layers_bear(cycle: Cycle, model: ObjectModel) -> bool:
    """Return whether each layer rests on most of the one below it."""
    pairs = zip(cycle, (*cycle[1:], cycle[0]), strict=True)
    return all(layer_fraction(lower, upper, model.size) >= LEAST_LAYER for lower, upper in pairs)


def _mixed(space: LoadSpace, config: UnitLoadConfig, rng: np.random.Generator) -> Goods:
    """Draw a picked order: up to ``max_cartons`` cartons of several SKUs, those that press hardest first."""
    names = _that_fit(config.cartons, space)
    names = list(rng.permutation(names)[: int(rng.integers(2, 6))])
    height = min(config.height.sample(rng), space.height)
    count = int(rng.integers(max(1, config.max_cartons // 2), config.max_cartons + 1))
    order = [catalog_object(str(name)) for name in rng.choice(names, count)]
    rule = config.stacking.crush_rule
    order.sort(key=_heaviest_first if rule else _broadest_first)
    masses = np.cumsum([model.mass for model in order])
    order = [model for model, total in zip(order, masses, strict=True) if total <= space.payload]
    sizes = [model.size for model in order]
    # As in the patterns, gaps come on top: as many of the broadest piece fit side by side as would without gaps.
    broadest = max(float(min(size[:2])) for size in sizes)
    area = tuple(edge + max(1, how_many(edge, broadest)) * config.stacking.gap_mm / 1000 for edge in space.area)
    tallest = max(float(size[2]) for size in sizes)
    rests = _rests(order) if rule else None
    placed = pack_mixed(sizes, (area[0], area[1]), max(height, tallest + 0.001), config.stacking, rng, rests)
    return [(order[number], T) for number, T in placed]


def _broadest_first(model: ObjectModel) -> tuple[float, ...]:
    return -float(model.size[0] * model.size[1]), -model.mass


def _heaviest_first(model: ObjectModel) -> tuple[float, ...]:
    """Order by mass, and of what weighs the same, what bears most and is broadest first."""
    return -model.mass, -bears(model), -float(model.size[0] * model.size[1])


def _rests(order: Sequence[ObjectModel]) -> Rests:
    """Return the crush rule for pieces in one load: none rests on a lighter one, or on one that would not bear it."""
    masses, strengths = np.array([model.mass for model in order]), np.array([bears(model) for model in order])
    return Rests((masses[:, None] <= masses[None]) & (masses[:, None] <= strengths[None]), LEAST_LAYER)
