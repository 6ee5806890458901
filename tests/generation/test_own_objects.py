"""A user's own object in a recipe: placed, settled, rendered and labelled like one of the catalog."""

from pathlib import Path

import pytest
import yaml

from warehouse_sim.config import from_mapping
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.validate import validate
from warehouse_sim.errors import ConfigError
from warehouse_sim.generation.generate import generate
from warehouse_sim.generation.plan import GenerateConfig
from warehouse_sim.generation.recipe import Recipe
from warehouse_sim.generation.scene import sample_settled_scene
from warehouse_sim.physics import crush_state

CAMERA = {"camera": {"width": 408, "height": 124, "focal_px": 240}}
"""A third of the pixels of the default camera each way, and its field of view."""
TROLLEY = str(Path(__file__).resolve().parents[2] / "examples" / "custom_object" / "trolley.yaml")


def recipe(**traffic: object) -> Recipe:
    scene = {
        "layout": {"kind": "rack_aisle", "bays": 1},
        "observations_per_scene": 2,
        "targets": ["pallet", "trolley"],
        "traffic": {"objects": [TROLLEY], "own": 4, **traffic},
    }
    return from_mapping(
        Recipe, {"description": "own objects", "name": "own", "scene": scene, "sensors": CAMERA}, "own.yaml"
    )


@pytest.mark.gl
def test_own_objects_are_labelled_in_a_dataset_that_holds_its_checks(tmp_path: Path) -> None:
    generate(recipe(), tmp_path / "data", GenerateConfig(scenes=1))
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
        ({"objects": ["nowhere.yaml"]}, "nowhere.yaml: there is no such file"),
    ],
)
def test_wrong_own_objects_are_rejected(traffic, message) -> None:
    with pytest.raises(ConfigError, match=message):
        recipe(**traffic)


def test_a_target_class_that_the_catalog_has_too_is_rejected(tmp_path: Path) -> None:
    for file in Path(TROLLEY).parent.iterdir():
        (tmp_path / file.name).write_bytes(file.read_bytes())
    own = tmp_path / "trolley.yaml"
    own.write_text(own.read_text().replace("class_name: trolley", "class_name: cone"))
    scene = {"targets": ["pallet", "cone"], "traffic": {"objects": [str(own)], "own": 1}}
    with pytest.raises(ConfigError, match="targets: cone is also a class of the catalog, whose objects get no labels"):
        from_mapping(Recipe, {"description": "own objects", "name": "own", "scene": scene}, "own.yaml")


def crate_recipe(folder: Path, **keys: object) -> Recipe:
    """Return a recipe whose pallets carry a crate of the user's own, a box in a mesh file."""
    corners = [(x, y, z) for x in (-0.2, 0.2) for y in (-0.15, 0.15) for z in (0.0, 0.25)]
    faces = ((1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4))
    lines = [*(f"v {x} {y} {z}" for x, y, z in corners), *("f " + " ".join(map(str, face)) for face in faces)]
    (folder / "crate.obj").write_text("\n".join(lines) + "\n")
    plain = {"name": "crate", "class_name": "crate", "obj_id": 1010, "file": "crate.obj", "mass": 14, "bears": 45}
    (folder / "crate.yaml").write_text(yaml.safe_dump(plain | {"material": "plastic_red"} | keys))
    scene = {
        "layout": {"kind": "rack_aisle", "bays": 1},
        "observations_per_scene": 2,
        "targets": ["pallet", "crate"],
        "loads": {"goods": [str(folder / "crate.yaml")], "goods_fraction": 1.0, "height": 1.3, "max_cartons": 80},
    }
    return from_mapping(Recipe, {"description": "own goods", "scene": scene, "sensors": CAMERA}, "crates.yaml")


@pytest.mark.parametrize(("keys", "layers"), [({}, 4), ({"bears": None}, 1), ({"bears": 20}, 2)])
def test_own_goods_are_stacked_as_high_as_they_bear_and_stand(tmp_path: Path, keys: dict, layers: int) -> None:
    sampled = sample_settled_scene(crate_recipe(tmp_path, **keys), 0, 0)
    levels: dict[int, set[float]] = {}
    for item in sampled.scene.instances:
        if item.model == "crate":
            levels.setdefault(item.group, set()).add(round(item.T_world_object[2, 3], 1))
    assert max(map(len, levels.values())) == layers
    assert crush_state(sampled.scene).faults == ()


@pytest.mark.gl
def test_own_goods_keep_their_class_and_are_targets(tmp_path: Path) -> None:
    generate(crate_recipe(tmp_path), tmp_path / "data", GenerateConfig(scenes=1))
    assert [check for check in validate(tmp_path / "data") if not check.ok] == []
    reader = DatasetReader(tmp_path / "data")
    assert reader.objects[1010].class_name == "crate"
    labelled = {target.obj_id for split in reader.splits for image in reader.images(split) for target in image.targets}
    assert 1010 in labelled


def test_goods_that_never_move_are_rejected(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="goods must have a mass"):
        crate_recipe(tmp_path, mass=0)
