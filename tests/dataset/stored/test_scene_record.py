import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.dataset.toy import RENDERER, make_scene
from warehouse_sim.dataset.card.tally import Tally
from warehouse_sim.dataset.layout import DatasetLayout
from warehouse_sim.dataset.stored.observation_record import light_row
from warehouse_sim.dataset.stored.scene_record import Outcome, read_scene_record, write_scene_record
from warehouse_sim.errors import DatasetError
from warehouse_sim.schema import FREE, Accessibility, IntensityDistribution, Light, Material


def test_record_names_everything_in_the_scene(toy_root: Path) -> None:
    scene, record = make_scene(1), read_scene_record(toy_root, 1)
    assert (record.scene_index, record.seed, record.split, record.renderer) == (1, 3, "val", RENDERER)
    assert record.settle == {"problems": [], "speed": 0.0}
    assert [item.instance_id for item in record.objects] == [1, 10, 11, 12, 20]
    for instance in scene.instances:
        item = record.object(instance.instance_id)
        model = scene.model_of(instance)
        assert (item.class_name, item.model, item.obj_id) == (model.class_name, model.name, model.obj_id)
        assert item.group == instance.group
        assert np.array_equal(item.T_world_object, instance.T_world_object)
    for stored, viewpoint in zip(record.T_world_camera, scene.viewpoints, strict=True):
        assert np.array_equal(stored, viewpoint.T_world_camera)
    assert record.object(99) is None


def test_a_record_without_its_objects_says_all_else(toy_root: Path) -> None:
    whole, brief = read_scene_record(toy_root, 1), read_scene_record(toy_root, 1, objects=False)
    assert brief.objects == ()
    assert [item.targets for item in brief.observations] == [item.targets for item in whole.observations]
    assert (brief.readings, brief.renderer, brief.settle) == (whole.readings, whole.renderer, whole.settle)


def test_lights_are_stored(toy_root: Path) -> None:
    data = json.loads((toy_root / "scenes" / "000001.json").read_text())
    (light,) = data["lights"]
    assert (light["kind"], light["position"], light["intensity"]) == ("spot", [1.0, 0.0, 5.0], 800.0)
    assert (data["ambient"], data["exposure"]) == (30.0, 0.01)


@pytest.mark.parametrize("key", ["scene_index", "split", "objects", "observations", "renderer", "settle"])
def test_missing_entries_are_named(toy_copy: Path, key: str) -> None:
    path = toy_copy / "scenes" / "000001.json"
    data = json.loads(path.read_text())
    del data[key]
    path.write_text(json.dumps(data))
    with pytest.raises(DatasetError, match=rf"000001\.json: the entry '{key}' is missing"):
        read_scene_record(toy_copy, 1)


def test_unknown_entries_are_named(toy_copy: Path) -> None:
    path = toy_copy / "scenes" / "000001.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | {"splitt": "train"}))
    with pytest.raises(DatasetError, match=r"000001\.json: splitt is not an entry; did you mean 'split'\?"):
        read_scene_record(toy_copy, 1)


def test_paint_is_stored_with_what_it_looks_like(tmp_path: Path) -> None:
    scene, red = make_scene(1), Material("red 1", (0.5, 0.1, 0.1), remission=0.45)
    first = replace(scene.instances[0], paint={"wood": "red 1"})
    painted = replace(
        scene, instances=(first, *scene.instances[1:]), materials={**scene.materials, "red 1": red}, viewpoints=()
    )
    path = DatasetLayout(tmp_path).scene_record(1)
    path.parent.mkdir()
    write_scene_record(path, painted, "train", [], Tally(scenes=1), Outcome({}, RENDERER), {})
    record = read_scene_record(tmp_path, 1)
    assert [dict(item.paint) for item in record.objects if item.paint] == [{"wood": "red 1"}]
    stored = json.loads(path.read_text())["paints"]
    assert list(stored) == ["red 1"]
    assert (stored["red 1"]["base_color"], stored["red 1"]["remission"]) == ([0.5, 0.1, 0.1], 0.45)


def test_what_a_truck_can_take_is_stored(tmp_path: Path) -> None:
    scene, path = replace(make_scene(1), viewpoints=()), DatasetLayout(tmp_path).scene_record(1)
    path.parent.mkdir()
    reach = {10: Accessibility({"-y": FREE, "+y": "blocked by rack"}, stacked=True)}
    write_scene_record(path, scene, "train", [], Tally(scenes=1), Outcome({}, RENDERER, accessibility=reach), {})
    stored = {row["instance_id"]: row for row in json.loads(path.read_text())["objects"]}
    assert (stored[10]["dockable"], stored[10]["stacked"]) == ({"-y": "free", "+y": "blocked by rack"}, True)
    assert "dockable" not in stored[11]
    record = read_scene_record(tmp_path, 1)
    assert {item.instance_id: item.accessibility for item in record.objects if item.accessibility} == reach
    path.write_text(path.read_text().replace('"+y"', '"top"'))
    with pytest.raises(DatasetError, match=r"000001\.json: objects\[\d\]: dockable must name faces among -x"):
        read_scene_record(tmp_path, 1)


def test_a_scene_without_paint_has_no_word_of_it(toy_root: Path) -> None:
    assert "paint" not in (toy_root / "scenes" / "000001.json").read_text()


def test_a_measured_distribution_is_stored_by_its_name() -> None:
    light = Light("spot", np.zeros(3), np.array([0.0, 0.0, -1.0]), 1000.0)
    assert {"distribution", "along"}.isdisjoint(light_row(light))
    own = IntensityDistribution("made", 1.0, np.ones((144, 181), np.float32))
    row = light_row(replace(light, distribution=own, along=(0.0, 1.0, 0.0)))
    assert (row["distribution"], row["along"]) == ("made", (0.0, 1.0, 0.0))
