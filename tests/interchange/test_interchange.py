from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from pxr import Usd, UsdGeom, UsdShade

from warehouse_sim.errors import OutputError
from warehouse_sim.geometry.pose import transform_points
from warehouse_sim.interchange import write_glb, write_usd
from warehouse_sim.render.conformance.scenes import at, box_model, make_scene
from warehouse_sim.resources import find_recipe
from warehouse_sim.scene import sample_scene


@pytest.fixture(scope="module")
def scene():
    from warehouse_sim.generation.recipe import load_recipe

    assert find_recipe("smoke")
    return sample_scene(load_recipe("smoke").scene, seed=0, scene_index=0)


def vertices_in_world(scene, instance) -> np.ndarray:
    return transform_points(instance.T_world_object, scene.model_of(instance).mesh().vertices)


def test_glb_holds_every_triangle_in_a_y_up_world(scene, tmp_path: Path) -> None:
    loaded = trimesh.load_scene(write_glb(scene, tmp_path / "scene.glb"))
    world = np.concatenate([vertices_in_world(scene, instance) for instance in scene.instances])
    low, high = world.min(0), world.max(0)
    np.testing.assert_allclose(loaded.bounds, [[low[0], low[2], -high[1]], [high[0], high[2], -low[1]]], atol=1e-4)
    triangles = sum(len(scene.model_of(instance).mesh().faces) for instance in scene.instances)
    assert sum(len(loaded.geometry[loaded.graph[node][1]].faces) for node in loaded.graph.nodes_geometry) == triangles


@pytest.mark.parametrize("write", [write_usd, write_glb])
def test_a_place_that_cannot_be_written_is_named(scene, tmp_path: Path, write) -> None:
    (tmp_path / "taken.usda").mkdir()
    for path in (tmp_path / "taken.usda", Path("/proc/scene.usda")):
        with pytest.raises(OutputError, match=rf"{path}: .*cannot be written .*choose another place"):
            write(scene, path)


def painted_boxes():
    scene = make_scene([box_model("carton", (0.6, 0.4, 0.3))], [("carton", at(x, 0, 0)) for x in (0, 1, 2)])
    first, second, third = scene.instances
    painted = (first, replace(second, paint={"kraft": "steel"}), replace(third, paint={"kraft": "wood"}))
    return replace(scene, instances=painted)


def test_usd_shows_the_paint_of_each_object(tmp_path: Path) -> None:
    stage = Usd.Stage.Open(str(write_usd(painted_boxes(), tmp_path / "scene.usda")))
    found = []
    for number in (1, 2, 3):
        prim = stage.GetPrimAtPath(f"/World/object_{number:06d}")
        (mesh,) = prim.GetPrototype().GetChild("Geometry").GetChildren()
        assert len(UsdGeom.Mesh(mesh).GetPointsAttr().Get()) == 8
        found.append(UsdShade.MaterialBindingAPI(mesh).GetDirectBinding().GetMaterialPath().name)
    assert found == ["kraft", "steel", "wood"]


def test_glb_shows_the_paint_of_each_object(tmp_path: Path) -> None:
    loaded = trimesh.load_scene(write_glb(painted_boxes(), tmp_path / "scene.glb"))
    nodes = sorted(loaded.graph.nodes_geometry)
    found = [loaded.geometry[loaded.graph[node][1]].visual.material.name for node in nodes]
    assert found == ["kraft", "steel", "wood"]
