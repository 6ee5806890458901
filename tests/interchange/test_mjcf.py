import json
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import mujoco
import numpy as np
import pytest

from warehouse_sim.errors import OutputError
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.generation.scene import prepare_scene
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.interchange import write_mjcf
from warehouse_sim.physics import to_mjspec
from warehouse_sim.render import open_renderer
from warehouse_sim.render.conformance.scenes import MATERIALS, at, box_model, make_scene, spot
from warehouse_sim.schema import Material
from warehouse_sim.sensors.rig import CameraConfig, RigConfig

RIG = RigConfig(camera=CameraConfig(320, 200, 260.0, cx=140.0, cy=110.0))


@pytest.fixture(scope="module")
def scene():
    return prepare_scene(load_recipe("smoke"), 0, 0).scene


@pytest.fixture(scope="module")
def path(scene, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_mjcf(scene, tmp_path_factory.mktemp("mjcf") / "hall.xml", RIG)


def test_masses_boxes_and_contacts_are_those_of_physics(scene, path: Path) -> None:
    file, physics = mujoco.MjModel.from_xml_path(str(path)), to_mjspec(scene).compile()
    assert (file.nbody, file.nv, file.opt.timestep) == (physics.nbody, physics.nv, physics.opt.timestep)
    assert file.opt.integrator == physics.opt.integrator
    assert file.narena == physics.narena
    for instance in scene.instances:
        name = str(instance.instance_id)
        for field in ("mass", "inertia", "ipos", "iquat", "pos", "quat"):
            found, wanted = getattr(file.body(name), field), getattr(physics.body(name), field)
            np.testing.assert_allclose(found, wanted, rtol=1e-9, atol=1e-10, err_msg=f"{field} of {name}")
    touching = [number for number in range(file.ngeom) if file.geom(number).contype[0]]
    assert len(touching) == physics.ngeom
    for number in touching:
        wanted = physics.geom(file.geom(number).name)
        for field in ("size", "pos", "quat", "friction", "solref", "solimp", "conaffinity"):
            np.testing.assert_allclose(getattr(file.geom(number), field), getattr(wanted, field), atol=1e-10)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["smoke", "block_storage"])
def test_a_settled_scene_stays_for_five_seconds(tmp_path: Path, name: str) -> None:
    path = write_mjcf(prepare_scene(load_recipe(name), 0, 0).scene, tmp_path / "scene.xml")
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    before = data.qpos.reshape(-1, 7).copy()
    assert len(before) > 30
    worst = np.zeros(len(before))
    for _ in range(10):
        mujoco.mj_step(model, data, nstep=250)
        worst = np.maximum(worst, np.linalg.norm(data.qpos.reshape(-1, 7)[:, :3] - before[:, :3], axis=1))
    assert data.time == pytest.approx(5.0)
    assert 1000.0 * worst.max() < 2.0
    assert not any(warning.number for warning in data.warning)


@pytest.mark.gl
def test_its_own_cameras_show_what_the_backend_draws(scene, path: Path) -> None:
    camera = RIG.make_camera()
    with open_renderer("mujoco") as renderer:
        renderer.load(scene)
        wanted = renderer.render(camera, scene.viewpoints[1].T_world_camera).rgb
        model = mujoco.MjModel.from_xml_path(str(path))
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        with mujoco.Renderer(model, camera.height, camera.width) as viewer:
            viewer.update_scene(data, camera="camera_001")
            shown = viewer.render()
    assert np.ptp(wanted) > 100
    difference = np.abs(shown.astype(int) - wanted)
    assert difference.mean() < 0.1
    assert (difference > 8).mean() < 0.001


def test_all_files_lie_in_its_folder_and_go_with_it(path: Path, tmp_path: Path) -> None:
    root = ElementTree.parse(path).getroot()
    assert root.find("compiler").attrib["meshdir"] == root.find("compiler").attrib["texturedir"] == "hall"
    named = [item.attrib["file"] for item in root.find("asset") if "file" in item.attrib]
    assert sorted(named) == sorted(item.name for item in (path.parent / "hall").iterdir())
    assert not any("/" in name for name in named)
    (tmp_path / "moved").mkdir()
    path.rename(tmp_path / "moved" / "hall.xml")
    (path.parent / "hall").rename(tmp_path / "moved" / "hall")
    try:
        assert mujoco.MjModel.from_xml_path(str(tmp_path / "moved" / "hall.xml")).ntex > 10
    finally:
        (tmp_path / "moved" / "hall.xml").rename(path)
        (tmp_path / "moved" / "hall").rename(path.parent / "hall")


def test_textures_have_normals_and_roughness_as_layers(path: Path) -> None:
    model = mujoco.MjModel.from_xml_path(str(path))
    roles = mujoco.mjtTextureRole
    rough = np.flatnonzero(model.mat_texid[:, roles.mjTEXROLE_ROUGHNESS] >= 0)
    found = next(item for item in map(model.mat, rough) if model.tex(item.texid[1]).name == "slab")
    for role, channel in ((roles.mjTEXROLE_RGB, 0), (roles.mjTEXROLE_NORMAL, 1), (roles.mjTEXROLE_ROUGHNESS, 0)):
        texture = model.tex(found.texid[role])
        start, size = int(texture.adr[0]), int(texture.height[0] * texture.width[0] * texture.nchannel[0])
        texels = model.tex_data[start : start + size].reshape(-1, int(texture.nchannel[0]))
        assert texels[:, channel].std() > 1.0
    assert 0.0 < model.mat_roughness[found.id] <= 1.0


def test_all_lights_are_there_and_the_strongest_are_on(tmp_path: Path) -> None:
    lights = [replace(spot((x, 0, 4)), intensity=1000.0 + 100 * x) for x in range(10)]
    scene = make_scene([box_model("carton", (0.6, 0.4, 0.3))], [("carton", at(4.5, 0, 0.15))], lights)
    model = mujoco.MjModel.from_xml_path(str(write_mjcf(scene, tmp_path / "a.xml")))
    assert model.nlight == 10
    assert sorted(model.light_intensity) == pytest.approx([light.intensity for light in lights])
    assert list(model.light_active).count(True) == 7
    assert list(model.light_active)[:7] == [True] * 7


def test_film_moves_with_its_pallet(tmp_path: Path) -> None:
    clear = Material("clear", (0.8, 0.8, 0.8), opacity=0.2)
    base = box_model("base", (1.2, 0.8, 0.15), "wood", "pallet")
    base = replace(base, collision=(OrientedBox(np.eye(4), base.size),), mass=20.0)
    film = box_model("film", (1.2, 0.8, 1.0), "clear", "wrap", 3)
    placed = [("film", at(2.0, 1.0, 0.65, 0.4)), ("base", at(2.0, 1.0, 0.075, 0.4))]
    scene = make_scene([base, film], placed, [spot((0, 0, 4))], materials=MATERIALS | {"clear": clear})
    wrap, pallet = (replace(item, group=1) for item in scene.instances)
    scene = replace(scene, instances=(wrap, replace(pallet, dynamic=True)))
    model = mujoco.MjModel.from_xml_path(str(write_mjcf(scene, tmp_path / "a.xml")))
    assert model.body("1").parentid == model.body("2").id
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(data.body("1").xpos, [2.0, 1.0, 0.65], atol=1e-9)
    assert model.body("2").subtreemass == pytest.approx(20.0)
    (seen,) = [model.geom(number) for number in range(model.ngeom) if model.geom(number).bodyid == model.body("1").id]
    assert (seen.group[0], seen.contype[0], seen.matid[0]) == (1, 0, model.mat("clear").id)


def test_bodies_and_cameras_are_explained(scene, path: Path) -> None:
    texts = {item.attrib["name"]: json.loads(item.attrib["data"]) for item in ElementTree.parse(path).find("custom")}
    for instance in scene.instances:
        model = scene.model_of(instance)
        row = [model.class_name, model.obj_id, instance.model, instance.group]
        assert texts["objects"][str(instance.instance_id)] == row
    assert texts["cameras"]["camera_000"]["K"] == RIG.make_camera().K.ravel().tolist()
    assert texts["scene"]["exposure"] == scene.exposure


def test_a_name_without_xml_is_rejected(scene, tmp_path: Path) -> None:
    with pytest.raises(OutputError, match=r"scene\.mjcf: .*choose a name that ends with \.xml"):
        write_mjcf(scene, tmp_path / "scene.mjcf")
    (tmp_path / "taken").write_text("")
    with pytest.raises(OutputError, match="taken: cannot be written"):
        write_mjcf(scene, tmp_path / "taken.xml")
