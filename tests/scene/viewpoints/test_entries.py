import numpy as np
import pytest

from warehouse_sim.catalog import catalog_object
from warehouse_sim.geometry.pose import make_transform, rotation_z
from warehouse_sim.scene.viewpoints.paths import FloorPose
from warehouse_sim.scene.viewpoints.plans import entries_of, pose_before
from warehouse_sim.schema import ObjectInstance


@pytest.mark.parametrize("name", ["epal1", "carton_600x400x400"])
def test_a_pallet_and_a_carton_are_entered_from_the_middle_of_each_side(name: str) -> None:
    model, turn = catalog_object(name), 0.3
    item = ObjectInstance(1, name, make_transform(rotation_z(turn), np.array([1.0, 2.0, 0.072])))
    entries = entries_of(item, model)
    assert len(entries) == 4
    for entry in entries:
        edge = model.size[0] if abs(np.cos(entry.yaw - turn)) > 0.5 else model.size[1]
        into = np.array([np.cos(entry.yaw), np.sin(entry.yaw)])
        np.testing.assert_allclose(np.array([entry.x, entry.y]) + into * edge / 2, [1.0, 2.0], atol=1e-9)
    assert {round(np.rad2deg(entry.yaw - turn)) % 360 for entry in entries} == {0, 90, 180, 270}


def test_a_pose_before_an_entry_is_on_its_line() -> None:
    entry = FloorPose(0.0, 0.0, np.pi / 2)
    straight = pose_before(entry, 2.0, 0.1, 0.0)
    np.testing.assert_allclose([straight.x, straight.y, straight.yaw], [-0.1, -2.0, np.pi / 2], atol=1e-12)
    askew = pose_before(entry, 2.0, 0.0, 0.1)
    reached = askew.after(2.0, 0.0)
    np.testing.assert_allclose([reached.x, reached.y, reached.yaw], [0.0, 0.0, np.pi / 2 + 0.1], atol=1e-12)
