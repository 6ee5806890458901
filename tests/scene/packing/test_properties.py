"""Whatever pieces and decks Hypothesis finds, nothing overlaps, leaves its surface or hangs in the air."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.scene.packing.pallets import least_distance, reach
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.scene import Distribution
from warehouse_sim.scene.packing.mixed import pack_mixed
from warehouse_sim.scene.packing.patterns import carried, pattern_layers, possible_patterns
from warehouse_sim.scene.packing.stacking import StackingConfig

edges = st.integers(60, 650).map(lambda mm: mm / 1000)
pieces = st.tuples(edges, edges, edges).map(lambda e: np.array([max(e[:2]), min(e[:2]), e[2]]))
decks = st.tuples(st.integers(600, 1300), st.integers(600, 1300)).map(lambda mm: (mm[0] / 1000, mm[1] / 1000))
stacking = st.builds(
    StackingConfig,
    gap_mm=st.floats(1.0, 10.0),
    shift_mm=st.floats(0.0, 15.0).map(lambda mm: Distribution.uniform(-mm, mm)),
    yaw_deg=st.floats(0.0, 8.0).map(lambda deg: Distribution.uniform(-deg, deg)),
    half_turn_fraction=st.floats(0.0, 1.0),
)


@given(st.lists(pieces, max_size=12), decks, st.floats(0.2, 2.0), stacking, st.integers(0, 2**32))
def test_mixed_pieces_stay_apart_on_the_deck_and_below_the_height(sizes, deck, height, config, seed) -> None:
    placed = pack_mixed(sizes, deck, height, config, np.random.default_rng(seed))
    numbers = [number for number, _ in placed]
    assert numbers == sorted(set(numbers))
    if not placed:
        fits = [s[2] <= height - 0.02 and s[0] + 0.02 <= max(deck) and s[1] + 0.02 <= min(deck) for s in sizes]
        assert not any(fits)
        return
    boxes = [OrientedBox(T, sizes[number]) for number, T in placed]
    assert least_distance(boxes) >= 0.0005 - 1e-9
    assert np.all(reach(boxes) <= np.array(deck) / 2 + 1e-9)
    tops = np.concatenate([box.corners() for box in boxes])[:, 2]
    assert tops.min() >= 0.0005 - 1e-9
    assert tops.max() <= height + 1e-9


@settings(max_examples=30)
@given(pieces, decks, st.floats(0.0, 0.01))
def test_layers_of_every_possible_pattern_bear_the_next(size, deck, gap) -> None:
    for pattern in possible_patterns(size, deck, gap):
        cycle = pattern_layers(pattern, size, deck, gap)
        for upper, lower in zip((*cycle[1:], cycle[0]), cycle, strict=True):
            low, high = upper.rectangles(size)
            assert np.all(high - low > 0.0)
            spread = np.maximum(low[:, None], low) - np.minimum(high[:, None], high)  # of two rectangles, by axis
            apart = spread.max(axis=2)[~np.eye(len(low), dtype=bool)]
            assert apart.min(initial=gap) >= gap - 1e-9
            growth = gap * (np.array(deck) // min(size[:2]))
            assert np.all(np.maximum(high, -low).max(axis=0) <= np.array(deck) / 2 + growth + 1e-9)
            assert carried(low, high, *lower.rectangles(size)).min() >= 0.5
