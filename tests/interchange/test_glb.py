from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from tests.interchange.gltf_file import GltfFile
from warehouse_sim.geometry.pose import level_camera, transform_points
from warehouse_sim.interchange import write_glb
from warehouse_sim.render.conformance.scenes import MATERIALS, at, box_model, make_scene, spot
from warehouse_sim.resources import data_folder
from warehouse_sim.schema import Light, Material
from warehouse_sim.sensors.rig import CameraConfig, RigConfig
from warehouse_sim.sensors.stereo import StereoConfig

TO_Y_UP = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])


def linear(code: np.ndarray) -> np.ndarray:
    return np.where(code > 0.04045, ((code + 0.055) / 1.055) ** 2.4, code / 12.92)


def box_scene(material: Material, lights=(), viewpoints=()):
    model = box_model("carton", (0.6, 0.4, 0.3), material.name)
    scene = make_scene([model], [("carton", at(1.0, 2.0, 0.15, 0.3))], lights, viewpoints, {material.name: material})
    return scene


def written(scene, tmp_path: Path, rig=None) -> GltfFile:
    return GltfFile.read(write_glb(scene, tmp_path / "scene.glb", rig))


@pytest.mark.parametrize(("shade", "roughness"), [(0.3, 0.4), (0.9, 0.95)])
def test_a_texture_times_its_factor_is_what_renderers_multiply(tmp_path: Path, shade: float, roughness: float) -> None:
    material = Material("boards", (shade, shade / 2, shade / 4), roughness, texture="wood", texture_size=0.5)
    file = written(box_scene(material), tmp_path)
    look = file.root["materials"][0]
    shading = look["pbrMetallicRoughness"]
    folder = data_folder("assets") / "textures" / "wood"
    albedo = cv2.imread(str(folder / "albedo.png"), cv2.IMREAD_GRAYSCALE) / 128.0
    shown = linear(file.pixels(shading["baseColorTexture"])) * shading["baseColorFactor"][0]
    wanted = np.minimum(shade * albedo, 1.0)
    assert np.abs(shown - wanted).max() < 0.035  # a step of the ceiling where it is cut off
    assert np.median(np.abs(shown - wanted)) < 0.003
    rough = cv2.imread(str(folder / "roughness.png"), cv2.IMREAD_GRAYSCALE) / 128.0
    green = file.pixels(shading["metallicRoughnessTexture"])[..., 1] * shading["roughnessFactor"]
    assert np.abs(green - np.minimum(roughness * rough, 1.0)).max() < 0.035
    bent = cv2.imread(str(folder / "normal.png"), cv2.IMREAD_COLOR)[..., ::-1]
    np.testing.assert_array_equal(np.rint(255 * file.pixels(look["normalTexture"])), bent)


def test_texture_coordinates_lie_in_metres_and_tangents_along_them(tmp_path: Path) -> None:
    material = Material("boards", (0.4, 0.3, 0.2), texture="concrete", texture_size=0.5)
    file = written(box_scene(material), tmp_path)
    (primitive,) = file.root["meshes"][0]["primitives"]
    found = {name: file.array(index).astype(float) for name, index in primitive["attributes"].items()}
    faces = file.array(primitive["indices"]).reshape(-1, 3)
    assert len(faces) == 12
    for corners in faces:
        positions, tiles = found["POSITION"][corners], found["TEXCOORD_0"][corners]
        # The plane map from texture to space: its columns are the directions of growing u and v.
        steps = np.linalg.lstsq(np.diff(tiles, axis=0), np.diff(positions, axis=0), rcond=None)[0]
        np.testing.assert_allclose(np.linalg.norm(steps, axis=1), 0.5, rtol=1e-4)
        normal, tangent = found["NORMAL"][corners[0]], found["TANGENT"][corners[0]]
        np.testing.assert_allclose(tangent[:3], steps[0] / 0.5, atol=1e-4)
        # glTF 2.0, 3.7.2.1: the bitangent is cross(normal, tangent) w, and green points up the image, against v.
        np.testing.assert_allclose(np.cross(normal, tangent[:3]) * tangent[3], -steps[1] / 0.5, atol=1e-4)
        outwards = np.cross(positions[1] - positions[0], positions[2] - positions[0])
        assert outwards @ normal > 0.9 * np.linalg.norm(outwards)


def test_a_label_stands_upright_and_unmirrored(tmp_path: Path) -> None:
    material = Material("labelled", (0.5, 0.4, 0.3), picture="shipping_label:7")
    model = box_model("carton", (0.6, 0.02, 0.3), "labelled")
    scene = make_scene([model], [("carton", at(0, 0, 0))], materials={"labelled": material})
    file = written(scene, tmp_path)
    (primitive,) = file.root["meshes"][0]["primitives"]
    found = {name: file.array(index).astype(float) for name, index in primitive["attributes"].items()}
    front = found["NORMAL"][:, 1] < -0.9
    # Seen from -y, x is to the right and z up: the image's left upper corner lies at the least x and the greatest z.
    positions, tiles = found["POSITION"][front], found["TEXCOORD_0"][front]
    np.testing.assert_allclose(tiles[:, 0], positions[:, 0] / 0.6 + 0.5, atol=1e-5)
    np.testing.assert_allclose(tiles[:, 1], 0.5 - positions[:, 2] / 0.3, atol=1e-5)
    look = file.root["materials"][0]
    texture = look["pbrMetallicRoughness"]["baseColorTexture"]
    assert file.root["samplers"][file.root["textures"][texture["index"]]["sampler"]]["wrapS"] == 33071
    assert np.ptp(file.pixels(texture)) > 0.5  # ink on paper
    assert look["pbrMetallicRoughness"]["baseColorFactor"] == [1.0, 1.0, 1.0, 1.0]


def test_film_and_glow_are_kept(tmp_path: Path) -> None:
    film = written(box_scene(Material("film", (0.8, 0.8, 0.8), 0.2, opacity=0.25)), tmp_path).root["materials"][0]
    assert film["alphaMode"] == "BLEND"
    assert film["pbrMetallicRoughness"]["baseColorFactor"][3] == 0.25
    file = written(box_scene(Material("lamp", (0.5, 0.25, 0.5), emission=4000.0)), tmp_path)
    lamp = file.root["materials"][0]
    strength = lamp["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"]
    assert np.multiply(lamp["emissiveFactor"], strength) == pytest.approx([2000.0, 1000.0, 2000.0])
    assert "KHR_materials_emissive_strength" in file.root["extensionsUsed"]


def test_lights_keep_candela_colour_cone_and_axis(tmp_path: Path) -> None:
    axis = np.array([0.6, 0.0, -0.8])
    first = Light("spot", np.array([1.0, 2.0, 5.0]), axis, 4000.0, (1.25, 1.0, 0.5), 0.4, 0.9)
    second = replace(spot((0, 0, 3)), kind="point", intensity=300.0)
    file = written(box_scene(MATERIALS["wood"], [first, second]), tmp_path)
    lights = file.root["extensions"]["KHR_lights_punctual"]["lights"]
    assert [item["type"] for item in lights] == ["spot", "point"]
    assert np.multiply(lights[0]["color"], lights[0]["intensity"]) == pytest.approx([5000.0, 4000.0, 2000.0])
    assert max(lights[0]["color"]) == 1.0
    assert lights[0]["spot"] == pytest.approx({"innerConeAngle": 0.4, "outerConeAngle": 0.9})
    T = file.world("light_000")
    np.testing.assert_allclose(-T[:3, 2], TO_Y_UP @ axis, atol=1e-9)  # lights shine along their -z
    np.testing.assert_allclose(T[:3, 3], TO_Y_UP @ first.position, atol=1e-9)


def test_cameras_see_what_the_rig_sees(tmp_path: Path) -> None:
    rig = RigConfig(camera=CameraConfig(640, 480, 500.0), right=StereoConfig(baseline=0.12))
    T_world_camera = level_camera(np.array([-1.0, 0.5, 1.4]), 0.2, -0.1, 0.05)
    scene = box_scene(MATERIALS["wood"], viewpoints=[T_world_camera])
    file, camera = written(scene, tmp_path, rig), rig.make_camera()
    point = np.array([2.0, 1.0, 1.0])
    for name, aside in (("camera_000", 0.0), ("right_000", 0.12)):
        seen = transform_points(np.linalg.inv(T_world_camera), point[None])[0] - [aside, 0.0, 0.0]
        wanted = camera.project(seen[None])[0]
        view = file.root["cameras"][file.named("nodes", name)["camera"]]["perspective"]
        x, y, z = transform_points(np.linalg.inv(file.world(name)), (TO_Y_UP @ point)[None])[0]
        height = 2.0 * np.tan(view["yfov"] / 2.0)
        u = (0.5 + x / -z / (height * view["aspectRatio"])) * 640 - 0.5
        v = (0.5 - y / -z / height) * 480 - 0.5
        assert (u, v) == pytest.approx(tuple(wanted), abs=1e-6)
        assert file.named("nodes", name)["extras"]["K"] == camera.K.ravel().tolist()


def test_each_geometry_and_image_is_stored_once(tmp_path: Path) -> None:
    textured = {name: replace(item, texture="wood") for name, item in MATERIALS.items()}
    placed = [("carton", at(x, 0, 0)) for x in range(20)]
    scene = make_scene([box_model("carton", (0.6, 0.4, 0.3))], placed, materials=textured)
    paints = [{}, {"kraft": "wood"}, {"kraft": "concrete"}]
    painted = [replace(item, paint=paints[number % 3]) for number, item in enumerate(scene.instances)]
    file = written(replace(scene, instances=tuple(painted)), tmp_path)
    assert len(file.root["meshes"]) == 3
    positions = {item["primitives"][0]["attributes"]["POSITION"] for item in file.root["meshes"]}
    assert len(positions) == 1
    views = [file.view(number) for number in range(len(file.root["bufferViews"]))]
    assert len(set(views)) == len(views)
    assert [node["extras"]["instance_id"] for node in file.root["nodes"] if "mesh" in node] == list(range(1, 21))


def test_triangles_without_area_are_left_out(tmp_path: Path) -> None:
    scene = box_scene(MATERIALS["wood"])
    part = scene.models["carton"].parts[0]
    flat = np.concatenate([part.mesh.faces, [[0, 0, 1]]]).astype(np.int32)
    broken = replace(part, mesh=replace(part.mesh, faces=flat))
    scene = replace(scene, models={"carton": replace(scene.models["carton"], parts=(broken,))})
    file = written(scene, tmp_path)
    (primitive,) = file.root["meshes"][0]["primitives"]
    assert len(file.array(primitive["indices"])) == 36
    lengths = np.linalg.norm(file.array(primitive["attributes"]["NORMAL"]), axis=1)
    assert lengths == pytest.approx(np.ones(len(lengths)), abs=1e-5)
