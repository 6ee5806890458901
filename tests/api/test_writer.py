import json
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import warehouse_sim as ws
from tests.api.crates import write_crate
from warehouse_sim.dataset.discard import discard_dataset
from warehouse_sim.dataset.manifest import read_manifest
from warehouse_sim.errors import ConfigError, DatasetError, InputError, OutputError, UnknownNameError
from warehouse_sim.generation.verify import verify

CAMERA = ws.Camera(width=320, height=200, focal_px=200, focal_y_px=210, distortion={"k1": -0.05}, depth="ideal")


@cache
def shots(x: float = 0.0, views: int = 2, extra: Path | None = None, camera: ws.Camera = CAMERA) -> list[Any]:
    scene = ws.Scene()
    scene.add("epal1", x=x)
    scene.add("carton_400x300x200", x=x)
    if extra is not None:
        scene.add(extra, x=x + 1.5)
    return scene.settle().render(camera, views=views)


@pytest.fixture(scope="module")
def crate(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_crate(tmp_path_factory.mktemp("crate"))


@pytest.fixture(scope="module")
def stored(crate: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a dataset of three scenes, in the last of which a crate comes."""
    folder = tmp_path_factory.mktemp("writer")
    with ws.Writer(folder / "out", formats=["bop", "coco"]) as out:
        for taken in (shots(), shots(0.3), shots(0.6, extra=crate)):
            out.write(taken)
    return folder / "out"


@pytest.mark.gl
def test_scenes_by_hand_are_a_whole_dataset(stored: Path) -> None:
    checks = ws.validate(stored)
    assert checks.ok, str(checks)
    data = ws.Dataset(stored)
    assert len(data) == 6
    assert {name: len(data.split(name)) for name in data.splits} == {"train": 2, "val": 2, "test": 2}
    assert {o.name for obs in data for o in obs.objects} == {"epal1", "carton_400x300x200", "crate"}
    assert "python SCRIPT" in (stored / "README.md").read_text()
    assert not (stored / "card" / "recipe.yaml").exists()
    assert data[0].camera == CAMERA.model


@pytest.mark.gl
def test_what_is_stored_is_what_was_rendered(tmp_path: Path) -> None:
    taken = shots()
    with ws.Writer(tmp_path / "out") as out:
        out.write(taken)
    for shot, obs in zip(taken, ws.Dataset(tmp_path / "out"), strict=True):
        np.testing.assert_array_equal(obs.rgb, shot.rgb)
        np.testing.assert_allclose(obs.depth, shot.depth, atol=0.000501)
        np.testing.assert_array_equal(obs.instance_mask, shot.instance_mask)
        for one, two in zip(obs.objects, shot.objects, strict=True):
            np.testing.assert_allclose(one.T_camera_object, two.T_camera_object, atol=1e-9)
            np.testing.assert_allclose(one.box_3d, two.box_3d, atol=1e-9)
            assert (one.name, one.visible_fraction) == (two.name, two.visible_fraction)


@pytest.mark.gl
def test_bop_toolkit_finds_what_it_opens(stored: Path) -> None:
    """Read the folder as ``bop_toolkit_lib.dataset_params`` and ``inout`` do."""
    root = stored / "bop"
    camera = json.loads((root / "camera.json").read_text())
    assert {"cx", "cy", "depth_scale", "fx", "fy", "width", "height"} <= set(camera)
    assert camera["fy"] == 210.0
    models = {path.name for path in (root / "models").glob("obj_*.ply")}
    infos = json.loads((root / "models" / "models_info.json").read_text())
    assert models == {f"obj_{int(key):06d}.ply" for key in infos}
    assert len(models) == 3
    assert {"diameter", "min_x", "size_x"} <= set(next(iter(infos.values())))
    seen = set()
    for split in ("train", "val", "test"):
        for scene in (root / split).iterdir():
            tables = {name: json.loads((scene / f"{name}.json").read_text()) for name in
                      ("scene_gt", "scene_camera", "scene_gt_info")}  # fmt: skip
            for image, rows in tables["scene_gt"].items():
                assert (scene / "rgb" / f"{int(image):06d}.png").is_file()
                assert (scene / "depth" / f"{int(image):06d}.png").is_file()
                assert np.reshape(tables["scene_camera"][image]["cam_K"], (3, 3))[1, 1] == 210.0
                assert len(rows) == len(tables["scene_gt_info"][image])
                for index, row in enumerate(rows):
                    assert len(row["cam_R_m2c"]) == 9
                    assert len(row["cam_t_m2c"]) == 3
                    assert (scene / "mask_visib" / f"{int(image):06d}_{index:06d}.png").is_file()
                    seen.add(row["obj_id"])
    assert {f"obj_{number:06d}.ply" for number in seen} == models
    targets = json.loads((root / "test_targets_bop19.json").read_text())
    assert targets
    assert {"im_id", "inst_count", "obj_id", "scene_id"} <= set(targets[0])


@pytest.mark.gl
def test_an_error_within_leaves_a_folder_that_is_incomplete(tmp_path: Path) -> None:
    root = tmp_path / "out"
    taken = shots()

    def stop() -> None:
        with ws.Writer(root) as out:
            out.write(taken)
            raise RuntimeError("of the user")

    with pytest.raises(RuntimeError, match="of the user"):
        stop()
    with pytest.raises(DatasetError, match=r"incomplete.*overwrite=True"):
        ws.Dataset(root)
    with pytest.raises(DatasetError, match=r"not empty.*overwrite=True"), ws.Writer(root):
        pass
    with ws.Writer(root, overwrite=True) as out:
        out.write(taken[:1])
    assert len(ws.Dataset(root)) == 1
    with pytest.raises(DatasetError, match=r"put together in Python"):
        verify(root, 1)


@pytest.mark.gl
def test_what_does_not_go_together_is_rejected(crate: Path, tmp_path: Path) -> None:
    first = shots()
    with pytest.raises(InputError, match=r"not open.*with ws.Writer"):
        ws.Writer(tmp_path / "a").write(first)
    with ws.Writer(tmp_path / "b", formats="yolo") as out:
        with pytest.raises(OutputError, match=r"is writing there"), ws.Writer(tmp_path / "b"):
            pass
        out.write(first)
        for wrong, words in (
            (first[:1], "1 shots, each scene before has 2"),
            ([first[0], shots(0.3)[0]], "several scenes"),
            (shots(camera=ws.Camera("kitti")), "other sensors"),
            (shots(0.6, extra=crate), "crate is new, but yolo.*objects"),
        ):
            with pytest.raises(DatasetError, match=words):
                out.write(wrong)
        for nothing in ([], 5, [5]):
            with pytest.raises(InputError, match=r"shot"):
                out.write(nothing)  # type: ignore[arg-type]
    assert read_manifest(tmp_path / "b").scenes == 1
    assert ws.validate(tmp_path / "b").ok


@pytest.mark.parametrize(
    ("call", "error", "words"),
    [
        (lambda root: ws.Writer(5), InputError, "out must be"),
        (lambda root: ws.Writer(root, formats=["bpo"]), UnknownNameError, "bpo"),
        (lambda root: ws.Writer(root, formats=[]), InputError, "name one"),
        (lambda root: ws.Writer(root, formats=["bop", "bop"]), InputError, "each once"),
        (lambda root: ws.Writer(root, formats="kitti"), DatasetError, "level cameras.*bop"),
        (lambda root: ws.Writer(root, split={"train": 2.0}), ConfigError, "train"),
        (lambda root: ws.Writer(root, objects=["epall"]), UnknownNameError, "epall"),
    ],
)
def test_wrong_settings_are_said_before_a_folder_is_made(
    call: Callable[[Path], Any], error: type[Exception], words: str, tmp_path: Path
) -> None:
    with pytest.raises(error, match=words):
        call(tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_writer_of_nothing_leaves_nothing(tmp_path: Path) -> None:
    with pytest.raises(DatasetError, match=r"no scene was written.*write\(\)"), ws.Writer(tmp_path / "out"):
        pass
    assert not (tmp_path / "out").exists()


def test_nothing_else_is_overwritten(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("kept")
    with pytest.raises(DatasetError, match=r"holds no dataset"), ws.Writer(tmp_path, overwrite=True):
        pass
    with pytest.raises(DatasetError, match=r"holds no dataset"):
        discard_dataset(tmp_path)
    assert (tmp_path / "mine.txt").read_text() == "kept"
