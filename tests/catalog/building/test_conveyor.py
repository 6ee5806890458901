import numpy as np
import pytest

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.building.conveyor import CONVEYORS


@pytest.mark.parametrize("name", CONVEYORS)
def test_rollers_share_one_mesh_and_keep_their_pitch_across_a_joint(name: str) -> None:
    kind, model = CONVEYORS[name], catalog_object(name)
    rollers = [part for part in model.parts if part.scale[0] == kind.roller]
    assert len({part.mesh for part in rollers}) == 1
    x = np.sort([part.T_object_part[0, 3] for part in rollers])
    np.testing.assert_allclose(np.diff(x), kind.pitch)
    assert kind.length - (x[-1] - x[0]) == pytest.approx(kind.pitch)


@pytest.mark.parametrize("name", CONVEYORS)
def test_a_load_rests_on_the_rollers_above_all_else(name: str) -> None:
    kind, model = CONVEYORS[name], catalog_object(name)
    tops = sorted(float(box.corners()[:, 2].max()) for box in model.collision)
    assert tops[-1] == pytest.approx(kind.height / 2)
    assert tops[-2] == pytest.approx(kind.height / 2 - 0.005)
