"""A scene written as USD is read back as itself, looks the same, and follows what others change in the file."""

import shutil
from dataclasses import fields, is_dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux

from warehouse_sim.errors import DatasetError
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.interchange import read_usd, write_usd
from warehouse_sim.scene import sample_scene
from warehouse_sim.schema import Light, SceneSpec, Viewpoint
from warehouse_sim.schema.intensity import ANGLES, PLANES, IntensityDistribution

WAREHOUSE = """
extends: selective_rack
description: Two bays of it.
scene:
  layout: {bays: 2, levels: 2, rows_behind: 1, sides: one}
  traffic: {trucks: 0, side_trucks: 0}
  observations_per_scene: 2
"""


def scene_of(name: str, folder: Path) -> tuple[SceneSpec, Any]:
    if name == "warehouse":
        name = str(folder / "warehouse.yaml")
        Path(name).write_text(WAREHOUSE)
    recipe = load_recipe(name)
    return sample_scene(recipe.scene, seed=0, scene_index=0), recipe.sensors


@pytest.fixture(scope="module", params=["smoke", pytest.param("warehouse", marks=pytest.mark.slow)])
def pair(request, tmp_path_factory) -> tuple[SceneSpec, SceneSpec]:
    folder = tmp_path_factory.mktemp(request.param)
    scene, rig = scene_of(request.param, folder)
    return scene, read_usd(write_usd(scene, folder / "scene.usdc", rig))


def differences(one: Any, other: Any, where: str = "scene") -> list[str]:
    """Return what differs by more than 1e-6, relative for numbers above 1."""
    if is_dataclass(one):
        pairs = [(getattr(one, item.name), getattr(other, item.name), f"{where}.{item.name}") for item in fields(one)]
    elif isinstance(one, dict):
        if one.keys() != other.keys():
            return [f"{where}: {one.keys() ^ other.keys()}"]
        pairs = [(one[key], other[key], f"{where}[{key}]") for key in one]
    elif isinstance(one, tuple | list) and len(one) == len(other):
        pairs = [(a, b, f"{where}[{k}]") for k, (a, b) in enumerate(zip(one, other, strict=True))]
    elif isinstance(one, np.ndarray):
        same = one.shape == other.shape and np.abs(one - other.astype(float)).max(initial=0.0) < 1e-6
        return [] if same else [f"{where}: {one} {other}"]
    elif isinstance(one, float):
        return [] if abs(one - other) < 1e-6 * max(1.0, abs(one)) else [f"{where}: {one} {other}"]
    else:
        return [] if one == other else [f"{where}: {one!r} {other!r}"]
    return [found for pair in pairs for found in differences(*pair)]


def test_the_scene_comes_back(pair) -> None:
    scene, again = pair
    used = {item.model for item in scene.instances}
    placed = replace(scene, models={name: model for name, model in scene.models.items() if name in used})
    assert differences(placed, replace(again, models={name: again.models[name] for name in placed.models})) == []
    assert again.models.keys() == used


def test_the_warehouse_has_all_that_is_hard(tmp_path: Path) -> None:
    scene, _ = scene_of("warehouse", tmp_path)
    materials = scene.materials.values()
    assert any(item.picture for item in materials)
    assert any(item.opacity < 1.0 for item in materials)
    assert any(item.emission > 0.0 for item in materials)
    assert any(item.paint for item in scene.instances)
    rounded = [np.abs(part.mesh.vertices.astype(np.float32) - part.mesh.vertices).max()
               for item in scene.instances for part in scene.model_of(item).parts]  # fmt: skip
    assert max(rounded) > 1e-6  # single precision would not do


def test_meshes_are_shared_again(pair) -> None:
    """Renderers draw what shares a mesh in one call."""
    meshes = [{id(part.mesh) for item in scene.instances for part in scene.model_of(item).parts} for scene in pair]
    assert len(meshes[1]) <= len(meshes[0])


@pytest.mark.slow
@pytest.mark.gl
def test_a_picture_of_it_differs_by_rounding_only(pair) -> None:
    from warehouse_sim.render import open_renderer

    scene, again = pair
    camera = PinholeCamera.from_focal(480, 300, 330.0)
    with open_renderer("raster") as renderer:
        for index in (0, 1):
            views = []
            for item in (scene, again):
                viewpoint = item.viewpoints[index]
                renderer.load(item.seen_from(viewpoint))
                views.append(renderer.render(camera, viewpoint.T_world_camera))
            one, other = views
            np.testing.assert_array_equal(one.instance_mask, other.instance_mask)
            np.testing.assert_allclose(one.depth, other.depth, atol=1e-5)
            step = np.abs(one.rgb.astype(int) - other.rgb.astype(int))
            assert step.max() <= 1
            assert (step > 0).mean() < 1e-3
            assert one.rgb.std() > 10


@pytest.fixture(scope="module")
def written(tmp_path_factory) -> tuple[SceneSpec, Path]:
    """A scene and the folder of its file, to read only."""
    folder = tmp_path_factory.mktemp("written")
    scene, rig = scene_of("smoke", folder)
    write_usd(scene, folder / "scene.usda", rig)
    return scene, folder


@pytest.fixture
def smoke(written, tmp_path: Path) -> tuple[SceneSpec, Path]:
    scene, folder = written
    return scene, Path(shutil.copytree(folder, tmp_path / "inner")) / "scene.usda"


def test_lights_of_all_kinds_and_vehicles_come_back(smoke, tmp_path: Path) -> None:
    fraction = np.random.default_rng(0).random((PLANES, ANGLES)).astype(np.float32)
    fraction[3, 5] = 1.0
    measured = IntensityDistribution("measured: 1", 812.5, fraction)
    down = np.array([0.0, 0.0, -1.0])
    lights = (
        Light("spot", np.array([1.0, 2.0, 6.0]), down, 500.0, distribution=measured, along=(0.6, 0.8, 0.0), fill=True),
        Light("point", np.array([0.3, 0.2, 2.0]), down, 120.0, (1.2, 1.0, 0.7), radius=0.0, casts_shadow=False),
        Light("spot", np.array([0.3, 0.2, 2.0]), np.array([1.0, 0.0, 0.0]), 120.0, cone_inner=0.0, cone_outer=0.4),
    )
    scene = smoke[0]
    place = replace(scene.viewpoints[0], lights=lights[2:], exposure=0.02, visible_request=(0.2, 0.4), sequence=3,
                    velocity=(1.0, 0.5, 0.0), yaw_rate=0.1, time=2.5, target=18)  # fmt: skip
    scene = replace(scene, lights=lights, viewpoints=(place, Viewpoint(np.eye(4), kind="free")), aisle=None)
    again = read_usd(write_usd(scene, tmp_path / "lit" / "scene.usdc"))
    assert differences(scene.viewpoints, again.viewpoints) == []
    for light, found in zip(scene.lights, again.lights, strict=True):
        assert differences(replace(light, distribution=None, direction=down),
                           replace(found, distribution=None, direction=down)) == []  # fmt: skip
        if light.kind == "spot":
            assert differences(light.direction, found.direction) == []
    found = again.lights[0].distribution
    assert found is not None
    assert (found.name, found.peak) == ("measured: 1", 812.5)
    np.testing.assert_array_equal(found.fraction, fraction)


def test_what_another_program_changes_is_read(smoke) -> None:
    scene, path = smoke
    stage = Usd.Stage.Open(str(path))
    moved, lamp = stage.GetPrimAtPath("/World/object_000018"), stage.GetPrimAtPath("/World/Lights/light_000")
    UsdGeom.XformCommonAPI(stage.GetPrimAtPath("/World")).SetTranslate((0.0, 0.0, 0.25))
    UsdGeom.Xformable(moved).MakeMatrixXform().Set(Gf.Matrix4d().SetTranslate(Gf.Vec3d(1.0, 2.0, 3.0)))
    UsdLux.SphereLight(lamp).GetExposureAttr().Set(1.0)
    stage.GetPrimAtPath("/World/Materials/pallet_wood/surface").GetAttribute("inputs:roughness").Set(0.25)
    stage.RemovePrim("/World/object_000050")
    stage.GetRootLayer().Save()
    again = read_usd(path)
    assert len(again.instances) == len(scene.instances) - 1
    found = next(item for item in again.instances if item.instance_id == 18)
    np.testing.assert_allclose(found.T_world_object[:3, 3], [1.0, 2.0, 3.25])
    assert again.lights[0].intensity == pytest.approx(2 * scene.lights[0].intensity, rel=1e-6)
    assert again.materials["pallet_wood"].roughness == 0.25


def mesh_of(stage: Usd.Stage) -> UsdGeom.Mesh:
    return UsdGeom.Mesh(stage.GetPrimAtPath("/World/Models/Meshes/mesh_0000"))


FAULTS = {
    "corner": (lambda s: mesh_of(s).GetFaceVertexIndicesAttr().Set([0, 1, 99] * 12), r"mesh|part_\d+ must name its"),
    "polygon": (lambda s: mesh_of(s).GetFaceVertexCountsAttr().Set([4] * 9), "must be triangles"),
    "nan": (lambda s: mesh_of(s).GetPointsAttr().Set([Gf.Vec3f(float("nan"))] * 8), "must have finite points"),
    "text": (lambda s: s.GetDefaultPrim().SetCustomDataByKey("exposure", "much"), "exposure must be of type float"),
    "infinite": (lambda s: s.GetDefaultPrim().SetCustomDataByKey("exposure", float("inf")), "finite number"),
    "lacking": (lambda s: s.GetDefaultPrim().ClearCustomDataByKey("lighting"), "custom data lacks lighting"),
    "twice": (lambda s: s.GetPrimAtPath("/World/object_000003").SetCustomDataByKey("instance_id", 2), "instance_id"),
    "negative": (lambda s: s.GetPrimAtPath("/World/Lights/light_000").GetAttribute("inputs:intensity").Set(-1.0),
                 "not negative"),
    "unbound": (lambda s: s.RemovePrim("/World/Materials/pallet_wood"), "is no material there"),
    "stranger": (lambda s: s.GetDefaultPrim().ClearCustomData(), "holds no scene of warehouse-sim"),
    "y up": (lambda s: UsdGeom.SetStageUpAxis(s, "Y"), "must be z up"),
    "outside": (lambda s: s.GetRootLayer().subLayerPaths.append("../other.usda"), "outside its folder"),
}  # fmt: skip


@pytest.mark.parametrize("fault", FAULTS)
def test_a_broken_file_is_rejected_in_one_line(fault: str, smoke, tmp_path: Path) -> None:
    Sdf.Layer.CreateNew(str(tmp_path / "other.usda")).Save()
    _, path = smoke
    stage = Usd.Stage.Open(str(path))
    break_it, message = FAULTS[fault]
    break_it(stage)
    stage.GetRootLayer().Save()
    del stage
    with pytest.raises(DatasetError, match=message) as caught:
        read_usd(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("content", [b"", b"#usda 1.0\n(", b"PXR-USDC" + bytes(40)])
def test_what_is_no_usd_is_rejected(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "scene.usda"
    path.write_bytes(content)
    with pytest.raises(DatasetError, match=r"scene\.usda"):
        read_usd(path)
    with pytest.raises(DatasetError, match="there is no such file"):
        read_usd(tmp_path / "nowhere.usda")
