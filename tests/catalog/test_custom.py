"""Objects that users bring, and what is said when something is wrong with them."""

import os
from pathlib import Path

import numpy as np
import pytest
import trimesh
import yaml

from tests.catalog.covering import volume
from warehouse_sim.catalog.custom import load_custom_object
from warehouse_sim.catalog.materials import materials
from warehouse_sim.errors import ConfigError
from warehouse_sim.geometry.pose import make_transform
from warehouse_sim.physics import settle_scene
from warehouse_sim.physics.settle import SettleConfig
from warehouse_sim.scene.draft import SceneDraft
from warehouse_sim.schema import SceneSpec

EXAMPLE = Path(__file__).parents[2] / "examples" / "custom_object" / "trolley.yaml"
SETTINGS = {"name": "crate", "class_name": "crate", "obj_id": 1001, "file": "crate.obj", "material": "kraft"}


def write_object(folder: Path, **changes: object) -> Path:
    """Store a crate of 0.4 x 0.3 x 0.2 m in some place of its file, and its YAML file with ``changes``."""
    mesh = trimesh.creation.box(extents=(0.4, 0.3, 0.2))
    mesh.apply_translation((3.0, -1.0, 0.5))
    (folder / "crate.obj").write_text("o body\n" + mesh.export(file_type="obj"))
    settings = {key: value for key, value in {**SETTINGS, **changes}.items() if value is not None}
    (folder / "crate.yaml").write_text(yaml.safe_dump(settings))
    return folder / "crate.yaml"


def test_the_worked_example_is_an_object_with_origin_at_its_centre() -> None:
    model = load_custom_object(EXAMPLE)
    assert (model.name, model.class_name, model.obj_id, model.mass) == ("tool_trolley", "trolley", 1001, 38.0)
    np.testing.assert_allclose(model.size, [0.86, 0.5, 0.91], atol=1e-9)
    vertices = model.mesh().vertices
    np.testing.assert_allclose(vertices.max(axis=0), model.size / 2, atol=1e-9)
    np.testing.assert_allclose(vertices.min(axis=0), -model.size / 2, atol=1e-9)
    assert len(model.parts) == len(model.collision) == 13
    assert {part.material for part in model.parts} == {"truck_grey", "truck_red", "rubber"} <= set(materials())
    assert len(model.symmetry) == 1
    box_volume = sum(float(np.prod(box.size)) for box in model.collision)
    assert volume(model.mesh()) == pytest.approx(box_volume)  # all parts of the trolley are boxes that look outwards


def test_defaults_give_one_collision_box_about_the_centre(tmp_path: Path) -> None:
    model = load_custom_object(write_object(tmp_path, symmetry="cuboid"))
    np.testing.assert_allclose(model.size, [0.4, 0.3, 0.2])
    (box,) = model.collision
    np.testing.assert_allclose(box.size, model.size)
    np.testing.assert_allclose(box.T_parent_box, np.eye(4))
    assert len(model.symmetry) == 4
    assert volume(model.mesh()) == pytest.approx(0.4 * 0.3 * 0.2)


def test_a_scene_takes_it_and_things_stand_on_its_upper_tray() -> None:
    trolley, draft = load_custom_object(EXAMPLE), SceneDraft()
    floor = draft.add("floor_slab", make_transform(translation=np.array([0.0, 0.0, -0.1])))
    cart = draft.add(trolley, make_transform(translation=np.array([0.0, 0.0, trolley.size[2] / 2])))
    # The upper tray's top is 0.81 m above the ground, between the handle and the other end.
    box = draft.add("carton_400x300x200", make_transform(translation=np.array([0.05, 0.0, 0.81 + 0.1])), group=1)
    spec = SceneSpec(0, 0, draft.models, materials(), (floor, cart, box), (), ())
    settled, report = settle_scene(spec, SettleConfig())
    assert report.problems == ()
    assert settled.instances[1].model == "tool_trolley"
    assert settled.instances[2].T_world_object[2, 3] == pytest.approx(0.91, abs=0.002)


@pytest.mark.parametrize(("up", "size"), [("x", (0.2, 0.3, 0.4)), ("y", (0.4, 0.2, 0.3)), ("z", (0.4, 0.3, 0.2))])
def test_the_axis_that_is_up_becomes_z(tmp_path: Path, up: str, size: tuple[float, ...]) -> None:
    model = load_custom_object(write_object(tmp_path, up=up, scale=0.5))
    np.testing.assert_allclose(model.size, np.array(size) / 2)
    assert volume(model.mesh()) == pytest.approx(0.4 * 0.3 * 0.2 / 8)


def test_turns_and_listed_boxes(tmp_path: Path) -> None:
    boxes = [{"size": [0.4, 0.3, 0.1], "centre": [0, 0, -0.05]}, {"size": [0.1, 0.1, 0.1], "centre": [0, 0, 0.05]}]
    model = load_custom_object(write_object(tmp_path, symmetry={"axis": "z", "count": 2}, collision=boxes))
    assert len(model.symmetry) == 2
    assert [box.size.tolist() for box in model.collision] == [[0.4, 0.3, 0.1], [0.1, 0.1, 0.1]]
    np.testing.assert_allclose(model.collision[1].T_parent_box[:3, 3], [0, 0, 0.05])


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"widht": 1}, r"crate\.yaml: widht is not a setting"),
        ({"file": None}, r"crate\.yaml: the setting 'file' is missing"),
        ({"file": "ghost.obj"}, r"crate\.yaml: file: 'ghost\.obj' does not exist"),
        ({"file": "../crate.obj"}, r"crate\.yaml: file: '\.\./crate\.obj' leaves the folder"),
        ({"file": "/etc/hostname"}, r"crate\.yaml: file: '/etc/hostname' leaves the folder"),
        ({"file": "crate.yaml"}, r"crate\.yaml: file: crate\.yaml has the suffix '\.yaml'; known: \.obj, \.ply, \.stl"),
        ({"name": "epal1"}, r"crate\.yaml: name: 'epal1' is an object of the catalog"),
        ({"name": "My crate"}, r"crate\.yaml: name: 'My crate' must be lower case"),
        ({"obj_id": 7}, r"crate\.yaml: obj_id must be 1,000-999,999, found 7"),
        ({"mass": -1}, r"crate\.yaml: mass must be 0-20,000 kg, found -1"),
        ({"mass": "heavy"}, r"crate\.yaml: mass must be float, found 'heavy'"),
        ({"scale": 0}, r"crate\.yaml: scale must be 0.000001-1,000"),
        ({"scale": 1000}, r"crate\.yaml: scale: the object is 400 x 300 x 200 m; 0\.001 is for millimetres"),
        ({"up": "w"}, r"crate\.yaml: up must be one of 'x', 'y', 'z', found 'w'"),
        ({"material": None}, r"crate\.yaml: material: part 'body' has none"),
        ({"material": "krft"}, r"crate\.yaml: material: unknown material 'krft'; known: .*kraft"),
        ({"material": "krft", "materials": {"body": "kraft"}}, r"crate\.yaml: material: unknown material 'krft'"),
        ({"materials": {"lid": "kraft"}}, r"crate\.yaml: materials: the file has no part 'lid'; it has body"),
        ({"materials": {"body": "krft"}}, r"crate\.yaml: materials\.body: unknown material 'krft'"),
        ({"symmetry": "cubiod"}, r"crate\.yaml: symmetry: kind must be one of .* found 'cubiod'"),
        ({"symmetry": {"axis": "z", "count": 4}}, r"crate\.yaml: symmetry: it would turn a box of 0\.4 x 0\.3 x 0\.2"),
        ({"symmetry": {"axis": "z", "count": 1}}, r"crate\.yaml: symmetry: count must be 2-360, found 1"),
        ({"collision": "hull"}, r"crate\.yaml: collision must be box, parts or a list of boxes"),
        ({"collision": [{"size": [1, 1, 1]}]}, r"crate\.yaml: collision\[0\]: the box leaves the object"),
        (
            {"collision": [{"sise": [1, 1, 1]}]},
            r"crate\.yaml: collision: boxes\[0\]: sise is not .* did you mean 'size'",
        ),
    ],
)
def test_what_is_wrong_is_named_by_file_and_key(tmp_path: Path, changes: dict[str, object], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        load_custom_object(write_object(tmp_path, **changes))


def test_a_link_out_of_the_folder_is_rejected(tmp_path: Path) -> None:
    inside = tmp_path / "inside"
    inside.mkdir()
    path = write_object(inside, file="link.obj")
    (tmp_path / "secret.obj").write_text("v 0 0 0\n")
    os.symlink(tmp_path / "secret.obj", inside / "link.obj")
    with pytest.raises(ConfigError, match=r"crate\.yaml: file: 'link\.obj' leaves the folder"):
        load_custom_object(path)


def test_too_many_triangles_are_rejected(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("warehouse_sim.catalog.mesh_files.MAX_TRIANGLES", 11)
    with pytest.raises(
        ConfigError, match=r"crate\.yaml: file: crate\.obj has 12 triangles or more; simplify it to 11 at most"
    ):
        load_custom_object(write_object(tmp_path))
