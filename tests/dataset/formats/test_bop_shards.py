"""BOP shards: what they hold, read by tarfile alone; the same bytes from any order of scenes; hostile archives."""

import io
import json
import shutil
import tarfile
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from pycocotools import mask as coco_mask

from tests.dataset.toy import CAMERA, PALLET, make_dataset, make_manifest, make_scene, observe, write_scene
from tests.shared import hashes
from warehouse_sim.dataset.formats.bop.shards import shards_layout
from warehouse_sim.dataset.formats.bop.shards.writer import ShardsWriter, merge
from warehouse_sim.dataset.formats.observation_files import ObservationFiles
from warehouse_sim.dataset.objects import write_objects
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.store import DatasetStore
from warehouse_sim.dataset.validate import validate
from warehouse_sim.errors import DatasetError

BOTH = ("bop", "bop_webdataset")


@pytest.fixture(scope="module")
def both(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A toy dataset in both BOP formats, to read only."""
    return make_dataset(tmp_path_factory.mktemp("both") / "data", make_manifest(formats=BOTH))


@pytest.fixture
def shards(both: Path, tmp_path: Path) -> Path:
    """A copy of it with the shards alone."""
    root = Path(shutil.copytree(both, tmp_path / "data"))
    manifest = json.loads((root / "manifest.json").read_text())
    manifest["formats"] = ["bop_webdataset"]
    (root / "manifest.json").write_text(json.dumps(manifest))
    shutil.rmtree(root / "bop")
    return root


def members(path: Path) -> dict[str, bytes]:
    with tarfile.open(path) as archive:
        return {item.name: archive.extractfile(item).read() for item in archive.getmembers()}


def test_shards_hold_what_the_scenewise_folder_holds(both: Path) -> None:
    scene = both / "bop" / "test" / "000002"
    found = members(both / "bop_webdataset" / "test" / "shard-000000.tar")
    kinds = ["camera.json", "depth.png", "gt.json", "gt_info.json", "mask.json", "mask_visib.json", "rgb.png"]
    assert list(found) == [f"000002_00000{image}.{kind}" for image in (0, 1) for kind in kinds]
    for image in (0, 1):
        key = f"000002_{image:06d}"
        for kind in ("rgb", "depth"):
            assert found[f"{key}.{kind}.png"] == (scene / kind / f"{image:06d}.png").read_bytes()
        for kind in ("camera", "gt", "gt_info"):
            table = json.loads((scene / f"scene_{kind}.json").read_text())
            assert json.loads(found[f"{key}.{kind}.json"]) == table[str(image)]
        for kind in ("mask", "mask_visib"):
            runs = json.loads(found[f"{key}.{kind}.json"])
            assert list(runs) == [str(i) for i in range(3 if image == 0 else 0)]
            for index, run in runs.items():
                decoded = coco_mask.decode(coco_mask.frPyObjects(run, *run["size"])) * 255
                png = cv2.imread(str(scene / kind / f"{image:06d}_{int(index):06d}.png"), cv2.IMREAD_UNCHANGED)
                assert np.array_equal(decoded, png)
    assert json.loads((both / "bop_webdataset/test/key_to_shard.json").read_text()) == {
        "000002_000000": 0,
        "000002_000001": 0,
    }
    for name in ("camera.json", "test_targets_bop19.json", "test_targets_bop24.json", "models_eval/models_info.json"):
        assert (both / "bop_webdataset" / name).read_bytes() == (both / "bop" / name).read_bytes()
    assert not (both / "bop_webdataset" / "parts").exists()


def test_both_formats_read_the_same(both: Path, shards: Path) -> None:
    a, b = DatasetReader(both), DatasetReader(shards)
    assert a.splits == b.splits
    assert np.array_equal(a.objects[1].metric_mesh().vertices, b.objects[1].metric_mesh().vertices)
    for split in a.splits:
        for one, other in zip(a.images(split), b.images(split), strict=True):
            assert (one.scene_id, one.image_id, one.camera) == (other.scene_id, other.image_id, other.camera)
            assert np.array_equal(one.T_world_camera, other.T_world_camera)
            assert np.array_equal(a.rgb(one), b.rgb(other))
            assert np.array_equal(a.depth(one), b.depth(other))
            for target, paired_variant in zip(one.targets, other.targets, strict=True):
                assert np.array_equal(target.T_camera_object, paired_variant.T_camera_object)
                assert replace(target, T_camera_object=np.eye(4)).__dict__ | {"T_camera_object": 0} == (
                    paired_variant.__dict__ | {"T_camera_object": 0}
                )
                assert np.array_equal(a.mask(one, target.gt_index), b.mask(other, target.gt_index))
                assert np.array_equal(a.mask_visible(one, target.gt_index), b.mask_visible(other, target.gt_index))
    assert all(check.ok for check in validate(shards)), [c for c in validate(shards) if not c.ok]


@pytest.mark.parametrize("stop", ["scene", "merge", "after"])
def test_a_killed_run_is_taken_up(both: Path, tmp_path: Path, stop: str) -> None:
    root = tmp_path / "data"
    manifest = make_manifest(formats=BOTH)
    store = DatasetStore(root, manifest)
    store.begin([PALLET], CAMERA)
    for index in (0, 1):
        write_scene(store, index)
    layout = shards_layout(root)
    if stop == "scene":  # in the middle of the third scene
        scene_writer = ShardsWriter(root, manifest).scene(make_scene(2))
        scene_writer.write(ObservationFiles(observe(make_scene(2))[0]))
        del scene_writer
    else:
        write_scene(store, 2)
        merge(layout, manifest)
    if stop == "merge":  # one shard was not made yet, its scene is still apart
        whole = members(layout.shard("val", 0)) if layout.split("val").exists() else {}
        assert whole or layout.split("train").exists()
        scene_writer = ShardsWriter(root, manifest).scene(make_scene(2))
        for observation in observe(make_scene(2)):
            scene_writer.write(ObservationFiles(observation))
        scene_writer.finish()
        layout.shard("test", 0).unlink()
    again = DatasetStore(root, manifest)
    again.begin([PALLET], CAMERA, resume=True)
    for index in again.pending():
        write_scene(again, index)
    again.finish()
    assert hashes(root / "bop_webdataset") == hashes(both / "bop_webdataset")


def test_scenes_go_on_in_the_next_shard(tmp_path: Path) -> None:
    manifest = replace(make_manifest(), splits={"train": (0, 1, 2), "val": (), "test": ()})
    write_objects(tmp_path, [PALLET])
    writer, layout = ShardsWriter(tmp_path, manifest), shards_layout(tmp_path)
    writer.begin([PALLET], CAMERA)
    for index in (2, 1, 0):
        scene = writer.scene(make_scene(index))
        for observation in observe(make_scene(index)):
            scene.write(ObservationFiles(observation))
        scene.finish()
    merge(layout, manifest, most_images=4)
    keys = [[name[:13] for name in members(layout.shard("train", i)) if name.endswith("rgb.png")] for i in (0, 1)]
    assert keys == [
        ["000000_000000", "000000_000001", "000001_000000", "000001_000001"],
        ["000002_000000", "000002_000001"],
    ]
    before = hashes(tmp_path)
    merge(layout, manifest, most_images=4)
    assert hashes(tmp_path) == before
    layout.shard("train", 1).unlink()
    with pytest.raises(DatasetError, match=r"shard-000001\.tar: image 000002_000000 is neither in .*000002\.tar nor"):
        merge(layout, manifest, most_images=4)


def rewrite(path: Path, change) -> None:
    """Write a shard again, its members changed."""
    items = []
    with tarfile.open(path) as archive:
        items = [(item, archive.extractfile(item).read()) for item in archive.getmembers()]
    with tarfile.open(path, "w") as archive:
        for item, data in change(items):
            archive.addfile(item, io.BytesIO(data))


def named(name: str, data: bytes = b"x", **more) -> tuple[tarfile.TarInfo, bytes]:
    item = tarfile.TarInfo(name)
    item.size = len(data)
    for key, value in more.items():
        setattr(item, key, value)
    return item, data


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda items: [*items, named("../../evil.json")], r"holds '\.\./\.\./evil\.json'; a shard holds files"),
        (
            lambda items: [*items[1:], named("000002_000000.camera.json", b"", type=tarfile.SYMTYPE, linkname="/x")],
            "a shard holds files",
        ),
        (lambda items: [*items, items[0]], r"camera\.json: comes twice"),
        (lambda items: items[1:], r"000002_000000\.camera\.json is missing"),
        (lambda items: items[:7], r"image 000002_000001 is missing"),
        (lambda items: [*items, named("000009_000000.rgb.png")], r"000009_000000 is None, the image is in shard"),
        (lambda items: [named(items[0][0].name, b"{}"), *items[1:]], r"camera\.json: the entry 'cam_K' is missing"),
    ],
)
def test_hostile_shards_are_rejected(shards: Path, change, message: str) -> None:
    rewrite(shards / "bop_webdataset" / "test" / "shard-000000.tar", change)
    with pytest.raises(DatasetError, match=message):
        DatasetReader(shards).images("test")
    assert not all(check.ok for check in validate(shards))


def test_archives_that_are_cut_or_packed_are_rejected(shards: Path) -> None:
    path = shards / "bop_webdataset" / "test" / "shard-000000.tar"
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 3])
    with pytest.raises(DatasetError, match=r"shard-000000\.tar"):
        DatasetReader(shards).images("test")
    with tarfile.open(path, "w:gz") as archive:
        archive.addfile(named("000002_000000.rgb.png")[0], io.BytesIO(b"x"))
    with pytest.raises(DatasetError, match="is no plain tar archive"):
        DatasetReader(shards).images("test")
