"""What is inspected is compared with what the toy's ray caster knows, and with what was spoilt on purpose."""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from tests.dataset.toy import make_scene, observe
from tests.pages import Page
from warehouse_sim.cli.main import main
from warehouse_sim.dataset.card.tally import bin_names, text_bars
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.validate import validate
from warehouse_sim.dataset.viewing.panels import Captions
from warehouse_sim.dataset.viewing.report import inspect
from warehouse_sim.dataset.viewing.survey import Oddities
from warehouse_sim.errors import DatasetError


@pytest.fixture
def theirs(toy_root: Path, tmp_path: Path) -> Path:
    """Return the BOP part alone, as others have it."""
    shutil.copytree(toy_root / "bop", tmp_path / "theirs")
    return tmp_path / "theirs"


def change_poses(root: Path, factor: float) -> None:
    for path in root.rglob("scene_gt.json"):
        table = json.loads(path.read_text())
        for row in (row for rows in table.values() for row in rows):
            row["cam_t_m2c"] = [factor * value for value in row["cam_t_m2c"]]
        path.write_text(json.dumps(table))


def test_counts_are_those_of_the_scenes(toy_root: Path, tmp_path: Path) -> None:
    found = inspect(toy_root, tmp_path / "out", count=4)
    text = "\n".join(found.lines)
    visible = [
        item
        for index in range(3)
        for observation in observe(make_scene(index))
        for item in observation.annotations
        if item.pixels_visible
    ]
    assert f"6 images, {len(visible)} labels of 1 classes" in text
    assert "160 x 96 (6)" in text
    far = sum(np.linalg.norm(item.T_camera_object[:3, 3]) >= 5 for item in visible)
    (line,) = [line for line in found.lines if line.startswith("   5 - 7")]
    assert line.split("|")[1].split()[1:2] == [str(far)]
    assert "3 x images without a label" in text  # the second camera looks away
    assert (tmp_path / "out/survey.txt").read_text() == text + "\n"
    # Two rows an image of panels twice as large as the image.
    assert cv2.imread(str(found.sheet)).shape == (4 * 2 * (192 + 4), 2 * (320 + 4), 3)


def test_each_frame_of_kitti_counts_once(toy_root: Path, tmp_path: Path) -> None:
    folder = tmp_path / "theirs"
    shutil.copytree(toy_root / "kitti", folder)
    reader = DatasetReader(folder)
    assert "trainval" in reader.splits
    labels = sum(len(image.targets) for image in reader.images("all"))
    found = inspect(folder, tmp_path / "out")
    assert f"6 images, {labels} labels of 1 classes" in found.lines
    assert not any("trainval" in line for line in found.lines)
    assert main(["view", str(folder), "--html", str(tmp_path / "d.html")]) == 0
    assert len(Page((tmp_path / "d.html").read_text()).frames) == 6
    assert any(check.detail == f"{labels} labels of 6 images" for check in validate(folder))


def test_boxes_and_masks_lie_on_the_objects(toy_root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Captions, "draw", lambda self: None)  # they may lie beside their objects
    sheet = cv2.imread(str(inspect(toy_root, tmp_path / "out", count=1).sheet))[..., ::-1].astype(int)
    first = observe(make_scene(0))[0]
    plain = cv2.resize(first.rgbd.rgb, (320, 192), interpolation=cv2.INTER_LINEAR).astype(int)
    drawn = np.abs(sheet[:192, 324:644] - plain).sum(axis=-1) > 0
    ids = cv2.resize(first.buffers.instance_mask, (320, 192), interpolation=cv2.INTER_NEAREST)
    labelled = np.isin(ids, [10, 11, 12])
    drawn[:40] = False  # the caption
    assert (drawn & labelled)[40:].sum() > 0.97 * labelled[40:].sum()
    assert (drawn & ~labelled).sum() < 0.2 * labelled.sum()  # the edges of their boxes


def test_a_folder_without_depth_and_masks_is_shown(theirs: Path, tmp_path: Path) -> None:
    for name in ("depth", "mask", "mask_visib"):
        for folder in [path for path in theirs.rglob(name) if path.is_dir()]:
            shutil.rmtree(folder)
    found = inspect(theirs, tmp_path / "out", count=2)
    assert found.sheet.is_file()
    assert "9 labels" in found.lines[1] or "labels of 1 classes" in found.lines[1]


@pytest.mark.parametrize(
    ("factor", "words"),
    [
        (0.001, "labels whose pose is not where the depth is"),
        (1000.0, "labels more than 1000 m away: is the unit right?"),
        (-1.0, "labels whose centre is behind the camera"),
    ],
)
def test_poses_in_another_unit_are_odd(theirs: Path, tmp_path: Path, factor: float, words: str) -> None:
    assert not any(words in line for line in inspect(theirs, tmp_path / "before").lines)
    change_poses(theirs, factor)
    assert any(words in line for line in inspect(theirs, tmp_path / "after").lines)


@pytest.mark.parametrize(("right", "odd"), [(158.0, True), (159.0, False)])
def test_a_box_that_the_border_cuts_may_belong_to_what_is_beyond_it(toy_root: Path, right: float, odd: bool) -> None:
    reader = DatasetReader(toy_root)
    image = next(item for item in reader.images("all") if item.targets)
    T = image.targets[0].T_camera_object.copy()
    u, v = image.camera.project(T[None, :3, 3])[0]
    T[0, 3] += (200.0 - u) / image.camera.fx * T[2, 3]
    box = (150.0, v - 5.0, right, v + 5.0)
    oddities = Oddities()
    oddities.of_target(
        image, replace(image.targets[0], T_camera_object=T, box_visible_xyxy=box, box_amodal_xyxy=box), reader.objects
    )
    assert list(oddities.found) == (["labels whose pose projects beside their box"] if odd else [])


@pytest.mark.parametrize(("seen_px", "shifted", "odd"), [(14, 0.0, False), (14, 9.0, True), (6, 0.0, False)])
def test_readings_of_what_stands_before_the_edges_of_a_label_are_not_odd(
    toy_root: Path, seen_px: int, shifted: float, odd: bool
) -> None:
    """A depth camera reads the near thing over the outer three pixels of what is behind it: all of a narrow strip."""
    image = next(item for item in DatasetReader(toy_root).images("all") if item.targets)
    target = image.targets[0]
    far = float(target.T_camera_object[2, 3]) + shifted
    depth, visible = np.full((96, 160), 0.5, np.float32), np.zeros((96, 160), bool)
    visible[20:80, 40 : 40 + seen_px] = True
    depth[23:77, 43 : 40 + seen_px - 3] = far
    oddities = Oddities()
    oddities.of_reading(image, target, depth, visible, diameter=1.0)
    assert bool(oddities.found) is odd


def test_a_split_that_is_not_there_is_rejected(toy_root: Path, tmp_path: Path) -> None:
    with pytest.raises(DatasetError, match="split"):
        inspect(toy_root, tmp_path / "out", split="mars")
    with pytest.raises(DatasetError, match="is not a folder"):
        inspect(tmp_path / "nothing", tmp_path / "out")


def test_bars_are_as_long_as_their_counts() -> None:
    assert text_bars({"a": 4, "bb": 1, "c": 0, "d": 1000}, width=10) == [
        "a  |#              4   0.4 %",
        "bb |#              1   0.1 %",
        "c  |               0",
        "d  |########## 1,000  99.5 %",
    ]
    assert bin_names((0.0, 0.5, 10.0)) == ["  0 - 0.5", "0.5 -"]
    assert text_bars({}) == []


def test_captions_cover_no_other() -> None:
    image = np.full((100, 200, 3), 200, np.uint8)
    captions = Captions(image)
    for _ in range(20):
        captions.add("pallet 3.2 m", (60.0, 50.0), (255, 0, 0))
    captions.add("far away", (900.0, 50.0), (255, 0, 0))
    captions.draw()
    dark = (image.max(axis=-1) < 100).any(axis=1)
    assert 4 < np.flatnonzero(np.diff(dark.astype(int))).size + dark.sum() / 10 < 20
    assert dark.sum() <= 7 * 17


@pytest.mark.real
def test_recorded_frames_have_their_labels_and_nothing_odd(real_data: Path, tmp_path: Path) -> None:
    found = inspect(real_data / "kitti", tmp_path / "kitti", count=2)
    text = "\n".join(found.lines)
    labels = [line.split()[0] for path in (real_data / "kitti").rglob("label_2/*.txt") for line in path.open()]
    (cars,) = [line for line in found.lines if line.strip().startswith("Car ")]
    assert cars.split("|")[1].split()[1] == str(labels.count("Car"))
    assert "nothing odd" in text
    assert cv2.imread(str(found.sheet)).shape[1] == 2 * 804


@pytest.mark.real
def test_masks_without_class_and_pose_are_shown(real_data: Path, tmp_path: Path) -> None:
    found = inspect(real_data / "boxes", tmp_path / "boxes")
    assert "11 labels without a pose" in found.lines
    sheet = cv2.imread(str(found.sheet)).astype(int)
    masks = [cv2.imread(str(path), cv2.IMREAD_UNCHANGED) for path in (real_data / "boxes").glob("*mask_*.png")]
    either = np.any([cv2.resize((mask > 0).astype(np.uint8), (800, 600)) > 0 for mask in masks], axis=0)
    tinted = np.abs(sheet[:600, :800] - sheet[:600, 804:1604]).sum(axis=-1) > 12
    assert (tinted & either).sum() > 0.95 * either.sum()
    # Captions stand above the boxes of the masks.
    near = cv2.dilate(either.astype(np.uint8), np.ones((61, 61), np.uint8)) > 0
    assert (tinted & ~near)[40:].sum() < 0.001 * either.sum()
