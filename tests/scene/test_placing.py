import numpy as np
import pytest

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.loads import DRUMS
from warehouse_sim.geometry.pose import make_transform, rotation_z
from warehouse_sim.scene.placing import care_after, envelope_of
from warehouse_sim.scene.unit_load import UnitLoad, UnitLoadConfig, build_unit_load


def test_the_envelope_of_a_drum_does_not_grow_when_the_drum_is_turned() -> None:
    drum = catalog_object(sorted(DRUMS)[0])
    for angle in (0.0, 0.4, np.pi / 4):
        load = UnitLoad(((drum, make_transform(rotation_z(angle), np.array([0.0, 0.0, drum.size[2] / 2]))),))
        assert np.all(envelope_of(load).size[:2] <= drum.size[:2] * 1.08)


@pytest.mark.parametrize("seed", range(3))
def test_for_pallet_and_cartons_it_is_the_box_around_their_sizes(seed: int) -> None:
    load = build_unit_load(1.3, UnitLoadConfig(empty_share=0.0), np.random.default_rng(seed))
    np.testing.assert_allclose(envelope_of(load).size, load.envelope().size, atol=1e-9)
    assert envelope_of(load).T_parent_box[2, 3] - envelope_of(load).size[2] / 2 == pytest.approx(0.02)


def test_care_comes_when_half_the_tries_were_in_vain() -> None:
    assert [care_after(number, 50) for number in (0, 24, 25)] == [1.0, 1.0, 1.0]
    assert care_after(40, 50) == pytest.approx(0.4)
    assert care_after(50, 50) == 0.0
