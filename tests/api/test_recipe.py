from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import warehouse_sim as ws
from tests.api.crates import write_crate
from warehouse_sim.errors import ConfigError, InputError, UnknownNameError, WarehouseSimError
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.generation.recipe.difficulty import with_difficulty
from warehouse_sim.scene import sample_scene


def test_nothing_changed_is_the_shipped_recipe() -> None:
    assert ws.recipe("demo").resolved == load_recipe("demo")


def test_a_rig_replaces_all_sensors_and_says_what_carries_it() -> None:
    rig = ws.Rig(camera="wide", lidar="vlp16", on="forklift", height=1.2)
    recipe = ws.recipe("selective_rack", sensors=rig, light="night", visible=(0.4, 0.6))
    sensors, scene = recipe.resolved.sensors, recipe.resolved.scene
    assert sensors == rig.config
    assert sensors.camera == ws.Camera("wide").rig.camera
    assert sensors.lidar is not None
    assert sensors.lidar.model == "vlp16"
    assert not sensors.lidars
    assert not sensors.more
    assert scene.viewpoints.kind == "forklift_mast"
    assert scene.viewpoints.height is not None
    assert (scene.viewpoints.height.low, scene.viewpoints.height.high) == (1.2, 1.2)
    assert scene.lights.preset == "night"
    assert recipe.settings["occlusion"]["visible_fraction"][0]["min"] == 0.4
    assert recipe.settings["occlusion"]["visible_fraction"][0]["max"] == 0.6


def test_other_settings_are_those_of_a_file(tmp_path: Path) -> None:
    given = {"scene": {"layout": {"bays": 2}}, "scenes": 7}
    recipe = ws.recipe("demo", settings=given, views=3, targets=["pallet", "carton"])
    (tmp_path / "mine.yaml").write_text(
        "extends: demo\nscene: {layout: {bays: 2}, observations_per_scene: 3, targets: [pallet, carton]}\nscenes: 7\n"
    )
    expected = ws.recipe(tmp_path / "mine.yaml").settings
    assert {**recipe.settings, "name": "mine"} == expected


def test_presets_show_themselves_by_the_name_they_were_given() -> None:
    assert repr(ws.Rig(camera="d435_720p", lidar="os1_64")) == "<Rig camera 1280 x 720 px, LiDAR os1_64>"
    assert repr(ws.Rig(rig="kitti")) == "<Rig camera 1224 x 370 px, LiDAR hdl64e>"


def test_difficulty_is_that_of_the_command() -> None:
    assert ws.recipe("smoke", difficulty=1).resolved == with_difficulty(load_recipe("smoke"), 1.0)


def test_a_recipe_is_changed_further_and_stays_as_it_was() -> None:
    first = ws.recipe("smoke", views=4)
    second = ws.recipe(first, scenes=9)
    assert (first.resolved.scenes, second.resolved.scenes) == (3, 9)
    assert second.resolved.scene.observations_per_scene == 4


def test_what_is_saved_is_read_again(tmp_path: Path) -> None:
    recipe = ws.recipe("smoke", light="dim", sensors=ws.Camera("kitti"), visible=(0.2, 0.5))
    recipe.save(tmp_path / "deep" / "mine.yaml")
    assert ws.recipe(tmp_path / "deep" / "mine.yaml").resolved == recipe.resolved


def test_an_own_mesh_stands_on_the_floor_and_on_pallets_with_labels(tmp_path: Path) -> None:
    recipe = ws.recipe("smoke")
    recipe.add(write_crate(tmp_path), name="bottle_crate", places=["shelf", "floor"], fraction=1.0, count=(2, 2))
    assert recipe.resolved.scene.targets == ("pallet", "bottle_crate")
    scene = sample_scene(recipe.resolved.scene, 0, 0)
    crates = [item for item in scene.instances if item.model == "bottle_crate"]
    loose = [item for item in crates if item.group]
    assert len(crates) > len(loose) + 1 >= 3
    assert scene.models["bottle_crate"].size.tolist() == pytest.approx([0.5, 0.35, 0.2])  # y of GLB is up


@pytest.mark.parametrize(
    ("call", "error", "words"),
    [
        (lambda: ws.recipe("dmo"), UnknownNameError, ["'dmo'", "demo"]),
        (lambda: ws.recipe(5), InputError, ["recipe", "5"]),  # type: ignore[arg-type]
        (lambda: ws.recipe("demo", lights="night"), InputError, ["did you mean 'light'"]),  # type: ignore[call-arg]
        (lambda: ws.recipe("demo", light="nigth"), InputError, ["light", "'night'", "'nigth'"]),  # type: ignore[arg-type]
        (lambda: ws.recipe("demo", visible=(0.6, 0.4)), ConfigError, ["visible_fraction", "min < max", "0.6"]),
        (lambda: ws.recipe("demo", visible=(0.2, 2.0)), WarehouseSimError, ["0-1"]),
        (lambda: ws.Rig(camera="d435_720"), WarehouseSimError, ["did you mean 'd435_720p'"]),
        (lambda: ws.recipe("demo", visible=0.5), InputError, ["visible", "0.5"]),  # type: ignore[arg-type]
        (lambda: ws.recipe("demo", settings={"scene": {"layuot": {}}}), ConfigError, ["layuot", "layout"]),
        (lambda: ws.recipe("demo", sensors="forklift_mats"), UnknownNameError, ["rig", "forklift_mast"]),
        (lambda: ws.recipe("demo", views=0), WarehouseSimError, ["observations_per_scene", "1-1,000"]),
        (lambda: ws.Rig(on="forklft"), UnknownNameError, ["'forklft'", "forklift"]),
        (lambda: ws.Rig(lidar="os1_46"), ConfigError, ["'os1_46'", "os1_128"]),
        (lambda: ws.Rig(lidar="OS1-64"), ConfigError, ["'OS1-64'", "did you mean 'os1_64'?"]),
        (lambda: ws.recipe("smoke", difficulty=2), InputError, ["difficulty must be 0-1"]),
        (lambda: ws.Rig(height=0.0), InputError, ["height", "0.1-20 m"]),
        (lambda: ws.Rig(height="high"), InputError, ["height", "'high'"]),  # type: ignore[arg-type]
        (lambda: ws.recipe("smoke").add("none.glb"), ConfigError, ["none.glb", "there is no such file"]),
        (lambda: ws.recipe("smoke").add("none.glb", places=["roof"]), InputError, ["places", "shelf"]),  # type: ignore[list-item]
        (lambda: ws.recipe("smoke").add("none.glb", name="My Crate"), ConfigError, ["'My Crate'", "'my_crate'"]),
        (lambda: ws.recipe("smoke").add("epall"), UnknownNameError, ["'epall'"]),
        (lambda: ws.recipe("smoke").add("epal1", fraction=2.0), ConfigError, ["fraction", "2.0"]),
    ],
)
def test_what_does_not_fit_is_said_in_one_line(
    call: Callable[[], Any], error: type[Exception], words: list[str]
) -> None:
    with pytest.raises(error) as caught:
        call()
    assert all(word in str(caught.value) for word in words), str(caught.value)
    assert "\n" not in str(caught.value)
