"""DenseFusion's LINEMOD layout: read here as DenseFusion's own loader takes it apart, and a third-party folder."""

import json
from itertools import chain
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml

from tests.dataset.formats.test_external_bop import EDGES, HEIGHT, WIDTH, ascii_ply, place, visible
from tests.dataset.toy import CAMERA, PALLET, make_dataset, make_manifest, make_scene, observe, write_scene
from warehouse_sim.dataset.formats.linemod import yaml_row
from warehouse_sim.dataset.formats.reader_base import box_mask
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.store import DatasetStore
from warehouse_sim.dataset.validate import validate
from warehouse_sim.errors import DatasetError


@pytest.fixture(scope="module")
def linemod(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_dataset(tmp_path_factory.mktemp("linemod") / "data", make_manifest(formats=("linemod",)))


def test_a_mask_made_of_a_box_has_its_last_row_and_column() -> None:
    mask = box_mask((2.0, 1.0, 5.0, 7.0), CAMERA)
    assert mask.sum() == (5 - 2 + 1) * (7 - 1 + 1)
    assert mask[1:8, 2:6].all()
    assert box_mask((-5.0, -5.0, -3.0, 4.0), CAMERA).sum() == 0


def vertices_as_densefusion_reads_them(path: Path) -> np.ndarray:
    """Read a mesh by its rules: text, the number of vertices at the end of the fourth line."""
    lines = path.read_text().splitlines()
    assert lines[0].strip() == "ply"
    first = lines.index("end_header") + 1
    return np.array([line.split()[:3] for line in lines[first : first + int(lines[3].split()[-1])]], np.float32)


def test_densefusion_finds_the_ground_truth(linemod: Path) -> None:
    """Back-project the masked depth as DenseFusion does: the points lie on the posed model."""
    folder = linemod / "linemod"
    model = vertices_as_densefusion_reads_them(folder / "models" / "obj_01.ply") / 1000.0
    assert np.allclose(np.ptp(model, axis=0), PALLET.size, atol=1e-6)
    labels = yaml.safe_load((folder / "data/01/gt.yml").read_text())
    cameras = yaml.safe_load((folder / "data/01/info.yml").read_text())
    names = [(folder / "data/01" / f"{split}.txt").read_text().split() for split in ("train", "val", "test")]
    listed = sorted(chain.from_iterable(names))
    assert listed == [f"{frame:04d}" for frame in range(9)]
    for frame in map(int, listed):
        label = labels[frame][0]
        assert (len(labels[frame]), label["obj_id"]) == (1, 1)
        depth, mask = (
            cv2.imread(str(folder / f"data/01/{kind}/{frame:04d}.png"), cv2.IMREAD_UNCHANGED)
            for kind in ("depth", "mask")
        )
        chosen = np.all(mask == [255, 255, 255], axis=2) & (depth > 0)
        assert chosen.sum() == label["px_count_visib"]
        x, y, w, h = label["obj_bb"]
        assert all(type(value) is int for value in label["obj_bb"])
        v, u = np.nonzero(chosen)
        assert (x <= u.min(), u.max() <= x + w, y <= v.min(), v.max() <= y + h) == (True,) * 4
        fx, _, cx, _, fy, cy = cameras[frame]["cam_K"][:6]
        z = depth[chosen] / 1000.0
        points = np.stack([(u - cx) * z / fx, (v - cy) * z / fy, z], axis=1)
        R, t = np.reshape(label["cam_R_m2c"], (3, 3)), np.array(label["cam_t_m2c"]) / 1000.0
        inside = np.abs((points - t) @ R) - PALLET.size / 2
        assert inside.max() < 0.002


def test_frames_of_the_test_split_have_a_segmentation(linemod: Path) -> None:
    folder = linemod / "linemod"
    tested = (folder / "data/01/test.txt").read_text().split()
    assert sorted(path.name for path in (folder / "segnet_results/01_label").iterdir()) == [
        f"{name}_label.png" for name in tested
    ]
    for name in tested:
        label = cv2.imread(str(folder / f"segnet_results/01_label/{name}_label.png"), cv2.IMREAD_UNCHANGED)
        mask = cv2.imread(str(folder / f"data/01/mask/{name}.png"), cv2.IMREAD_UNCHANGED)
        assert np.array_equal(label, mask[..., 0])


def test_the_reader_returns_what_was_written(linemod: Path) -> None:
    reader = DatasetReader(linemod)
    assert reader.splits == {"train": (1,), "val": (1,), "test": (1,)}
    assert {split: len(reader.images(split)) for split in reader.splits} == {"train": 3, "val": 3, "test": 3}
    labels_given = observe(make_scene(2))[0]
    for image, annotation in zip(reader.images("test"), labels_given.annotations, strict=True):
        (target,) = image.targets
        assert target.instance_id == annotation.instance_id
        assert np.abs(target.T_camera_object - annotation.T_camera_object).max() < 1e-9
        assert target.visible_fraction == annotation.visible_fraction
        assert target.box_visible_xyxy == annotation.box_visible_xyxy
        assert (image.camera, image.depth_scale) == (CAMERA, 1.0)
        assert np.array_equal(
            reader.mask_visible(image, 0), labels_given.buffers.instance_mask == annotation.instance_id
        )
        assert np.array_equal(reader.rgb(image), labels_given.rgbd.rgb)
        assert np.abs(reader.depth(image) - labels_given.rgbd.depth).max() <= 0.000501
    assert reader.objects[1].name == "toy-pallet"
    assert len(reader.objects[1].metric_mesh().vertices) >= 2000
    assert all(check.ok for check in validate(linemod)), [check for check in validate(linemod) if not check.ok]


def test_bytes_depend_on_no_order_and_survive_a_kill(linemod: Path, tmp_path: Path) -> None:
    root, manifest = tmp_path / "data", make_manifest(formats=("linemod",))
    store = DatasetStore(root, manifest)
    store.begin([PALLET], CAMERA)
    for index in (2, 0, 1):
        write_scene(store, index)
    # As if killed in the middle of giving numbers: some images have theirs.
    part = root / "linemod/parts/000000"
    (root / "linemod/data/01/rgb").mkdir(parents=True)
    (part / "000000_000000_rgb.png").rename(root / "linemod/data/01/rgb/0000.png")
    again = DatasetStore(root, manifest)
    again.begin([PALLET], CAMERA, resume=True)
    again.finish()
    files = [
        {str(path.relative_to(base)): path.read_bytes() for path in sorted((base / "linemod").rglob("*.*"))}
        for base in (root, linemod)
    ]
    assert files[0] == files[1]
    assert not (root / "linemod/parts").exists()


@pytest.mark.parametrize("value", [1e-05, -2e-17, 12345.678, 1e22, 0, -3])
def test_numbers_with_exponents_are_numbers_of_yaml(value: float) -> None:
    assert yaml.safe_load(yaml_row({"v": [value]})) == {"v": [value]}


def write_preprocessed(root: Path) -> Path:
    """Write a folder as LINEMOD_preprocessed is: rounded numbers, object 2 with other objects before it."""
    (root / "models").mkdir(parents=True)
    rows = []
    for number in (1, 2):
        (root / "models" / f"obj_{number:02d}.ply").write_bytes(ascii_ply())
        low = {f"min_{axis}": -float(edge) / 2 for axis, edge in zip("xyz", EDGES, strict=True)}
        size = {f"size_{axis}": float(edge) for axis, edge in zip("xyz", EDGES, strict=True)}
        rows.append(f"{number}: {{diameter: {np.linalg.norm(EDGES)}, " + str(low | size)[1:].replace("'", ""))
        folder = root / "data" / f"{number:02d}"
        for kind in ("rgb", "depth", "mask"):
            (folder / kind).mkdir(parents=True)
        gt, info = "", ""
        for frame in range(12):
            name = f"{frame:04d}.png"
            cv2.imwrite(str(folder / "rgb" / name), np.full((HEIGHT, WIDTH, 3), 90, np.uint8))
            depth = np.where(visible(frame), 1400, 3000).astype(np.uint16)
            cv2.imwrite(str(folder / "depth" / name), depth)
            mask = visible(frame)[..., None].repeat(3, axis=2).astype(np.uint8) * 255
            cv2.imwrite(str(folder / "mask" / name), mask)
            v, u = np.nonzero(visible(frame))
            box = [int(u.min()), int(v.min()), int(np.ptp(u)), int(np.ptp(v))]
            info += f"{frame}:\n  cam_K: [60.0, 0.0, {(WIDTH - 1) / 2}, 0.0, 60.0, {(HEIGHT - 1) / 2}, 0.0, 0.0, 1.0]\n"
            info += "  depth_scale: 1.0\n"
            gt += f"{frame}:\n"
            for obj_id in (1, 5, 2) if number == 2 else (1,):
                t = place(frame) + (0 if obj_id == number else 500)
                gt += "- cam_R_m2c: [0.99999, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]\n"
                gt += f"  cam_t_m2c: {t.tolist()}\n  obj_bb: {box}\n  obj_id: {obj_id}\n"
        (folder / "gt.yml").write_text(gt)
        (folder / "info.yml").write_text(info)
        (folder / "train.txt").write_text("".join(f"{frame:04d}\n" for frame in range(10)))
        (folder / "test.txt").write_text("0010\n0011\n")
    (root / "models" / "models_info.yml").write_text("\n".join(rows) + "\n")
    return root


def test_preprocessed_folders_of_others_are_read(tmp_path: Path) -> None:
    reader = DatasetReader(write_preprocessed(tmp_path / "Linemod_preprocessed"))
    assert {split: len(reader.images(split)) for split in reader.splits} == {"train": 18, "val": 2, "test": 4}
    assert [(image.scene_id, image.image_id) for image in reader.images("test")] == [(1, 10), (1, 11), (2, 10), (2, 11)]
    for image in reader.images("test"):
        (target,) = image.targets
        assert target.obj_id == image.scene_id
        assert np.allclose(target.T_camera_object[:3, 3], place(image.image_id) / 1000.0)
        assert np.array_equal(reader.mask_visible(image, 0), visible(image.image_id))
        assert np.allclose(reader.depth(image)[visible(image.image_id)], 1.4)
    assert np.allclose(reader.objects[2].size, EDGES / 1000.0)
    assert reader.objects[2].class_name == "object"


@pytest.mark.parametrize(
    ("file", "text", "message"),
    [
        ("gt.yml", "0: &a [*a]\n", r"gt\.yml: holds an anchor or an alias"),
        ("gt.yml", "0: !!python/object/apply:os.system ['true']\n", r"gt\.yml: is not valid YAML"),
        ("gt.yml", "{}\n", r"gt\.yml: 10: entries must be of type list, found None"),
        ("test.txt", "../../etc/passwd\n", r"test\.txt: '\.\./\.\./etc/passwd' is no number"),
    ],
)
def test_hostile_tables_are_rejected(tmp_path: Path, file: str, text: str, message: str) -> None:
    root = write_preprocessed(tmp_path / "data")
    (root / "data/01" / file).write_text(text)
    with pytest.raises(DatasetError, match=message):
        DatasetReader(root).images("test")


def test_scene_rows_lead_to_the_records(linemod: Path) -> None:
    rows = json.loads((linemod / "linemod/frames/000002.json").read_text())
    ids = [annotation.instance_id for annotation in observe(make_scene(2))[0].annotations]
    assert [row["gt"]["instance_id"] for row in rows] == ids
