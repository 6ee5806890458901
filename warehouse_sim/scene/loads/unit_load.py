"""A unit load in its own frame: a pallet, the goods on it and what secures them, before it has a place."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.loads.securing import SLIP_SHEETS
from warehouse_sim.catalog.loads.strength import is_goods
from warehouse_sim.catalog.pallets.wear.damaged import damaged
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import Transform, make_transform, rotation_z
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.scene.draft import SceneDraft
from warehouse_sim.scene.packing.bearing import LEAST_SUPPORT, bearing, bearing_under_boards, supported_fraction
from warehouse_sim.scene.packing.contents import Goods, LoadSpace, sample_goods
from warehouse_sim.scene.packing.load_config import UnitLoadConfig
from warehouse_sim.scene.packing.pallet_choice import sample_carrier, sample_pallet
from warehouse_sim.scene.packing.securing import FilmConfig, corner_posts, film_around
from warehouse_sim.schema import ObjectModel

INITIAL_AIR = 0.0005
"""Gap under a pallet before settling (m)."""
_UNDERSIDE = 0.02
"""The envelope of a load begins here (m)."""
_HEADROOM_LEFT = 0.01
"""Least air over a load (m)."""
_SAFE_WORKING_LOADS = {1: 1500.0, 2: 1250.0, 3: 1500.0, 4: 750.0, 5: 500.0, 6: 1250.0}
"""What may lie on a pallet (kg), by obj_id: EPAL 1, 2 and 3 after EPAL's product pages (epal-pallets.org); those of
EPAL 6 and 7 and of the GMA pallet (about 2,800 lb) are common and unverified."""
_COMMON_SAFE_LOAD = 1000.0
"""What is taken for any other pallet (kg)."""
_AS_HEAVY = 1.03
"""Loads whose masses differ by less than this factor, as those of one article on damaged pallets, are equally heavy."""
_SECURING_MASS = 5.0
"""More than sheet, posts and film weigh together (kg)."""


def safe_working_load(pallet: ObjectModel) -> float:
    """Return what may lie on a pallet (kg)."""
    return _SAFE_WORKING_LOADS.get(pallet.obj_id, _COMMON_SAFE_LOAD)


@dataclass(frozen=True, eq=False)
class UnitLoad:
    """Models and their poses in the load's frame: on the support under the pallet's centre, x along its x, z up.

    The first piece is the pallet. Pieces without collision boxes (film, corner posts) follow the goods.
    """

    pieces: tuple[tuple[ObjectModel, Transform], ...]

    @property
    def pallet(self) -> ObjectModel:
        """The pallet under the goods."""
        return self.pieces[0][0]

    @property
    def mass(self) -> float:
        """Mass of everything (kg)."""
        return self.pallet.mass + self.payload

    @property
    def payload(self) -> float:
        """Mass of what lies on the pallet (kg)."""
        return float(sum(model.mass for model, _ in self.pieces[1:]))

    @property
    def height(self) -> float:
        """Height over all (m)."""
        box = _around([OrientedBox(T_load_piece, model.size) for model, T_load_piece in self.pieces])
        return float(box.T_parent_box[2, 3] + box.size[2] / 2)

    @property
    def bearing(self) -> float:
        """What may stand on it on a pallet of the same size (kg): no piece of goods bears more than its strength."""
        return bearing(self.pieces, self.pallet.size.tolist())

    @property
    def bearing_under_boards(self) -> float:
        """What may stand on it under the crush rule (kg), on a pallet like its own: nothing heavier than itself."""
        return min(bearing_under_boards(self.pieces, self.pallet), _AS_HEAVY * self.mass)

    @property
    def has_goods(self) -> bool:
        """Whether it carries anything."""
        return any(is_goods(model) for model, _ in self.pieces[1:])

    def holds(self, class_name: str) -> bool:
        """Return whether a piece of this class is in it."""
        return any(model.class_name == class_name for model, _ in self.pieces)

    def wrapped(self, film: FilmConfig, rng: np.random.Generator) -> "UnitLoad":
        """Return the load with film around its goods, itself where it has film or nothing to wrap."""
        if self.holds("wrap") or not self.has_goods:
            return self
        wrappable = [piece for piece in self.pieces[1:] if piece[0].class_name != "slip_sheet"]
        around = film_around(wrappable, self.pallet.size.tolist(), float(self.pallet.size[2]), film, rng)
        return UnitLoad((*self.pieces, around))

    def supports(self, pallet: ObjectModel, T_load_pallet: Transform) -> bool:
        """Return whether its uppermost pieces are level and broad enough for a pallet to stand on them."""
        return supported_fraction(self.pieces, pallet.size[:2].tolist(), T_load_pallet) >= LEAST_SUPPORT

    @cached_property
    def envelope(self) -> OrientedBox:
        """The room that it takes: the box around all pieces in the load's frame.

        It goes by the collision boxes: the bounding box of a drum grows when the drum is turned, the drum does not.
        """
        return _around(
            [
                box.placed(T_load_piece)
                for model, T_load_piece in self.pieces
                for box in model.collision or (OrientedBox(np.eye(4), model.size),)
            ]
        )

    def add_to(self, draft: SceneDraft, T_world_load: Transform) -> None:
        """Add the pieces to ``draft`` as one new group; physics moves those that have collision boxes."""
        group = draft.new_group()
        for model, T_load_piece in self.pieces:
            draft.add(model, T_world_load @ T_load_piece, group, fixed=not model.collision)


def build_unit_load(
    headroom: float,
    config: UnitLoadConfig,
    rng: np.random.Generator,
    footprint: tuple[float, float] | None = None,
    most_mass: float = np.inf,
    *,
    on_floor: bool = False,
) -> UnitLoad:
    """Draw a unit load.

    Args:
        headroom: Greatest height (m), pallet included.
        config: What the recipe says of loads.
        rng: Stream to draw from.
        footprint: Greatest edges of the pallet along its x and y (m); any pallet of the recipe by default.
        most_mass: Greatest mass of all (kg), where it stands on something that bears no more.
        on_floor: Whether it stands on the floor, as roll containers do.

    Raises:
        PlacementError: No pallet or no goods of the recipe fit, or pieces cannot be jittered as asked.
    """
    if _happens(config.carrier_fraction, rng):
        sampled = sample_carrier(config, rng, headroom, footprint, most_mass, on_floor)
        if sampled is not None:
            return _of_carrier(*sampled)
    pallet = _damaged_by_chance(sample_pallet(config, rng, footprint), config, rng)
    height = float(pallet.size[2])
    pieces: Goods = [(pallet, make_transform(translation=np.array([0.0, 0.0, height / 2 + INITIAL_AIR])))]
    if rng.random() < config.empty_fraction:
        return UnitLoad(tuple(pieces))
    floor = height + INITIAL_AIR
    sheet = _slip_sheet(pallet) if _happens(config.slip_sheet_fraction, rng) else None
    if sheet is not None:
        model, turn = sheet
        centre = np.array([0.0, 0.0, floor + INITIAL_AIR + model.size[2] / 2])
        pieces.append((model, make_transform(rotation_z(turn), centre)))
        floor += INITIAL_AIR + float(model.size[2])
    space = space_on(pallet, headroom - (floor - height - INITIAL_AIR), most_mass)
    T_load_floor = make_transform(translation=np.array([0.0, 0.0, floor]))
    goods = [(model, T_load_floor @ T_floor_piece) for model, T_floor_piece in sample_goods(space, config, rng)]
    pieces += goods + _securing(goods, pallet, floor, config, rng)
    return UnitLoad(tuple(pieces))


def _of_carrier(carrier: ObjectModel, pallet: ObjectModel | None) -> UnitLoad:
    """Return a load of one carrier, on its pallet if it has one."""
    pieces: Goods = []
    floor = 0.0
    for model in (carrier,) if pallet is None else (pallet, carrier):
        floor += INITIAL_AIR
        pieces.append((model, make_transform(translation=np.array([0.0, 0.0, floor + model.size[2] / 2]))))
        floor += float(model.size[2])
    return UnitLoad(tuple(pieces))


def space_on(pallet: ObjectModel, headroom: float, most_mass: float = np.inf) -> LoadSpace:
    """Return the room for goods on a pallet.

    Args:
        pallet: The pallet.
        headroom: Greatest height (m), pallet included.
        most_mass: Greatest mass of all (kg).
    """
    length, width, height = pallet.size.tolist()
    return LoadSpace(
        area=(length, width),
        height=headroom - height - _HEADROOM_LEFT,
        payload=min(safe_working_load(pallet), most_mass - pallet.mass) - _SECURING_MASS,
    )


def jitter_scale(tries: int, most: int) -> float:
    """Return by how much jitter is scaled after ``tries`` of ``most`` in vain: in full at first, to none at the end."""
    return min(1.0, 2.0 * (1.0 - tries / most))


def _around(boxes: Sequence[OrientedBox]) -> OrientedBox:
    """Return the upright box around ``boxes``, but for the lowest of them, so that the support itself is free."""
    lows, highs = BoxStack.of(boxes).extents()
    low, high = np.maximum(lows.min(axis=0), [-np.inf, -np.inf, _UNDERSIDE]), highs.max(axis=0)
    return OrientedBox(make_transform(translation=(low + high) / 2), high - low)


def _damaged_by_chance(pallet: ObjectModel, config: UnitLoadConfig, rng: np.random.Generator) -> ObjectModel:
    """Return the pallet, as use has left it where chance says so."""
    return damaged(pallet, config.wear.sampled(rng), rng) if _happens(config.damaged_fraction, rng) else pallet


def _slip_sheet(pallet: ObjectModel) -> tuple[ObjectModel, float] | None:
    """Return the sheet of the pallet's size and its yaw (rad), None when there is none of that size."""
    for name, (_, length, width) in SLIP_SHEETS.items():
        for turn, edges in ((0.0, (length, width)), (np.pi / 2, (width, length))):
            if np.allclose(pallet.size[:2], edges, atol=0.002):
                return catalog_object(name), turn
    return None


def _securing(
    goods: Goods, pallet: ObjectModel, floor: float, config: UnitLoadConfig, rng: np.random.Generator
) -> Goods:
    """Draw posts and film for ``goods``, which stand on ``floor`` (m)."""
    posts, film = _happens(config.corner_post_fraction, rng), _happens(config.wrap_fraction, rng)
    extras: Goods = []
    # Posts need corners: goods of one size with a full block of layers.
    if posts and len({model.name for model, _ in goods}) == 1 and goods[0][0].class_name == "carton":
        extras += corner_posts(goods, floor)
    if film:
        deck, top = pallet.size.tolist(), float(pallet.size[2])
        extras.append(film_around([*goods, *extras], deck, top, config.film, rng))
    return extras


def _happens(fraction: float, rng: np.random.Generator) -> bool:
    """Draw whether something with this fraction happens; what never happens uses up nothing of the stream."""
    return fraction > 0.0 and bool(rng.random() < fraction)
