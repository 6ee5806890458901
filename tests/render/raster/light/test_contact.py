"""What the map of the floor keeps of its light: nothing is lost far away, half at a wall, most under a deck."""

import numpy as np
import pytest

from warehouse_sim.render.raster.light.contact import light_left

TEXEL = 0.02
STANDS, DECK = 0.1 / 1000.0, 0.1 / 1000.1
"""``near`` / z of what touches the floor, and of what is 10 cm above it."""


def kept(stored: np.ndarray) -> np.ndarray:
    return light_left(stored.astype(np.float32), TEXEL) / 255.0


def test_an_empty_floor_keeps_all() -> None:
    assert (kept(np.zeros((64, 80))) == 1.0).all()


def test_a_wall_takes_half_of_the_light_at_its_foot_and_none_half_a_metre_away() -> None:
    stored = np.zeros((200, 200))
    stored[:, :100] = STANDS
    row = kept(stored)[100]
    assert 0.35 < row[100] < 0.5
    assert (np.diff(row[100:]) >= 0.0).all()
    assert row[100 + round(0.07 / TEXEL)] > row[100] + 0.2
    assert row[100 + round(0.5 / TEXEL)] > 0.98


def test_a_deck_above_the_floor_has_a_softer_rim_than_a_foot() -> None:
    rims = []
    for height in (STANDS, DECK):
        stored = np.zeros((200, 200))
        stored[:, :100] = height
        rims.append(kept(stored)[100])
    assert rims[1][100] == pytest.approx(0.63, abs=0.05)
    assert rims[1][100] > rims[0][100] + 0.15
    assert rims[1][140] == pytest.approx(rims[0][140], abs=0.01)


def test_what_hangs_higher_does_not_count() -> None:
    assert (kept(np.full((64, 64), 0.1 / 1000.3)) == 1.0).all()
