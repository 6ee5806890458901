"""The same shape from every format."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

from tests.api.crates import write_crate
from tests.catalog.covering import volume
from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.custom_config import FIRST_OBJ_ID
from warehouse_sim.catalog.mesh_files import read_parts
from warehouse_sim.catalog.own_files import is_mesh_name, mesh_name
from warehouse_sim.errors import ConfigError

EXTENTS = (0.4, 0.3, 0.2)


def two_parts() -> trimesh.Scene:
    """A body and a lid beside it, 1 m up; the lid is placed by a mirroring transform."""
    scene = trimesh.Scene()
    scene.add_geometry(trimesh.creation.box(extents=EXTENTS), node_name="body", geom_name="body")
    mirrored = np.diag([1.0, -1.0, 1.0, 1.0])
    mirrored[:3, 3] = (0.5, 0.0, 1.0)
    scene.add_geometry(trimesh.creation.box(extents=EXTENTS), node_name="lid", geom_name="lid", transform=mirrored)
    return scene


def test_glb_has_y_up_named_nodes_and_no_part_inside_out(tmp_path: Path) -> None:
    (tmp_path / "a.glb").write_bytes(two_parts().export(file_type="glb"))
    parts = read_parts(tmp_path / "a.glb", None, None)
    assert sorted(parts) == ["body", "lid"]
    np.testing.assert_allclose(np.ptp(parts["body"].vertices, axis=0), [0.4, 0.2, 0.3], atol=1e-6)
    np.testing.assert_allclose(parts["lid"].vertices.mean(axis=0), [0.5, -1.0, 0.0], atol=1e-6)
    assert [volume(part) for part in parts.values()] == pytest.approx([0.024, 0.024], rel=1e-5)
    flat = read_parts(tmp_path / "a.glb", "z", 2.0)
    np.testing.assert_allclose(np.ptp(flat["body"].vertices, axis=0), [0.8, 0.6, 0.4], atol=1e-6)


def test_ply_has_one_part_called_as_the_file(tmp_path: Path) -> None:
    (tmp_path / "block.ply").write_bytes(trimesh.creation.box(extents=EXTENTS).export(file_type="ply"))
    parts = read_parts(tmp_path / "block.ply", None, None)
    assert list(parts) == ["block"]
    np.testing.assert_allclose(np.ptp(parts["block"].vertices, axis=0), EXTENTS, atol=1e-6)


@pytest.mark.parametrize("kind", ["ply", "stl", "stl_ascii"])
def test_other_dialects_are_the_same_box(tmp_path: Path, kind: str) -> None:
    content = trimesh.creation.box(extents=EXTENTS).export(
        file_type=kind, **({"encoding": "ascii"} if kind == "ply" else {})
    )
    path = tmp_path / f"block.{kind[:3]}"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    (part,) = read_parts(path, None, None).values()
    np.testing.assert_allclose(np.ptp(part.vertices, axis=0), EXTENTS, atol=1e-6)
    assert volume(part) == pytest.approx(float(np.prod(EXTENTS)), rel=1e-5)


def write_usd(path: Path, up: str, metres: float, left_handed: bool = False) -> None:
    from pxr import Gf, Usd, UsdGeom

    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageUpAxis(stage, up)
    UsdGeom.SetStageMetersPerUnit(stage, metres)
    box = trimesh.creation.box(extents=np.array(EXTENTS) / metres)
    UsdGeom.Xform.Define(stage, "/crate").AddTranslateOp().Set(Gf.Vec3d(0, 0, 1 / metres))
    mesh = UsdGeom.Mesh.Define(stage, "/crate/body")
    mesh.CreatePointsAttr(box.vertices.astype(np.float32))
    mesh.CreateFaceVertexCountsAttr(np.full(12, 3, np.int32))
    faces = box.faces[:, ::-1] if left_handed else box.faces
    mesh.CreateFaceVertexIndicesAttr(faces.astype(np.int32).ravel())
    if left_handed:
        mesh.CreateOrientationAttr(UsdGeom.Tokens.leftHanded)
    stage.GetRootLayer().Save()


@pytest.mark.parametrize(("up", "size"), [("Z", (0.4, 0.3, 0.2)), ("Y", (0.4, 0.2, 0.3))])
@pytest.mark.parametrize("left_handed", [False, True])
def test_usd_says_unit_and_axis_itself(tmp_path: Path, up: str, size: tuple[float, ...], left_handed: bool) -> None:
    write_usd(tmp_path / "a.usda", up, 0.01, left_handed)
    parts = read_parts(tmp_path / "a.usda", None, None)
    assert list(parts) == ["body"]
    np.testing.assert_allclose(np.ptp(parts["body"].vertices, axis=0), size, atol=1e-6)
    assert volume(parts["body"]) == pytest.approx(0.024, rel=1e-5)


def test_a_usd_stage_that_leaves_its_folder_is_rejected(tmp_path: Path) -> None:
    from pxr import Usd

    (tmp_path / "inside").mkdir()
    write_usd(tmp_path / "outside.usda", "Z", 1.0)
    stage = Usd.Stage.CreateNew(str(tmp_path / "inside" / "a.usda"))
    stage.DefinePrim("/it").GetReferences().AddReference("../outside.usda", "/crate")
    stage.GetRootLayer().Save()
    with pytest.raises(ConfigError, match=r"a\.usda refers to .*outside\.usda, outside its folder"):
        read_parts(tmp_path / "inside" / "a.usda", None, None)


def test_obj_names_parts_by_object_and_counts_backwards(tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_text(
        "mtllib ../colours.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1/1 2/2 3/3 4/4\n"
        "o lid\nv 0 0 1\nv 1 0 1\nv 1 1 1\nf -3//1 -2//1 -1//1\n"
    )
    parts = read_parts(tmp_path / "a.obj", None, None)
    assert list(parts) == ["a", "lid"]
    assert parts["a"].faces.tolist() == [[0, 1, 2], [0, 2, 3]]
    assert parts["lid"].vertices.tolist() == [[0, 0, 1], [1, 0, 1], [1, 1, 1]]


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.obj", "v 0 0 0\nv 1 0 zero\n", r"a\.obj: line 2: 'v 1 0 zero' cannot be read"),
        ("a.obj", "v 0 0 0\nf 1 2 3\n", r"a\.obj: line 2: 'f 1 2 3' cannot be read \(there is no vertex 2 yet\)"),
        ("a.obj", "v 0 0 0\n", r"a\.obj holds no triangles"),
        ("a.obj", "v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", r"a\.obj: part 'a' has vertices that are not finite"),
        ("a.glb", "no glb at all", r"a\.glb cannot be read"),
        ("a.ply", "no ply at all", r"a\.ply cannot be read"),
        ("a.usda", "no usd at all", r"a\.usda cannot be read"),
        ("a.dae", "", r"a\.dae has the suffix '\.dae'; known: \.obj, \.ply, \.stl, \.glb, \.usd"),
    ],
)
def test_a_broken_file_is_named(tmp_path: Path, name: str, content: str, message: str) -> None:
    (tmp_path / name).write_text(content)
    with pytest.raises(ConfigError, match=message):
        read_parts(tmp_path / name, None, None)


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
    with pytest.raises(ConfigError, match=r"there is no such file"):
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
