from pathlib import Path

import mujoco
import pytest

from tests.interchange.gltf_file import GltfFile
from warehouse_sim.cli.main import main


def test_a_scene_becomes_a_glb_file_with_the_rigs_cameras(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "new" / "scene.glb"
    command = ["export-scene", "smoke", "--scene", "1", "--seed", "2", "--to", "glb", "--out", str(out)]
    assert main(command) == 0
    printed = capsys.readouterr().out.splitlines()
    assert printed == [f"output: {out}", "next:   warehouse-sim preview smoke --scene 1 --seed 2"]
    file = GltfFile.read(out)
    assert file.root["scenes"][0]["extras"]["scene_index"] == 1
    assert file.root["scenes"][0]["extras"]["seed"] == 2
    assert file.named("nodes", "camera_000")["camera"] == 0
    first = out.read_bytes()
    assert main(command) == 0
    assert out.read_bytes() == first


def test_a_scene_becomes_mjcf_with_a_carriage(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "scene.xml"
    place = ["--carriage", "48:-x", "--carriage-distance", "0.4"]
    assert main(["export-scene", "smoke", "--to", "mjcf", "--out", str(out), *place]) == 0
    model = mujoco.MjModel.from_xml_path(str(out))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    assert data.sensor("tips_in_dock").data[0] == pytest.approx(-0.4, abs=1e-3)
    assert model.cam("camera_000").id == 0
