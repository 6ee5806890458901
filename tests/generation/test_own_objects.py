"""A user's own object in a recipe: placed, settled, rendered and labelled like one of the catalog."""

from pathlib import Path

import pytest

from warehouse_sim.config import from_mapping
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.validate import validate
from warehouse_sim.errors import ConfigError
from warehouse_sim.generation.generate import generate
from warehouse_sim.generation.plan import GenerateConfig
from warehouse_sim.generation.recipe import Recipe

TROLLEY = str(Path(__file__).resolve().parents[2] / "examples" / "custom_object" / "trolley.yaml")


def recipe(**traffic: object) -> Recipe:
    scene = {
        "layout": {"kind": "rack_aisle", "bays": 1},
        "observations_per_scene": 3,
        "targets": ["pallet", "trolley"],
        "traffic": {"objects": [TROLLEY], "own": 4, **traffic},
    }
    return from_mapping(Recipe, {"description": "own objects", "name": "own", "scene": scene}, "own.yaml")


@pytest.mark.gl
def test_own_objects_are_labelled_in_a_dataset_that_holds_its_checks(tmp_path: Path) -> None:
    generate(recipe(), tmp_path / "data", GenerateConfig(scenes=3))
    assert [check for check in validate(tmp_path / "data") if not check.ok] == []
    reader = DatasetReader(tmp_path / "data")
    assert reader.objects[1001].class_name == "trolley"
    labelled = {target.obj_id for split in reader.splits for image in reader.images(split) for target in image.targets}
    assert labelled == {1, 1001}


@pytest.mark.parametrize(
    ("traffic", "message"),
    [
        ({"objects": [], "own": 1}, "own needs the files"),
        ({"objects": [TROLLEY, TROLLEY]}, "objects must differ in name and obj_id"),
        ({"objects": ["nowhere.yaml"]}, "nowhere.yaml: cannot be read"),
    ],
)
def test_wrong_own_objects_are_refused(traffic, message) -> None:
    with pytest.raises(ConfigError, match=message):
        recipe(**traffic)


def test_a_target_class_that_the_catalog_has_too_is_refused(tmp_path: Path) -> None:
    for file in Path(TROLLEY).parent.iterdir():
        (tmp_path / file.name).write_bytes(file.read_bytes())
    own = tmp_path / "trolley.yaml"
    own.write_text(own.read_text().replace("class_name: trolley", "class_name: person"))
    scene = {"targets": ["pallet", "person"], "traffic": {"objects": [str(own)], "own": 1}}
    with pytest.raises(
        ConfigError, match="targets: person is also a class of the catalog, whose objects get no labels"
    ):
        from_mapping(Recipe, {"description": "own objects", "name": "own", "scene": scene}, "own.yaml")
