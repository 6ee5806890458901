import logging
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import warehouse_sim as ws
from tests.api.crates import write_crate
from warehouse_sim.errors import ConfigError, InputError, PlacementError, SettleError, UnknownNameError
from warehouse_sim.physics.check import contact_state

SMALL = ws.Camera(width=320, height=200, focal_px=200, depth="ideal")


def place_of(scene: ws.Scene, name: str) -> list[float]:
    return next(item for item in scene.spec.instances if item.model == name).T_world_object[:3, 3].tolist()


def test_places_are_metres_of_the_origin_and_yaw_turns_about_z() -> None:
    scene = ws.Scene()
    scene.add("epal1", x=1.0, y=-2.0, z=0.6, yaw_deg=90)
    item = scene.spec.instances[-1]
    np.testing.assert_allclose(
        item.T_world_object, [[0, -1, 0, 1], [1, 0, 0, -2], [0, 0, 1, 0.6], [0, 0, 0, 1]], atol=1e-12
    )


def test_objects_stand_on_each_other_and_come_to_rest() -> None:
    scene = ws.Scene()
    scene.add("epal1", x=1.0)
    scene.add("carton_600x400x300", x=1.2)
    scene.add("carton_400x300x200", x=1.2, z=1.0)
    assert scene.settle() is scene
    assert place_of(scene, "epal1")[2] == pytest.approx(0.072, abs=1e-3)
    assert place_of(scene, "carton_600x400x300")[2] == pytest.approx(0.144 + 0.15, abs=1e-3)
    assert place_of(scene, "carton_400x300x200")[2] == pytest.approx(0.144 + 0.3 + 0.1, abs=2e-3)
    assert contact_state(scene.spec).problems(1.0, 1.0) == []


def test_what_overlaps_is_moved_beside_it_and_said(caplog: pytest.LogCaptureFixture) -> None:
    scene = ws.Scene()
    scene.add("shelf_bay", x=2.0)
    scene.add("epal1", x=1.0, yaw_deg=10)
    with caplog.at_level(logging.WARNING):
        scene.settle()
    assert "epal1" in caplog.text
    assert "moved by" in caplog.text
    assert np.hypot(place_of(scene, "epal1")[0] - 1.0, place_of(scene, "epal1")[1]) < 0.3
    assert place_of(scene, "shelf_bay")[0] == 2.0


def test_another_seed_settles_the_same_plan_a_little_elsewhere() -> None:
    places = []
    for seed in (0, 1, 1, 2):
        scene = ws.Scene()
        scene.add("epal1", x=1.0)
        places.append(place_of(scene.settle(seed), "epal1"))
    assert places[0][:2] == pytest.approx([1.0, 0.0], abs=1e-4)
    assert places[1] == places[2] != places[3]
    assert 0 < np.hypot(places[1][0] - 1.0, places[1][1]) < 0.02


@pytest.mark.gl
def test_a_shot_from_a_place_is_an_observation(tmp_path: Path) -> None:
    scene = ws.Scene()
    scene.add("epal1", x=1.0, yaw_deg=10)
    scene.add("carton_600x400x300", x=1.0)
    scene.light("nominal", lux=300)
    shot = scene.settle().render(SMALL, at=(-2, 0, 1.2), look_at=(1, 0, 0.1))
    assert shot.rgb.shape == (200, 320, 3)
    assert shot.rgb.dtype == np.uint8
    assert 20 < shot.rgb.mean() < 230
    assert shot.depth.shape == (200, 320)
    assert shot.depth.dtype == np.float32
    pallet, carton = shot.objects
    assert (pallet.name, carton.name) == ("epal1", "carton_600x400x300")
    assert carton.visible_fraction == 1.0
    assert 0.3 < pallet.visible_fraction < 0.95
    assert set(np.unique(shot.instance_mask)) == {0, pallet.instance_id, carton.instance_id}
    assert carton.mask.sum() == (shot.instance_mask == carton.instance_id).sum() > 500
    assert carton.box_3d.shape == (8, 3)
    # The point looked at is on the axis, and the depth of the carton's mask lies within its box.
    np.testing.assert_allclose(
        np.linalg.inv(shot.T_world_camera)[:3] @ [1, 0, 0.1, 1], [0, 0, np.hypot(3, 1.1)], atol=1e-9
    )
    inside = shot.depth[carton.mask]
    assert carton.box_3d[:, 2].min() - 0.01 < inside.min()
    assert inside.max() < carton.box_3d[:, 2].max() + 0.01
    assert shot.take.observation.conditions.floor_lux == pytest.approx(300.0)
    assert shot.lidar is None
    assert shot.points.shape[1] == 3
    shot.draw(tmp_path / "look.png")
    assert (tmp_path / "look.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.gl
def test_poses_views_and_rigs() -> None:
    scene = ws.Scene(seed=3)
    scene.add("epal1")
    scene.settle()
    placed = scene.render(SMALL, at=(-2, 0, 1), look_at=(0, 0, 0))
    posed = scene.render(SMALL, T_world_camera=placed.T_world_camera)
    np.testing.assert_array_equal(posed.rgb, placed.rgb)
    shots = scene.render(ws.Rig(camera=SMALL, lidar="vlp16"), views=2)
    assert [len(shot.objects) for shot in shots] == [1, 1]
    assert all(shot.lidar is not None and len(shot.lidar) > 1000 for shot in shots)
    again = scene.render(ws.Rig(camera=SMALL, lidar="vlp16"), views=2)
    assert all(np.array_equal(one.rgb, two.rgb) for one, two in zip(shots, again, strict=True))


@pytest.mark.gl
def test_a_scene_of_a_recipe_is_changed(tmp_path: Path) -> None:
    crate = write_crate(tmp_path)
    scene = ws.Scene("smoke")
    before = sum(item.model == "carton_600x400x400" for item in scene.spec.instances)
    assert scene.replace("carton_600x400x400", crate) == before > 0
    assert sum(item.model == "crate" for item in scene.spec.instances) == before
    scene.light("dim", lux=30)
    scene.settle()
    assert contact_state(scene.spec).problems(1.0, 1.0) == []
    shots = scene.render(SMALL, views=4)
    assert {o.name for shot in shots for o in shot.objects} >= {"crate"}
    assert shots[0].take.observation.conditions.floor_lux == pytest.approx(30.0)


def test_an_unchanged_scene_of_a_recipe_stands_as_the_dataset_has_it() -> None:
    from warehouse_sim.generation.recipe import load_recipe
    from warehouse_sim.generation.scene import sample_settled_scene

    theirs, mine = sample_settled_scene(load_recipe("smoke"), 4, 0).scene, ws.Scene("smoke", seed=4).settle().spec
    assert [item.model for item in mine.instances] == [item.model for item in theirs.instances]
    for one, two in zip(mine.instances, theirs.instances, strict=True):
        np.testing.assert_array_equal(one.T_world_object, two.T_world_object)


def test_what_is_absent_is_said(caplog: pytest.LogCaptureFixture) -> None:
    scene = ws.Scene()
    with caplog.at_level(logging.WARNING):
        assert scene.replace("epal1", "epal6") == 0
        assert scene.remove("ibc_1000") == 0
    assert "no epal1" in caplog.text
    assert "no ibc_1000" in caplog.text
    scene.add("epal1")
    assert scene.remove("epal1") == 1
    assert scene.spec.target_instances() == []


@cache
def settled() -> ws.Scene:
    scene = ws.Scene()
    scene.add("epal1")
    return scene.settle()


@pytest.mark.parametrize(
    ("call", "error", "words"),
    [
        (lambda s: s.add(5), InputError, ["Scene.add", "name", "5"]),
        (lambda s: s.add("epal1", x="a"), InputError, ["x", "'a'"]),
        (lambda s: s.add("epal1", yaw_deg=float("nan")), InputError, ["yaw_deg", "nan"]),
        (lambda s: s.add("epal1", yaw_deg=400), InputError, ["yaw_deg", "-360 to 360 deg"]),
        (lambda s: s.add("epal"), UnknownNameError, ["'epal'", "epal1"]),
        (lambda s: s.add("epal1", z=float("inf")), InputError, ["z", "inf"]),
        (
            lambda s: s.add("epal1", x=500),
            PlacementError,
            ["epal1", "nothing is under x = 500 m", "from x = -12.2 to 12.2 m"],
        ),
        (lambda s: s.add("crate.fbx"), ConfigError, ["'crate.fbx'", "no .fbx file", ".glb"]),
        (lambda s: s.add("shelf_bay", fixed=False), PlacementError, ["shelf_bay", "no mass"]),
        (lambda s: s.replace("carton_300x200x200", "epal1"), PlacementError, ["epal1", "1.2 x 0.8", "0.3 x 0.2"]),
        (lambda s: s.replace("epall", "epal1"), UnknownNameError, ["'epall'"]),
        (lambda s: s.light("nominel"), InputError, ["preset", "'nominal'"]),
        (lambda s: s.light("nominal", lux=0), InputError, ["lux", "0.001-200,000 lx"]),
        (lambda s: s.light("nominal", temprature=4000), ConfigError, ["temprature", "temperature"]),
        (lambda s: s.light("nominal", rows=3), ConfigError, ["rows", "recipe"]),
        (lambda s: s.settle(seed=-1), InputError, ["seed"]),
        (lambda s: s.render("kitti", at=(0, 0, 1), look_at=(0, 0, 1)), InputError, ["same place"]),
        (lambda s: s.render("kitti", at=(0, 0, 1)), InputError, ["at and look_at"]),
        (lambda s: s.render("kitti"), InputError, ["at and look_at", "views"]),
        (lambda s: s.render("kitti", at=(0, 0), look_at=(1, 0, 0)), InputError, ["at must be", "(0, 0)"]),
        (lambda s: s.render(5, views=1), InputError, ["camera", "5"]),
        (lambda s: s.render("kity", views=1), UnknownNameError, ["'kity'", "kitti"]),
        (lambda s: s.render("kitti", at=(0, 0, np.inf), look_at=(0, 0, 0)), InputError, ["at must be finite"]),
        (lambda s: s.render("kitti", T_world_camera=np.zeros((4, 4))), InputError, ["rigid pose"]),
        (lambda s: s.render("kitti", T_world_camera=[[1, 2], [3]]), InputError, ["rigid pose", "4 x 4"]),
        (lambda s: s.render("kitti", T_world_camera=np.full((4, 4), object())), InputError, ["rigid pose"]),
        (lambda s: s.render("kitti", T_world_camera=np.full((4, 4), np.nan)), InputError, ["rigid pose"]),
        (lambda s: s.render("kitti", views=0), InputError, ["views", "1-1,000"]),
        (lambda s: s.render("kitti", at=(0, 0, 1), look_at=(1, 0, 0), views=2), InputError, ["or views"]),
        (lambda s: ws.Scene().render("kitti", at=(0, 0, 1), look_at=(1, 0, 0)), InputError, ["settle()"]),
        (lambda s: ws.Scene().settle().render("kitti", views=2), InputError, ["has labels", "add an object"]),
        (lambda s: ws.Scene("dmo"), UnknownNameError, ["'dmo'"]),
        (lambda s: ws.Scene(seed="0"), InputError, ["seed", "'0'"]),
    ],
)
def test_what_does_not_fit_is_said_in_one_line(
    call: Callable[[ws.Scene], Any], error: type[Exception], words: list[str]
) -> None:
    scene = settled()
    with pytest.raises(error) as caught:
        call(scene)
    assert all(word in str(caught.value) for word in words), str(caught.value)
    assert "\n" not in str(caught.value)


def test_what_has_no_free_place_does_not_settle() -> None:
    scene = ws.Scene()
    scene.add("wall")
    scene.add("epal1", z=3.0, fixed=True)
    scene.add("epal1", z=20.0)
    with pytest.raises(SettleError, match=r"rest|overlap|moving|place"):
        scene.settle()
