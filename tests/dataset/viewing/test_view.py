"""A dataset streamed to a Rerun recording, which is opened again with Rerun's own reader."""

import json
import os
import signal
import socket
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rerun
from rerun.chunk import RrdReader

from tests.dataset.toy import CAMERA, T_CAMERA_LIDAR, make_dataset, make_manifest, make_scene, observe
from warehouse_sim.cli.main import main
from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.viewing.stream import open_recording, stream_images
from warehouse_sim.errors import InputError
from warehouse_sim.geometry.lens import Distortion

IMAGE = "/world/rig/camera/image"


@pytest.fixture(scope="module")
def root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_dataset(tmp_path_factory.mktemp("view") / "data", make_manifest(formats=("bop", "ply")))


def rows(path: Path) -> dict[str, list[dict[str, Any]]]:
    """Return what was logged to each entity, in order of observation."""
    found: dict[str, list[dict[str, Any]]] = {}
    for chunk in RrdReader(str(path)).stream().to_chunks():
        found.setdefault(str(chunk.entity_path), []).extend(chunk.to_record_batch().to_pylist())
    return {name: sorted(items, key=lambda row: row.get("observation") or 0) for name, items in found.items()}


def test_a_recording_holds_every_image_with_its_boxes_and_points(root: Path, tmp_path: Path, capsys) -> None:
    path = tmp_path / "new" / "d.rrd"
    assert main(["view", str(root), "--save", str(path)]) == 0
    assert f"output: {path}" in capsys.readouterr().out
    assert [item.name for item in path.parent.iterdir()] == ["d.rrd"]
    found, observations = rows(path), [item for index in range(3) for item in observe(make_scene(index))]
    for name in ("", "/depth", "/masks", "/boxes"):
        assert len(found[IMAGE + name]) == len(observations) == 6
    for index, observation in enumerate(observations):
        points, boxes, solid = (
            found[name][index]
            for name in ("/world/rig/camera/lidar/points", f"{IMAGE}/boxes", "/world/rig/camera/boxes")
        )
        assert (points["observation"], points["scene"]) == (index, observation.scene_index)
        assert observation.lidar is not None
        np.testing.assert_array_equal(points["Points3D:positions"], observation.lidar.points)
        assert len(set(points["Points3D:colors"])) == len(set(observation.lidar.instance_ids.tolist()))
        labels = [item for item in observation.annotations if item.pixels_visible]
        assert boxes["Boxes2D:labels"] == [f"pallet {item.instance_id}" for item in labels] == solid["Boxes3D:labels"]
        # From the outer corner of the first pixel.
        edges = np.array([item.box_visible_xyxy for item in labels]).reshape(-1, 4) + np.array([0, 0, 1, 1])
        centres, halves = (
            np.reshape(boxes["Boxes2D:centers"], (-1, 2)),
            np.reshape(boxes["Boxes2D:half_sizes"], (-1, 2)),
        )
        np.testing.assert_allclose(np.column_stack([centres - halves, centres + halves]), edges, atol=1e-4)
        places = [item.T_camera_object[:3, 3] for item in labels]
        np.testing.assert_allclose(
            np.reshape(solid["Boxes3D:centers"], (-1, 3)), np.reshape(places, (-1, 3)), atol=1e-6
        )
        pixels = np.array(found[IMAGE][index]["Image:buffer"], np.uint8).reshape(observation.rgbd.rgb.shape)
        np.testing.assert_array_equal(pixels, observation.rgbd.rgb)
    # Twice as many stops as scenes: the way is that of the scene.
    assert [len(row["Points3D:positions"]) for row in found["/world/way/stops"]] == [1, 2, 1, 2, 1, 2]
    K = np.reshape(found[IMAGE][0]["Pinhole:image_from_camera"], (3, 3)).T
    np.testing.assert_allclose(K[:2, 2], [CAMERA.cx + 0.5, CAMERA.cy + 0.5], rtol=1e-6)
    lidar = found["/world/rig/camera/lidar"][0]
    np.testing.assert_allclose(np.ravel(lidar["Transform3D:translation"]), T_CAMERA_LIDAR[:3, 3], atol=1e-7)


def test_parts_of_a_dataset_are_shown(root: Path, tmp_path: Path) -> None:
    path = tmp_path / "d.rrd"
    assert main(["view", str(root), "--save", str(path), "--split", "val", "--limit", "1"]) == 0
    found = rows(path)
    assert len(found[IMAGE]) == 1
    assert found[IMAGE][0]["scene"] == 1
    (recording,) = RrdReader(str(path)).recordings()
    assert recording.recording_id == f"unnamed-{DatasetReader(root).digest[:12]}"


def test_behind_a_lens_points_are_where_they_are(root: Path, tmp_path: Path) -> None:
    reader = DatasetReader(root)
    image = reader.images("train")[0]
    image = replace(image, camera=replace(image.camera, distortion=Distortion(-0.1, 0.01)))
    with open_recording("x", tmp_path / "d.rrd") as recording:
        stream_images(reader, [image], recording)
    found = rows(tmp_path / "d.rrd")
    assert f"{IMAGE}/depth" not in found
    depth = reader.depth(image)
    expected = image.camera.unproject(depth)[depth > 0]
    np.testing.assert_allclose(found["/world/rig/camera/points"][0]["Points3D:positions"], expected, atol=1e-5)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [(["--limit", "0"], "--limit must be at least 1"), (["--split", "night"], "night")],
)
def test_what_cannot_be_shown_is_rejected(root: Path, tmp_path: Path, capsys, arguments: list[str], words: str) -> None:
    assert main(["view", str(root), "--save", str(tmp_path / "d.rrd"), *arguments]) == 2
    assert words in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_a_place_that_cannot_be_written_is_named(root: Path, tmp_path: Path, capsys) -> None:
    (tmp_path / "file").write_text("in the way")
    assert main(["view", str(root), "--save", str(tmp_path / "file" / "d.rrd")]) == 2
    assert f"{tmp_path / 'file'}: cannot be written" in capsys.readouterr().err


def test_what_breaks_off_leaves_no_file(tmp_path: Path) -> None:
    with pytest.raises(KeyboardInterrupt), open_recording("x", tmp_path / "d.rrd"):
        raise KeyboardInterrupt
    assert not list(tmp_path.iterdir())


def test_without_a_screen_the_file_is_the_remedy(root: Path, capsys, monkeypatch) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    assert main(["view", str(root)]) == 2
    (line,) = [line for line in capsys.readouterr().err.splitlines() if line.startswith("error:")]
    assert "--save FILE.rrd" in line


def test_without_a_viewer_one_line_says_so(monkeypatch) -> None:
    def fails(*_: Any, **__: Any) -> None:
        raise RuntimeError("Failed to find Rerun Viewer\nexecutable in PATH.")

    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setattr(rerun.RecordingStream, "spawn", fails)
    with (
        pytest.raises(InputError, match=r"could not be started \(Failed to find Rerun Viewer executable in PATH\.\)"),
        open_recording("x", None),
    ):
        pass


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="where viewers keep settings is Linux's way")
def test_a_viewer_is_started_on_loopback_and_told_to_send_nothing(root: Path, tmp_path: Path, monkeypatch) -> None:
    real = Path(rerun.__file__).parents[1] / "rerun_cli" / "rerun"
    if not real.exists():
        real = Path(sys.prefix) / "lib" / f"python3.{sys.version_info.minor}" / "site-packages" / "rerun_cli" / "rerun"
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    # In place of a window, the viewer's own server.
    script = tmp_path / "rerun"
    script.write_text(
        f'#!/bin/sh\n[ "$1" = --version ] && exec {real} --version\n'
        f"echo $$ > {tmp_path}/pid\necho $* > {tmp_path}/arguments\n"
        f"{real} analytics config > {tmp_path}/analytics 2> /dev/null\n"
        f"exec timeout 60 {real} --serve-grpc --bind 127.0.0.1 --port {port} > /dev/null 2>&1\n"
    )
    script.chmod(0o755)
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "mine"))
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
    reader = DatasetReader(root)
    try:
        with open_recording("x", None, port) as recording:
            stream_images(reader, reader.images("train")[:1], recording)
    finally:
        os.kill(int((tmp_path / "pid").read_text()), signal.SIGTERM)
    assert f"--port={port}" in (tmp_path / "arguments").read_text()
    assert json.loads((tmp_path / "analytics").read_text())["analytics_enabled"] is False
    assert os.environ["XDG_CONFIG_HOME"] == str(tmp_path / "mine")
    assert not (tmp_path / "mine").exists()
