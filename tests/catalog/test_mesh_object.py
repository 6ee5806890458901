from pathlib import Path

import pytest

from tests.api.crates import write_crate
from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.custom_config import FIRST_OBJ_ID
from warehouse_sim.catalog.own_files import is_mesh_name, mesh_name
from warehouse_sim.errors import ConfigError


def test_a_mesh_alone_is_an_object_of_its_own_class(tmp_path: Path) -> None:
    path = write_crate(tmp_path, "Bottle Crate 2", (0.6, 0.2, 0.4))
    model = catalog_object(str(path))
    assert (model.name, model.class_name) == ("bottle_crate_2", "bottle_crate_2")
    assert model.size.tolist() == pytest.approx([0.6, 0.4, 0.2])  # the y axis of GLB is up
    assert model.mass == pytest.approx(150 * 0.6 * 0.4 * 0.2)
    assert FIRST_OBJ_ID <= model.obj_id < 1_000_000
    assert len(model.collision) == 1
    assert catalog_object(str(path)) is model


def test_a_name_behind_the_path_is_that_of_the_object(tmp_path: Path) -> None:
    path = write_crate(tmp_path)
    one, two = catalog_object(mesh_name(path, "one")), catalog_object(mesh_name(path, "two"))
    assert (one.name, two.name) == ("one", "two")
    assert one.obj_id != two.obj_id
    assert is_mesh_name(f"{path}#one")
    assert not is_mesh_name("epal1")
    assert not is_mesh_name("crate.yaml")


@pytest.mark.parametrize("name", ["crate.fbx", "shelf.png#mine"])
def test_a_file_of_another_kind_is_no_unknown_name(name: str) -> None:
    with pytest.raises(ConfigError, match=r"an object is no \.\w+ file; known: \.yaml, \.obj"):
        catalog_object(name)


def test_a_yaml_file_beside_it_says_what_it_is(tmp_path: Path) -> None:
    path = write_crate(tmp_path)
    text = "name: bottle_crate\nclass_name: crate\nobj_id: 1010\nfile: crate.glb\nmass: 14\nmaterial: plastic_red\n"
    (tmp_path / "crate.yaml").write_text(text)
    model = catalog_object(str(path))
    assert (model.name, model.class_name, model.obj_id, model.mass) == ("bottle_crate", "crate", 1010, 14.0)
    assert catalog_object(f"{path}#mine").name == "mine"


@pytest.mark.parametrize(
    ("size", "words"),
    [((400.0, 300.0, 200.0), "scale: the object is 400 x 200 x 300 m"), ((0.001, 0.001, 0.001), "scale")],
)
def test_a_mesh_in_other_units_is_an_error(size: tuple[float, float, float], words: str, tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=words):
        catalog_object(str(write_crate(tmp_path, size=size)))


def test_what_is_no_mesh_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"no such mesh file"):
        catalog_object(str(tmp_path / "none.glb"))
    (tmp_path / "broken.glb").write_bytes(b"glTF")
    with pytest.raises(ConfigError, match=r"broken.glb cannot be read"):
        catalog_object(str(tmp_path / "broken.glb"))
    with pytest.raises(ConfigError, match=r"'pallet_wood'|choose another"):
        catalog_object(mesh_name(write_crate(tmp_path), "epal1"))


def test_an_edited_file_is_read_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whoever edits an object in a session, or works in another folder, gets what its files say there and now."""
    path, text = write_crate(tmp_path), "class_name: crate\nobj_id: 1010\nfile: crate.glb\nmass: {}\nmaterial: kraft\n"
    described = tmp_path / "crate.yaml"
    monkeypatch.chdir(tmp_path)
    alone = catalog_object("crate.glb")
    described.write_text("name: one\n" + text.format(14))
    one = catalog_object("crate.yaml")
    assert (alone.name, one.name, catalog_object("crate.glb").name) == ("crate", "one", "one")
    assert catalog_object("crate.yaml") is one
    described.write_text("name: two\n" + text.format(9))
    assert (catalog_object("crate.yaml").name, catalog_object(str(path)).mass) == ("two", 9.0)
    write_crate(tmp_path, size=(0.6, 0.2, 0.4))
    assert catalog_object("crate.yaml").size.tolist() == pytest.approx([0.6, 0.4, 0.2])
    (tmp_path / "other").mkdir()
    monkeypatch.chdir(tmp_path / "other")
    with pytest.raises(ConfigError, match=r"crate\.yaml"):
        catalog_object("crate.yaml")
