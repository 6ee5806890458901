"""Normals, object coordinates and class masks as stored, against rays of another program and against other files."""

import json
import shutil
from pathlib import Path

import cv2
import numpy as np
import pytest
import trimesh
from trimesh.ray.ray_pyembree import RayMeshIntersector

import warehouse_sim as ws
from tests.dataset.viewing.test_view import rows
from tests.shared import Shared, hashes
from warehouse_sim.dataset.convert.run import convert
from warehouse_sim.dataset.manifest import read_manifest
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.shards.merge import merge
from warehouse_sim.dataset.shards.shard import Shard
from warehouse_sim.dataset.validate import validate
from warehouse_sim.dataset.viewing.stream import open_recording, stream_images
from warehouse_sim.errors import DatasetError, RenderError
from warehouse_sim.generation.generate import generate
from warehouse_sim.generation.plan import GenerateConfig, plan_dataset
from warehouse_sim.generation.recipe import Recipe, changed, load_recipe
from warehouse_sim.generation.scene import prepare_scene
from warehouse_sim.generation.stream import stream
from warehouse_sim.generation.verify import fraction_off
from warehouse_sim.schema import SceneSpec

pytestmark = pytest.mark.gl

EXACT = ("normals", "object_coordinates", "class_mask")
SCENES, SEED = 2, 3


def wanting(shared: Shared, *outputs: str) -> Recipe:
    return changed(load_recipe(str(shared.small)), {"sensors": {"outputs": list(outputs)}})


@pytest.fixture(scope="module")
def root(shared: Shared) -> Path:
    recipe = wanting(shared, "default", "clean", *EXACT)
    return shared.dataset(recipe, scenes=SCENES, seed=SEED, formats=("bop",))


def stored(root: Path, kind: str, scene: int) -> np.ndarray:
    """Return the numbers in a file by OpenCV alone, colours as R G B."""
    (path,) = root.glob(f"bop/*/{scene:06d}/{kind}/000000.png")
    image = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    assert image.dtype == np.uint16
    return image[..., ::-1].astype(float) if image.ndim == 3 else image.astype(int)


def table(root: Path, name: str, scene: int) -> dict:
    (path,) = root.glob(f"bop/*/{scene:06d}/scene_{name}.json")
    return json.loads(path.read_text())


def rays(root: Path, scene: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the directions of all pixels at z = 1 in the camera frame, and rotation and place of world to camera."""
    camera = table(root, "camera", scene)["0"]
    K, R = (np.array(camera[key]).reshape(3, 3) for key in ("cam_K", "cam_R_w2c"))
    v, u = np.mgrid[:62, :204]
    local = np.stack([(u - K[0, 2]) / K[0, 0], (v - K[1, 2]) / K[1, 1], np.ones(u.shape)], axis=-1)
    return local, R, np.array(camera["cam_t_w2c"]) / 1000.0


def solids(scene: SceneSpec) -> tuple[trimesh.Trimesh, np.ndarray]:
    """Return all that is opaque as one mesh in the world, and the instance id of each of its triangles."""
    meshes, owner = [], []
    for item in scene.instances:
        for part in scene.model_of(item).parts:
            if scene.materials[item.material_of(part)].opacity < 1.0:
                continue
            placed = part.placed()
            mesh = trimesh.Trimesh(placed.vertices, placed.faces, process=False)
            meshes.append(mesh.apply_transform(item.T_world_object))
            owner += [item.instance_id] * len(mesh.faces)
    return trimesh.util.concatenate(meshes), np.array(owner)


@pytest.mark.parametrize("number", range(SCENES))
def test_exact_images_are_what_rays_meet(root: Path, shared: Shared, number: int) -> None:
    scene = prepare_scene(wanting(shared), SEED, number).scene
    mesh, owner = solids(scene)
    local, R, t = rays(root, number)
    origin, flat = -R.T @ t, local.reshape(-1, 3)
    hit = RayMeshIntersector(mesh, scale_to_box=False).intersects_first(np.repeat([origin], len(flat), 0), flat @ R)
    met = (hit >= 0).reshape(local.shape[:2])
    towards = np.einsum("ij,ij->i", mesh.face_normals[hit], flat @ R)
    depth = np.einsum("ij,ij->i", mesh.face_normals[hit], mesh.triangles[hit, 0] - origin) / towards
    world = origin + depth[:, None] * (flat @ R)
    expected = (mesh.face_normals[hit] @ R.T).reshape(local.shape)
    # Beside edges a ray and the rasteriser may meet another face.
    alike = (
        np.einsum("hwi,hwi->hw", expected, np.roll(expected, shift, axis=axis)) > 0.999
        for shift in (1, -1)
        for axis in (0, 1)
    )
    ids = np.where(met, owner[hit].reshape(met.shape), 0)
    same = (ids == np.roll(ids, shift, axis=axis) for shift in (1, -1) for axis in (0, 1))
    inner = met & np.logical_and.reduce([*alike, *same])
    assert inner.mean() > 0.5

    normals = (stored(root, "normals", number) - 32768) / 32767
    cosine = np.einsum("hwi,hwi->hw", normals, expected)
    assert (cosine[inner] > 0.9999).mean() > 0.998

    coordinates, right = stored(root, "object_coordinates", number), []
    for item in scene.target_instances():
        shown = coordinates.any(axis=2) & (ids == item.instance_id)
        T, size = np.linalg.inv(item.T_world_object), scene.model_of(item).size
        place = (world @ T[:3, :3].T + T[:3, 3]).reshape(local.shape)[shown] / size + 0.5
        off = np.abs((coordinates[shown] - 1) / 65534 - np.clip(place, 0, 1)) * size
        right.append(off.max(axis=1) < 0.002)
    assert len(np.concatenate(right)) > 50
    assert np.concatenate(right).mean() > 0.97
    others = inner & ~np.isin(ids, [item.instance_id for item in scene.target_instances()])
    assert not coordinates[others].any()

    names = {int(value): row["class_name"] for value, row in table(root, "class_mask", number).items()}
    class_of = {item.instance_id: scene.model_of(item).class_name for item in scene.instances}
    values = stored(root, "class_mask", number)
    assert [names[value] for value in values[inner]] == [class_of[number] for number in ids[inner]]


@pytest.mark.parametrize("number", range(SCENES))
def test_normals_are_those_of_the_clean_depth(root: Path, number: int) -> None:
    """Cross products of differences over six pixels, as a millimetre of rounding allows."""
    local, _, _ = rays(root, number)
    points = local * stored(root, "depth_clean", number)[..., None] / 1000.0
    normals = (stored(root, "normals", number) - 32768) / 32767
    cross = np.cross(points[6:, 3:-3] - points[:-6, 3:-3], points[3:-3, 6:] - points[3:-3, :-6])
    cross /= np.linalg.norm(cross, axis=2, keepdims=True) + 1e-12
    corners = [normals[3 + i : 59 + i, 3 + j : 201 + j] for i in (-3, 0, 3) for j in (-3, 0, 3)]
    plane = np.logical_and.reduce([(corner == corners[4]).all(axis=2) for corner in corners])
    z = np.maximum(points[..., 2], 1e-9)
    for before, middle, after in (
        (z[:-6, 3:-3], z[3:-3, 3:-3], z[6:, 3:-3]),
        (z[3:-3, :-6], z[3:-3, 3:-3], z[3:-3, 6:]),
    ):
        plane &= np.abs(1 / before + 1 / after - 2 / middle) < 0.002 / middle**2  # else a step between two planes
    near = plane & (points[3:-3, 3:-3, 2] < 6.0) & (points[3:-3, 3:-3, 2] > 0.0)
    assert near.mean() > 0.05
    cosine = np.einsum(
        "hwi,hwi->hw", -cross * np.sign(np.einsum("hwi,hwi->hw", cross, points[3:-3, 3:-3]))[..., None], corners[4]
    )
    assert np.median(cosine[near]) > 0.999
    assert (cosine[near] > 0.97).mean() > 0.9


@pytest.mark.parametrize("number", range(SCENES))
def test_coordinates_and_classes_are_those_of_the_labels(root: Path, number: int) -> None:
    """Forward through the stored pose they give pixel and depth; masks and records say which pixels and classes."""
    local, _, _ = rays(root, number)
    (folder,) = root.glob(f"bop/*/{number:06d}")
    coordinates, depth = stored(root, "object_coordinates", number), stored(root, "depth_clean", number) / 1000.0
    values, there = stored(root, "class_mask", number), np.zeros((62, 204), bool)
    sizes = {item["obj_id"]: item["size"] for item in objects(root)}
    record = json.loads((root / f"scenes/{number:06d}.json").read_text())
    class_of = {item["instance_id"]: item["class_name"] for item in record["objects"]}
    names = {int(value): row["class_name"] for value, row in table(root, "class_mask", number).items()}
    assert set(names.values()) == set(class_of.values())
    poses, infos = table(root, "gt", number)["0"], table(root, "gt_info", number)["0"]
    for index, (pose, info) in enumerate(zip(poses, infos, strict=True)):
        mask = cv2.imread(str(folder / f"mask_visib/000000_{index:06d}.png"), cv2.IMREAD_UNCHANGED) > 0
        in_object = ((coordinates[mask] - 1) / 65534 - 0.5) * sizes[pose["obj_id"]]
        R, t = np.array(pose["cam_R_m2c"]).reshape(3, 3), np.array(pose["cam_t_m2c"]) / 1000.0
        in_camera = in_object @ R.T + t
        back = local[mask] * depth[mask][:, None]
        assert (
            np.abs(in_camera - back).max() < 0.0015 * np.abs(local).max()
        )  # half a millimetre is the depth's rounding
        assert {names[value] for value in values[mask]} == {class_of[info["instance_id"]]}
        there |= mask
    assert np.array_equal(coordinates.any(axis=2), there)
    assert np.array_equal(values > 0, depth > 0)
    assert (values[there] > 0).all()


def objects(root: Path) -> list[dict]:
    return [{"obj_id": int(key), **row} for key, row in json.loads((root / "objects.json").read_text()).items()]


def test_readers_return_what_is_stored(root: Path) -> None:
    reader, number = DatasetReader(root), 0
    for image in reader.images("all"):
        number = image.scene_id
        raw = stored(root, "normals", number)
        normals = reader.normals(image)
        assert np.array_equal(np.rint(normals * 32767 + 32768 * raw.any(axis=2, keepdims=True)), raw)
        coordinates = reader.object_coordinates(image)
        assert np.array_equal(
            np.nan_to_num(np.rint(coordinates * 65534 + 1)), stored(root, "object_coordinates", number)
        )
        assert np.array_equal(reader.class_mask(image), stored(root, "class_mask", number))
    first = ws.Dataset(root)[0]
    assert np.array_equal(first.normals, reader.normals(reader.images("all")[0]))
    assert first.object_coordinates.shape == first.normals.shape
    assert {first.mask_classes[value] for value in np.unique(first.class_mask) if value} >= {"floor", "pallet"}


def test_readers_say_how_to_have_them(shared: Shared) -> None:
    plain = shared.dataset(wanting(shared, "poses"), scenes=SCENES, seed=SEED, formats=("bop",))
    reader = DatasetReader(plain)
    for name in EXACT:
        with pytest.raises(DatasetError, match=f"holds no {name}; generate it with --outputs poses {name}"):
            getattr(reader, name)(reader.images("train")[0])


def test_all_else_is_the_same_bytes(root: Path, shared: Shared) -> None:
    plain = shared.dataset(wanting(shared, "default", "clean"), scenes=SCENES, seed=SEED, formats=("bop",))
    said = ("manifest.json", "SHA256SUMS", "README.md", "card/", "dataset_info.md")
    before, after = (
        {name: value for name, value in hashes(folder).items() if not any(part in name for part in said)}
        for folder in (plain, root)
    )
    assert before.items() <= after.items()
    added = {name.split("/")[3] for name in after.keys() - before.keys()}
    assert added == {*EXACT, "scene_class_mask.json"}
    listed = (root / "SHA256SUMS").read_text()
    assert all(name in listed for name in after.keys() - before.keys())
    codings = read_manifest(root).contents.codings
    assert list(codings) == list(EXACT)
    assert all(text in (root / "bop/dataset_info.md").read_text() for text in codings.values())


def test_validation_finds_what_is_gone_and_what_is_false(root: Path, tmp_path: Path) -> None:
    assert [check.detail for check in validate(root) if not check.ok] == []

    def failing(change: object) -> list[str]:
        broken = tmp_path / "broken"
        shutil.copytree(root, broken)
        change(broken / "bop/train/000000")  # type: ignore[operator]
        found = [check.name for check in validate(broken) if not check.ok]
        shutil.rmtree(broken)
        return found

    def rewrite(path: Path, image: np.ndarray) -> None:
        assert cv2.imwrite(str(path), image)

    def read(path: Path) -> np.ndarray:
        return cv2.imread(str(path), cv2.IMREAD_UNCHANGED)

    def turned(scene: Path) -> None:
        image = read(scene / "normals/000000.png").astype(int)
        rewrite(scene / "normals/000000.png", np.where(image > 0, 65536 - image, 0).astype(np.uint16))

    def moved(scene: Path) -> None:
        image = read(scene / "object_coordinates/000000.png").astype(int)
        rewrite(
            scene / "object_coordinates/000000.png",
            np.where(image > 0, np.clip(image + 6000, 1, 65535), 0).astype(np.uint16),
        )

    def exchanged(scene: Path) -> None:
        image = read(scene / "class_mask/000000.png")
        rewrite(scene / "class_mask/000000.png", np.where(image == 1, 27, image).astype(np.uint16))

    def unnamed(scene: Path) -> None:
        image = read(scene / "class_mask/000000.png")
        rewrite(scene / "class_mask/000000.png", np.where(image == 27, 99, image).astype(np.uint16))

    for change in (turned, moved, exchanged, unnamed):
        assert failing(change) == ["bop exact images"], change
    for name in (*(f"{kind}/000000.png" for kind in EXACT), "scene_class_mask.json"):
        assert "bop files" in failing(lambda scene, name=name: (scene / name).unlink())


def test_other_formats_say_that_they_have_no_place(shared: Shared) -> None:
    for name in EXACT:
        recipe = wanting(shared, "default", name)
        for other in ("kitti", "bop_webdataset", "bop_compact", "coco", "ply", "mcap"):
            with pytest.raises(
                DatasetError, match=f"outputs: {name} has no place in {other}; add bop to --formats"
            ) as one:
                plan_dataset(recipe, GenerateConfig(formats=(other,)))
            assert "\n" not in str(one.value)
        plan_dataset(recipe, GenerateConfig(formats=("bop", "kitti")))


def test_conversion_leaves_them_behind_and_says_so(root: Path, tmp_path: Path) -> None:
    manifest = convert(root, tmp_path / "coco", ("coco",))
    assert manifest.contents.codings == {}
    assert manifest.recipe["sensors"]["outputs"] == ["default", "clean"]
    assert [check.detail for check in validate(tmp_path / "coco") if not check.ok] == []
    with pytest.raises(DatasetError, match="holds no normals; generate it with --outputs"):
        DatasetReader(tmp_path / "coco").normals(DatasetReader(tmp_path / "coco").images("train")[0])


def test_a_recording_shows_them(root: Path, tmp_path: Path) -> None:
    reader = DatasetReader(root)
    with open_recording("exact", tmp_path / "d.rrd") as recording:
        stream_images(reader, reader.images("all"), recording)
    found = rows(tmp_path / "d.rrd")
    for number, image in enumerate(reader.images("all")):
        shown = {kind: found[f"/world/rig/camera/image/{kind}"] for kind in EXACT}
        normals = np.array(shown["normals"][number]["Image:buffer"], np.uint8).reshape(62, 204, 3)
        there = reader.normals(image).any(axis=2)
        assert there.mean() > 0.5
        assert np.abs((normals / 127.5 - 1.0)[there] - reader.normals(image)[there]).max() < 0.005
        assert not normals[~there].any()
        places = np.array(shown["object_coordinates"][number]["Image:buffer"], np.uint8).reshape(62, 204, 3)
        exact = reader.object_coordinates(image)
        there = np.isfinite(exact).all(axis=2)
        assert np.abs(places / 255 - exact)[there].max() < 0.003
        assert not places[~there].any()
        classes, values = (
            [row for row in shown["class_mask"] if row["observation"] == number],
            reader.mask_classes(image),
        )
        (told,) = [row["AnnotationContext:context"] for row in classes if row.get("AnnotationContext:context")]
        (told,) = told
        assert {item["class_id"]: item["class_description"]["info"]["label"] for item in told} == values


def test_a_backend_that_draws_no_normals_is_rejected_at_once(shared: Shared, tmp_path: Path, monkeypatch) -> None:
    recipe, out = wanting(shared, "default", "normals"), tmp_path / "data"
    monkeypatch.setattr("warehouse_sim.generation.generate.plan_dataset", lambda *_: pytest.fail("planned before"))
    for backend in ("pyrender", "mujoco"):
        message = f"outputs: normals is wanted, which the {backend} backend does not draw; use raster"
        with pytest.raises(RenderError, match=message) as one:
            generate(recipe, out, GenerateConfig(formats=("bop",), backend=backend))
        assert "\n" not in str(one.value)
        with pytest.raises(RenderError, match=message):
            next(stream(recipe, backend=backend))
    assert not out.exists()


def test_another_driver_may_move_borders_and_no_class(root: Path, tmp_path: Path) -> None:
    for kind, nearly, off in (("normals", 900, 1100), ("object_coordinates", 600, 700), ("class_mask", 0, 1)):
        path = root / f"bop/train/000000/{kind}/000000.png"
        image = cv2.imread(str(path), cv2.IMREAD_UNCHANGED).astype(int)
        for change, most in ((nearly, 0.0), (off, 1.0)):
            other = tmp_path / kind / "000000.png"
            other.parent.mkdir(exist_ok=True)
            cv2.imwrite(
                str(other), (image + change * (image < 60000) - change * (image >= 60000)).clip(0).astype(np.uint16)
            )
            assert fraction_off(path, other) == most


def test_shards_of_other_outputs_are_not(shared: Shared, tmp_path: Path) -> None:
    parts = [tmp_path / f"part{i}" for i in range(2)]
    for number, (part, more) in enumerate(zip(parts, ((), ("normals",)), strict=True)):
        recipe = wanting(shared, "poses", *more)
        generate(recipe, part, GenerateConfig(scenes=2, seed=SEED, formats=("bop",), shard=Shard(number, 2)))
    with pytest.raises(DatasetError, match=r"holds other outputs: poses, normals where .* holds poses; make it again"):
        merge(parts, tmp_path / "whole")


@pytest.mark.slow
def test_shards_are_put_together(root: Path, shared: Shared, tmp_path: Path) -> None:
    recipe = wanting(shared, "default", "clean", *EXACT)
    parts = [tmp_path / f"part{i}" for i in range(2)]
    for number, part in enumerate(parts):
        generate(recipe, part, GenerateConfig(scenes=SCENES, seed=SEED, formats=("bop",), shard=Shard(number, 2)))
    merge(parts, tmp_path / "whole")
    assert hashes(tmp_path / "whole") == hashes(root)
