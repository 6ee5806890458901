from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

from warehouse_sim.errors import ConfigError, InputError
from warehouse_sim.generation.recipe import load_recipe
from warehouse_sim.generation.scene import prepare_scene
from warehouse_sim.geometry.pose import make_transform
from warehouse_sim.interchange import Carriage, write_mjcf

MILLIMETRE = 1e-3


@pytest.fixture(scope="module")
def scene():
    return prepare_scene(load_recipe("smoke"), 0, 0).scene


@pytest.fixture(scope="module")
def pallet(scene):
    """Return the pallet that stands free in the aisle."""
    aisle = [item for item in scene.instances if scene.model_of(item).pockets and item.T_world_object[1, 3] < -2.0]
    return aisle[0]


def load(scene, place: Carriage, path: Path):
    model = mujoco.MjModel.from_xml_path(str(write_mjcf(scene, path, carriage=place)))
    return model, mujoco.MjData(model)


def drive(model, data, name: str, goal: float, time: float) -> None:
    start = float(data.actuator(name).ctrl[0])
    steps = max(int(time / 0.02), 1)
    for step in range(steps):
        data.actuator(name).ctrl = start + (goal - start) * (step + 1) / steps
        mujoco.mj_step(model, data, nstep=10)


@pytest.mark.parametrize("face", [pytest.param("-x", marks=pytest.mark.slow), "+y"])
def test_it_drives_in_without_a_push_and_lifts_the_load(scene, pallet, tmp_path: Path, face: str) -> None:
    name = str(pallet.instance_id)
    model, data = load(scene, Carriage(pallet.instance_id, face, 0.3), tmp_path / "dock.xml")
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(data.sensor("tips_in_dock").data, [-0.3, 0.0, 0.0], atol=2 * MILLIMETRE)
    start = data.body(name).xpos.copy()
    mujoco.mj_step(model, data, nstep=500)
    assert np.abs(data.qpos[-4:]).max() < 0.1 * MILLIMETRE  # it holds itself
    inside = 0.3 + (1.0 if face == "-x" else 0.75)
    drive(model, data, "drive", inside, 4.0)
    assert np.linalg.norm(data.body(name).xpos - start) < 2 * MILLIMETRE
    drive(model, data, "lift", 0.3, 3.0)
    drive(model, data, "lift", 0.3, 0.5)
    assert data.body(name).xpos[2] - start[2] > 0.2
    assert data.body(name).xmat[8] > np.cos(np.deg2rad(3.0))
    load_kg = sum(scene.model_of(item).mass for item in scene.instances if item.group == pallet.group and item.dynamic)
    assert data.sensor("lift_force").data[0] == pytest.approx(9.81 * load_kg, rel=0.03)


def test_joints_and_servos_have_their_names_and_ways(scene, pallet, tmp_path: Path) -> None:
    model, data = load(scene, Carriage(pallet.instance_id), tmp_path / "dock.xml")
    kinds = {name: model.joint(name).type[0] for name in ("drive", "tilt", "lift", "side_shift")}
    slide, hinge = mujoco.mjtJoint.mjJNT_SLIDE, mujoco.mjtJoint.mjJNT_HINGE
    assert kinds == {"drive": slide, "tilt": hinge, "lift": slide, "side_shift": slide}
    drive(model, data, "side_shift", 0.05, 0.5)
    drive(model, data, "side_shift", 0.05, 0.5)
    assert data.sensor("tips_in_dock").data[1] == pytest.approx(0.05, abs=MILLIMETRE)  # to the left
    drive(model, data, "tilt", 0.05, 0.5)
    drive(model, data, "tilt", 0.05, 0.5)
    assert data.sensor("tips_in_dock").data[2] > 0.04  # tips up, mast back


def test_what_cannot_be_is_rejected_before_anything_is_written(scene, pallet, tmp_path: Path) -> None:
    carton = next(item for item in scene.instances if scene.model_of(item).class_name == "carton")
    with pytest.raises(InputError, match=rf"object {carton.instance_id} has no pockets .* known: \d+"):
        write_mjcf(scene, tmp_path / "a.xml", carriage=Carriage(carton.instance_id))
    with pytest.raises(InputError, match=r"face 'front' .* known: "):
        write_mjcf(scene, tmp_path / "a.xml", carriage=Carriage(pallet.instance_id, "front"))
    before = pallet.T_world_object @ make_transform(None, np.array([-1.6, 0.0, 0.0]))
    crowded = replace(scene, instances=(*scene.instances, replace(pallet, instance_id=9000, T_world_object=before)))
    with pytest.raises(InputError, match=r"no way into object \d+ from 0.3 m: -x has no room before it; "):
        write_mjcf(crowded, tmp_path / "a.xml", carriage=Carriage(pallet.instance_id, "-x", 0.3))
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("distance", [0.0, float("nan"), 21.0])
def test_a_distance_out_of_range_is_rejected(distance: float) -> None:
    with pytest.raises(ConfigError, match=r"distance must be 0\.01-20 m"):
        Carriage(1, None, distance)
