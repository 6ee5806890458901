import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh

from tests.dataset.toy import CAMERA, CARTON, PALLET, make_dataset, make_manifest, make_scene, observe
from warehouse_sim.dataset.formats.bop.models import even_mesh, symmetry_rows, write_models
from warehouse_sim.dataset.formats.bop.writer import BopWriter, TargetLists
from warehouse_sim.dataset.formats.observation_files import ObservationFiles
from warehouse_sim.dataset.objects import write_objects
from warehouse_sim.dataset.validate import validate
from warehouse_sim.errors import DatasetError
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.geometry.pose import invert
from warehouse_sim.geometry.symmetry import SymmetryGroup

TRAIN = Path("bop/train/000000")


def table(root: Path, name: str) -> dict:
    return json.loads((root / TRAIN / f"scene_{name}.json").read_text())


def test_camera_row(toy_root: Path) -> None:
    gt = observe(make_scene(0))[0]
    row = table(toy_root, "camera")["0"]
    assert row["cam_K"] == [110.0, 0.0, 81.3, 0.0, 112.0, 47.6, 0.0, 0.0, 1.0]
    assert row["depth_scale"] == 1.0
    T_camera_world = invert(gt.T_world_camera)
    assert np.array_equal(np.reshape(row["cam_R_w2c"], (3, 3)), T_camera_world[:3, :3])
    assert np.allclose(row["cam_t_w2c"], T_camera_world[:3, 3] * 1000, rtol=0, atol=1e-9)
    defaults = json.loads((toy_root / "bop" / "camera.json").read_text())
    assert defaults == {
        **{key: getattr(CAMERA, key) for key in ("fx", "fy", "cx", "cy", "width", "height")},
        "depth_scale": 1.0,
    }


def test_gt_info_follows_the_toolkit_definitions(toy_root: Path) -> None:
    """Recompute every number from an amodal mask pasted into a canvas of 3 x 3 images."""
    gt, rows = observe(make_scene(0))[0], table(toy_root, "gt_info")["0"]
    h, w = gt.rgbd.depth.shape
    truncated = 0
    for annotation, row in zip(gt.annotations, rows, strict=True):
        canvas = np.zeros((3 * h, 3 * w), dtype=bool)
        left, top = annotation.amodal_mask_offset
        sh, sw = annotation.amodal_mask.shape
        canvas[h + top : h + top + sh, w + left : w + left + sw] = annotation.amodal_mask
        inside = canvas[h : 2 * h, w : 2 * w]
        visible = gt.buffers.instance_mask == annotation.instance_id
        ys, xs = np.nonzero(canvas)
        vy, vx = np.nonzero(visible)
        assert row == {
            "bbox_obj": [xs.min() - w, ys.min() - h, np.ptp(xs), np.ptp(ys)],
            "bbox_visib": [vx.min(), vy.min(), np.ptp(vx), np.ptp(vy)],
            "px_count_all": canvas.sum(),
            "px_count_valid": (gt.rgbd.depth[inside] > 0).sum(),
            "px_count_visib": visible.sum(),
            "visib_fract": visible.sum() / canvas.sum(),
            "instance_id": annotation.instance_id,
        }
        truncated += canvas.sum() > inside.sum()
    assert rows[0]["visib_fract"] < 0.9, "the carton must hide a part of the first pallet"
    assert truncated == 1


@pytest.mark.parametrize("kind", ["models", "models_eval"])
def test_models_load_elsewhere_and_have_their_stated_size(tmp_path: Path, kind: str) -> None:
    write_models(tmp_path, [CARTON, PALLET])
    infos = json.loads((tmp_path / kind / "models_info.json").read_text())
    assert list(infos) == ["1", "7"]
    for model in (PALLET, CARTON):
        mesh = trimesh.load(tmp_path / kind / f"obj_{model.obj_id:06d}.ply", process=False)
        info = infos[str(model.obj_id)]
        size_mm = model.size * 1000
        assert np.allclose(mesh.extents, size_mm, rtol=0, atol=1e-3)
        assert np.allclose([info[f"size_{axis}"] for axis in "xyz"], size_mm, rtol=0, atol=1e-3)
        assert np.allclose([info[f"min_{axis}"] for axis in "xyz"], -size_mm / 2, rtol=0, atol=1e-3)
        assert info["diameter"] == pytest.approx(np.linalg.norm(size_mm), rel=1e-6)
        expected = model.symmetry.transforms[1:].reshape(-1, 16).tolist()
        assert info["symmetries_discrete"] == expected
        assert mesh.area == pytest.approx(model.mesh().face_areas().sum() * 1e6, rel=1e-5)
        # Parts that touch are still closed boxes of their own.
        assert trimesh.Trimesh(mesh.vertices, mesh.faces, process=False).is_watertight


def test_header_uses_the_type_names_that_the_toolkit_knows(toy_root: Path) -> None:
    header = (toy_root / "bop" / "models" / "obj_000001.ply").read_bytes().split(b"end_header")[0].decode()
    properties = [line.split()[1:] for line in header.splitlines() if line.startswith("property")]
    assert properties == [["float", "x"], ["float", "y"], ["float", "z"], ["list", "uchar", "int", "vertex_indices"]]
    assert "format binary_little_endian 1.0" in header


@pytest.mark.parametrize("model", [PALLET, CARTON], ids=lambda model: model.name)
def test_metric_vertices_are_even(model) -> None:
    """Every patch of the surface has its fraction of vertices."""
    mesh = even_mesh(model)
    assert 2000 <= len(mesh.vertices) <= 4000
    edges = mesh.vertices[mesh.faces] - mesh.vertices[np.roll(mesh.faces, 1, axis=1)]
    lengths = np.linalg.norm(edges, axis=2)
    spacing = np.sqrt(mesh.face_areas().sum() / len(mesh.vertices))
    assert lengths.max() < 2.5 * spacing
    assert np.median(lengths) > 0.4 * spacing


def test_targets_count_what_is_visible_enough(tmp_path: Path) -> None:
    manifest = make_manifest()
    write_objects(tmp_path, [PALLET])
    writer = BopWriter(tmp_path, manifest)
    writer.begin([PALLET], CAMERA)
    scene = writer.scene(make_scene(2))
    for observation in observe(make_scene(2)):
        first, *others = observation.annotations or [None]
        if first is not None:
            hidden = replace(first, pixels_visible=first.pixels_all // 11)
            observation = replace(observation, annotations=(hidden, *others))
        scene.write(ObservationFiles(observation))
    scene.finish()
    writer.finish()
    rows = json.loads((tmp_path / "bop" / "test_targets_bop19.json").read_text())
    assert rows == [{"scene_id": 2, "im_id": 0, "obj_id": 1, "inst_count": 2}]
    rows = json.loads((tmp_path / "bop" / "test_targets_bop24.json").read_text())
    assert rows == [{"scene_id": 2, "im_id": 0}, {"scene_id": 2, "im_id": 1}]
    coco = json.loads((tmp_path / "bop" / "test" / "000002" / "scene_gt_coco.json").read_text())
    assert [annotation["ignore"] for annotation in coco["annotations"]] == [True, False, False]


def test_targets_are_listed_by_object(tmp_path: Path) -> None:
    lists, seen = TargetLists(), {"visib_fract": 0.5}
    lists.add(3, 4, [{"obj_id": number} for number in (7, 2, 7, 5)], [seen, seen, seen, {"visib_fract": 0.09}])
    lists.write(tmp_path)
    rows = json.loads((tmp_path / "test_targets_bop19.json").read_text())
    assert [(row["obj_id"], row["inst_count"]) for row in rows] == [(2, 1), (7, 2)]


def test_object_without_model_is_rejected(tmp_path: Path) -> None:
    write_objects(tmp_path, [CARTON])
    writer = BopWriter(tmp_path, make_manifest())
    writer.begin([CARTON], CAMERA)
    with pytest.raises(DatasetError, match=r"obj_id 1 is not among the dataset's objects \[7\]"):
        writer.scene(make_scene(0)).write(ObservationFiles(observe(make_scene(0))[0]))


@pytest.mark.parametrize("over", [False, True])
def test_a_shape_of_revolution_has_a_continuous_symmetry(over: bool) -> None:
    """bop_toolkit's rule: each discrete motion, then any turn; together they cover the group, and no more than it."""
    turns = SymmetryGroup.turns("z", 72).transforms
    flip = np.diag([1.0, -1.0, -1.0, 1.0])
    group = SymmetryGroup(np.concatenate([turns, turns @ flip]) if over else turns)
    rows = symmetry_rows(group)
    assert rows["symmetries_continuous"] == [{"axis": [0.0, 0.0, 1.0], "offset": [0.0, 0.0, 0.0]}]
    discrete = np.reshape(rows.get("symmetries_discrete", []), (-1, 4, 4))
    assert len(discrete) == over
    for T in group.transforms:
        rests = [np.linalg.inv(D) @ T for D in (np.eye(4), *discrete)]
        assert sum(np.allclose(rest[:3, 2], [0, 0, 1]) for rest in rests) == 1


def test_few_turns_and_boxes_are_discrete() -> None:
    assert len(symmetry_rows(SymmetryGroup.turns("z", 12))["symmetries_discrete"]) == 11
    assert list(symmetry_rows(SymmetryGroup.cuboid())) == ["symmetries_discrete"]
    assert symmetry_rows(SymmetryGroup.trivial()) == {}


def test_cylinders_are_written_and_checked(tmp_path: Path) -> None:
    angles = 2 * np.pi * np.arange(72) / 72
    ring = np.stack([0.3 * np.cos(angles), 0.3 * np.sin(angles)], axis=1)
    hull = trimesh.Trimesh([[*p, z] for z in (-0.4, 0.4) for p in ring]).convex_hull
    part = replace(CARTON.parts[0], mesh=TriangleMesh(hull.vertices, hull.faces), scale=np.ones(3))
    drum = replace(CARTON, size=np.array([0.6, 0.6, 0.8]), parts=(part,), symmetry=SymmetryGroup.turns("z", 72))
    root = make_dataset(tmp_path / "data", make_manifest(formats=("bop",)))
    write_objects(root, [PALLET, drum])
    write_models(root / "bop", [PALLET, drum])
    check = {check.name: check for check in validate(root)}["bop models"]
    assert check.ok, check
    path = root / "bop" / "models" / "models_info.json"
    table = json.loads(path.read_text())
    table["7"]["symmetries_continuous"][0]["axis"] = [1.0, 0.0, 0.0]
    path.write_text(json.dumps(table))
    check = {check.name: check for check in validate(root)}["bop models"]
    assert "symmetries_continuous differ from objects.json" in check.detail
