import numpy as np
import pytest

from tests.scene.raster import may_carry
from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.loads.strength import stacking_strength
from warehouse_sim.geometry.pose import make_transform, rotation_z
from warehouse_sim.scene.packing.bearing import bearing, supported_fraction, without_overload

CARTON = catalog_object("carton_600x400x300")
DECK = (1.2, 0.8)


def layer(model, level: int, turned: bool = False):
    """Return four pieces on a EUR pallet's edges, along x or across."""
    x, y = model.size[1::-1] / 2 if turned else model.size[:2] / 2
    turn = rotation_z(np.pi / 2 if turned else 0.0)
    z = (level + 0.5) * (model.size[2] + 0.0005)
    return [(model, make_transform(turn, np.array([sx * x, sy * y, z]))) for sx in (-1, 1) for sy in (-1, 1)]


def test_a_carton_bears_what_mckees_formula_in_pounds_and_inches_leaves_of_it() -> None:
    for across in (False, True):
        assert stacking_strength(CARTON, across=across) == pytest.approx(may_carry(CARTON, across), rel=1e-3)
    # 600 x 400 mm: about 300 kg in the laboratory (32 lb/in, C flute), a good third of it in a warehouse.
    assert 110.0 < stacking_strength(CARTON) < 125.0


def test_other_goods_bear_what_their_kind_does() -> None:
    drum = catalog_object("drum_steel_216_blue")
    assert stacking_strength(drum) == pytest.approx(drum.mass * (3.0 - 0.878) / 0.878)
    assert stacking_strength(catalog_object("sack_paper_600x400x110")) == 225.0
    assert stacking_strength(catalog_object("epal1")) == np.inf


def test_a_column_leaves_what_its_lowest_carton_does_not_carry() -> None:
    column = [piece for level in range(4) for piece in layer(CARTON, level)]
    # A quarter of what stands on the block rests on each of four columns, a little more where not all of it rests.
    spare = stacking_strength(CARTON) - 3 * CARTON.mass
    assert 4 * 0.85 * spare < bearing(column, DECK) < 4 * spare


def test_layers_that_are_too_many_are_left_out_sooner_across_joints() -> None:
    straight = [piece for level in range(14) for piece in layer(CARTON, level)]
    crossed = [piece for level in range(14) for piece in layer(CARTON, level, turned=bool(level % 2))]
    for pile, across in ((straight, False), (crossed, True)):
        assert len(without_overload(pile)) == 4 * (1 + int(stacking_strength(CARTON, across=across) // CARTON.mass))


def test_a_top_supports_by_the_area_that_is_level() -> None:
    block = layer(CARTON, 0)
    assert supported_fraction(block, DECK, np.eye(4)) == pytest.approx(1.0)
    assert supported_fraction(block, DECK, make_transform(translation=np.array([0.12, 0.0, 0.0]))) == pytest.approx(0.9)
    assert supported_fraction(block[:3], DECK, np.eye(4)) == pytest.approx(0.75)
    lower = catalog_object("carton_600x400x220")
    uneven = [*block[:3], *layer(lower, 0)[3:]]
    assert supported_fraction(uneven, DECK, np.eye(4)) == pytest.approx(0.75)
    drum = catalog_object("drum_steel_216_blue")
    one = [(drum, make_transform(translation=np.array([0.0, 0.0, 0.439])))]
    assert supported_fraction(one, (0.585, 0.585), np.eye(4)) == pytest.approx(2**0.5 / 2)  # an octagon in a circle
