"""Third-party datasets in our formats, compared with the third-party files, which the test opens itself."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from tests.dataset.formats.test_external_bop import STEP_MM, visible, write_folder
from tests.dataset.toy import failures, make_dataset, make_manifest
from tests.shared import hashes
from warehouse_sim.cli.main import main
from warehouse_sim.dataset.convert.run import convert
from warehouse_sim.dataset.store import DatasetStore
from warehouse_sim.errors import DatasetError


@pytest.fixture(scope="module")
def converted(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    folder = tmp_path_factory.mktemp("convert")
    theirs = write_folder(folder / "theirs", gray=False)
    convert(theirs, folder / "ours", ("bop",))
    return theirs, folder / "ours"


def test_a_dataset_of_others_becomes_one_of_ours_that_holds_all_checks(converted: tuple[Path, Path]) -> None:
    _, ours = converted
    assert failures(ours) == {}


def test_every_image_says_where_it_came_from_and_is_that_image(converted: tuple[Path, Path]) -> None:
    theirs, ours = converted
    records = [json.loads(path.read_text()) for path in sorted((ours / "scenes").glob("*.json"))]
    found = [tuple(item["origin"][key] for key in ("split", "scene_id", "image_id")) for item in records]
    wanted = {(7, int(path.stem)) for path in (theirs / "train_pbr" / "000007" / "rgb").iterdir()}
    assert {item[1:] for item in found if item[0] != "test"} == wanted
    for record, (split, scene_id, image_id) in zip(records, found, strict=True):
        folder = ours / "bop" / split / f"{record['scene_index']:06d}"
        source = theirs / ("test" if split == "test" else "train_pbr") / f"{scene_id:06d}"
        assert (folder / "rgb" / "000000.png").samefile(source / "rgb" / f"{image_id:06d}.png")
        depth = cv2.imread(str(folder / "depth" / "000000.png"), cv2.IMREAD_UNCHANGED)
        stored = cv2.imread(str(source / "depth" / f"{image_id:06d}.png"), cv2.IMREAD_UNCHANGED)
        np.testing.assert_array_equal(depth, np.rint(stored * STEP_MM))
        mask = cv2.imread(str(folder / "mask_visib" / "000000_000000.png"), cv2.IMREAD_UNCHANGED)
        np.testing.assert_array_equal(mask > 0, visible(image_id))


def test_a_conversion_that_was_broken_off_goes_on_to_the_same_bytes(
    converted: tuple[Path, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    theirs, ours = converted
    whole, written = DatasetStore.write_scene, []

    def stopping(self: DatasetStore, scene, *arguments, **options) -> None:
        if len(written) == 5:
            raise KeyboardInterrupt
        written.append(scene.scene_index)
        whole(self, scene, *arguments, **options)

    out = tmp_path / "ours"
    with monkeypatch.context() as patched:
        patched.setattr(DatasetStore, "write_scene", stopping)
        with pytest.raises(KeyboardInterrupt):
            convert(theirs, out, ("bop",))
    assert not (out / "manifest.json").exists()
    with pytest.raises(DatasetError, match="not empty"):
        convert(theirs, out, ("bop",))
    done = []
    convert(theirs, out, ("bop",), resume=True, progress=lambda count, total: done.append(count))
    assert done[0] == 5
    assert hashes(out) == hashes(ours)


def test_what_cannot_be_converted_is_rejected_in_one_line(
    converted: tuple[Path, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    theirs, ours = converted
    alone = {name: make_dataset(tmp_path / name, make_manifest(formats=(name,))) for name in ("coco", "kitti", "yolo")}
    for source, name, words in (
        (alone["coco"], "yolo", "coco: holds no depth images, which yolo is made of"),
        (alone["kitti"], "bop", "holds no mesh of pallet, which bop needs; choose a format that needs none"),
        (alone["kitti"], "linemod", "holds no mesh of pallet, which linemod needs"),
        (alone["kitti"], "kitti", "holds the format kitti already"),
        (alone["yolo"], "coco", "does not say how large pallet is"),
        (ours, "bop", "holds the format bop already"),
        (ours, "bob", "bob"),
        (theirs, "kitti", "every KITTI frame has a sweep"),
        (tmp_path, "bop", "no manifest.json"),
    ):
        assert main(["convert", str(source), "--to", name, "--out", str(tmp_path / "out")]) == 2
        lines = capsys.readouterr().err.splitlines()
        assert [words in line for line in lines if line.startswith("error:")] == [True], lines
        assert not (tmp_path / "out").exists()


def test_a_dataset_of_kitti_alone_is_converted_as_its_folder(tmp_path: Path) -> None:
    ours = make_dataset(tmp_path / "ours", make_manifest(formats=("kitti",)))
    for source, name in ((ours, "whole"), (ours / "kitti", "part")):
        convert(source, tmp_path / name, ("coco", "yolo", "ply", "mcap"))
    assert hashes(tmp_path / "whole") == hashes(tmp_path / "part")
    assert failures(tmp_path / "whole") == {}
