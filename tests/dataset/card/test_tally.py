from dataclasses import replace

import numpy as np
import pytest

from tests.dataset.toy import CARTON, PALLET, make_scene, observe
from warehouse_sim.dataset.card.tally import SceneTally, Tally, TallyRecord
from warehouse_sim.errors import DatasetError
from warehouse_sim.schema import Material


def tally_of(scene) -> Tally:
    taken = SceneTally(scene)
    for observation in observe(scene):
        taken.add(observation)
    return taken.finish()


def test_objects_labels_and_points_are_counted_by_another_road() -> None:
    scene = make_scene(0)
    tally, (first, second) = tally_of(scene), observe(scene)
    by_class = {look.class_name: count for look, count in tally.looks.items()}
    visible = set(np.unique(np.concatenate([first.buffers.instance_mask, second.buffers.instance_mask])))
    assert (by_class["pallet"].placed, by_class["carton"].placed, by_class["floor"].placed) == (3, 1, 1)
    assert by_class["pallet"].seen == len(visible & {10, 11, 12}) == 3
    labels = [item for observation in (first, second) for item in observation.annotations if item.pixels_visible]
    assert by_class["pallet"].labels == tally.labels == len(labels) == 3
    assert (by_class["carton"].labels, by_class["carton"].seen) == (0, 1)
    assert tally.points == sum(len(item.lidar.points) for item in (first, second))
    assert sum(tally.bins["distance"]) == sum(tally.bins["visible_fraction"]) == 3
    # One of them is farther than 5 m, two are between 3 and 5 m from a camera 0.9 m above the floor.
    assert tally.bins["distance"][2:5] == [1, 1, 1]
    assert sum(tally.bins["lux"]) == 0


def test_equal_shapes_are_one_mesh_and_other_paint_is_another_look() -> None:
    scene = make_scene(0)
    paired_variant = replace(
        PALLET, name="toy-pallet-new", parts=tuple(replace(part, material="new") for part in PALLET.parts)
    )
    damaged = replace(PALLET, name="toy-pallet~1f", parts=PALLET.parts[1:])
    materials = {
        name: Material(name, color) for name, color in {"wood": (0.5, 0.4, 0.3), "new": (0.6, 0.5, 0.3)}.items()
    }
    models = scene.models | {paired_variant.name: paired_variant, damaged.name: damaged}
    names = {10: PALLET.name, 11: paired_variant.name, 12: damaged.name, 20: CARTON.name}
    items = tuple(replace(item, model=names.get(item.instance_id, item.model)) for item in scene.instances)
    looks = [look for look in tally_of(replace(scene, models=models, materials=materials, instances=items)).looks]
    pallets = [look for look in looks if look.class_name == "pallet"]
    assert len({look.mesh for look in pallets}) == 2
    assert len({look.look for look in pallets}) == 3
    assert [look.damaged for look in pallets].count(True) == 1
    same = replace(materials["wood"], name="another name")
    renamed = replace(scene, models=models, materials=materials | {"new": same}, instances=items)
    assert len({look.look for look in tally_of(renamed).looks if look.class_name == "pallet"}) == 2


def test_a_tally_comes_back_from_plain_data_and_adds_up() -> None:
    tally = tally_of(make_scene(1))
    read = TallyRecord.read(TallyRecord.of(tally).row(), "scene").tally()
    assert read == tally
    both = Tally()
    both.add(read)
    both.add(tally)
    assert (both.labels, both.points, both.scenes) == (2 * tally.labels, 2 * tally.points, 2)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"points": -1}, "points must be 0-"),
        ({"bins": {}}, "visible_fraction"),
        ({"bins": {"visible_fraction": [1], "distance": [], "lux": []}}, "must hold 10 counts"),
        ({"looks": [{"class_name": "../x"}]}, "is missing"),
    ],
)
def test_a_malformed_tally_is_rejected(change: dict, words: str) -> None:
    with pytest.raises(DatasetError, match=words):
        TallyRecord.read(TallyRecord.of(tally_of(make_scene(0))).row() | change, "scene")
