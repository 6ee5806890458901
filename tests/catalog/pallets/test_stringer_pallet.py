from collections import Counter

import numpy as np
import pytest

from tests.catalog.covering import volume
from tests.catalog.pallets.touching import reaches_into
from warehouse_sim.catalog.pallets import pallet
from warehouse_sim.geometry.mesh import unit_box
from warehouse_sim.geometry.pose import make_transform

INCH = 0.0254
MODEL = pallet("gma_48x40")
STRINGERS = [part for part in MODEL.parts if part.mesh is not unit_box()]


def test_twelve_boards_and_three_stringers_have_the_published_sizes() -> None:
    boards = [part for part in MODEL.parts if part.mesh is unit_box()]
    assert Counter(tuple(np.round(part.scale / INCH, 6)) for part in boards) == {
        (5.5, 40.0, 0.625): 4,
        (3.5, 40.0, 0.625): 8,
    }
    assert len(STRINGERS) == 3
    assert len({part.mesh for part in STRINGERS}) == 1
    extent = np.ptp(STRINGERS[0].placed().vertices, axis=0) / INCH
    np.testing.assert_allclose(extent, [48.0, 1.375, 3.5])


def test_two_notches_of_9_by_1_5_inch_stand_18_inch_apart() -> None:
    beam = STRINGERS[1].placed()
    bottom = beam.vertices[:, 2].min()
    for x in (-13.5, 13.5):
        T = make_transform(translation=np.array([x * INCH, 0.0, bottom + 0.75 * INCH]))
        assert not reaches_into(beam, T, np.array([9.0, 3.0, 1.5]) * INCH)
        for larger in ([9.1, 3.0, 1.4], [8.9, 3.0, 1.6]):
            assert reaches_into(beam, T, np.array(larger) * INCH)
    assert sorted({round(float(x) / INCH, 6) for x in np.abs(beam.vertices[:, 0])}) == [9.0, 18.0, 24.0]


def test_a_stringer_is_solid_but_for_its_notches() -> None:
    assert volume(STRINGERS[0].mesh) / INCH**3 == pytest.approx(1.375 * (48 * 3.5 - 2 * 9 * 1.5))


def test_bottom_boards_keep_clear_of_the_notches() -> None:
    boards = [part for part in MODEL.parts if part.T_object_part[2, 3] < -0.05]
    x = np.array([part.T_object_part[0, 3] for part in boards]) / INCH
    half = np.array([part.scale[0] for part in boards]) / INCH / 2
    order = np.argsort(x)
    left, right = (x - half)[order], (x + half)[order]
    np.testing.assert_allclose([left[2], right[2]], [-1.75, 1.75])
    for low, high in ((-18.0, -9.0), (9.0, 18.0)):
        assert np.all((right <= low + 1e-9) | (left >= high - 1e-9))


def test_physics_leaves_the_notches_open() -> None:
    assert len(MODEL.collision) == 1 + 3 * 4 + 5
    filled = sum(float(np.prod(box.size)) for box in MODEL.collision[1:13])
    assert filled / INCH**3 == pytest.approx(3 * 1.375 * (48 * 3.5 - 2 * 9 * 1.5))
