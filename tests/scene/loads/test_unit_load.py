from dataclasses import replace

import numpy as np
import pytest

from tests.scene.packing.pallets import least_distance
from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.loads.drums import DRUMS
from warehouse_sim.catalog.materials import materials
from warehouse_sim.catalog.pallets import PALLETS
from warehouse_sim.errors import PlacementError
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import make_transform, rotation_z, transform_points
from warehouse_sim.physics import SettleConfig, settle_scene
from warehouse_sim.scene import Distribution
from warehouse_sim.scene.draft import SceneDraft
from warehouse_sim.scene.loads.unit_load import (
    UnitLoad,
    UnitLoadConfig,
    build_unit_load,
    jitter_scale,
    safe_working_load,
)
from warehouse_sim.scene.packing.patterns import PATTERNS
from warehouse_sim.scene.packing.stacking import StackingConfig
from warehouse_sim.schema import SceneSpec

PLAIN = UnitLoadConfig(empty_fraction=0.0)
RICH = UnitLoadConfig(
    empty_fraction=0.0,
    pallets=tuple(PALLETS),
    damaged_fraction=0.5,
    tote_fraction=0.15,
    drum_fraction=0.15,
    sack_fraction=0.15,
    mixed_fraction=0.3,
    drums=("drum_plastic_60_blue",),
    patterns=PATTERNS,
    height=Distribution.uniform(0.3, 1.4),
    max_cartons=60,
    wrap_fraction=0.5,
    slip_sheet_fraction=0.5,
    corner_post_fraction=0.5,
    stacking=StackingConfig(
        gap_mm=4.0,
        shift_mm=Distribution.normal(0.0, 0.7, -1.5, 1.5),
        half_turn_fraction=0.5,
    ),
)


def rich(seed: int) -> UnitLoad:
    return build_unit_load(1.7, RICH, np.random.default_rng(seed))


def placed(load: UnitLoad, scene_index: int = 0) -> SceneSpec:
    draft = SceneDraft()
    draft.add("floor_slab", make_transform(translation=np.array([0.0, 0.0, -0.1])))
    load.add_to(draft, make_transform(rotation_z(0.3)))
    return SceneSpec(scene_index, 0, draft.models, materials(), tuple(draft.instances), (), ())


@pytest.mark.parametrize("seed", range(60))
def test_loads_of_every_kind_on_every_pallet_are_sound(seed: int) -> None:
    load = rich(seed)
    assert load.pallet.class_name == "pallet"
    assert load.payload <= safe_working_load(load.pallet)
    assert load.height <= 1.7
    solid = []
    for model, T in load.pieces:
        if model.collision:
            upright = T if model.class_name != "drum" else make_transform(translation=T[:3, 3])
            solid.append(OrientedBox(upright, model.size))
    assert least_distance(solid) >= 0.0004
    deck = load.pallet.size[:2] / 2
    corners = np.concatenate([box.corners() for box in solid])
    assert np.all(np.abs(corners[:, :2]).max(axis=0) <= deck + 0.010 + 0.03 + 5 * 0.006)
    envelope = load.envelope
    half = envelope.size / 2
    bodies = np.concatenate([box.placed(T).corners() for model, T in load.pieces for box in model.collision])
    assert np.all(np.abs(bodies - envelope.T_parent_box[:3, 3])[:, :2] <= half[:2] + 1e-9)


@pytest.mark.parametrize("seed", range(0, 60, 4))
def test_loads_stand_when_let_go(seed: int) -> None:
    _, report = settle_scene(placed(rich(seed), seed), SettleConfig())
    assert report.problems == ()
    assert report.max_tilt < np.deg2rad(1.0)
    assert report.max_drift < 0.01


@pytest.mark.parametrize("fraction", ["damaged_fraction", "slip_sheet_fraction", "tote_fraction", "mixed_fraction"])
def test_what_never_happens_uses_up_nothing_of_the_stream(fraction: str) -> None:
    """A fraction that is as good as zero asks the stream, which moves all that is sampled later."""

    def poses(config: UnitLoadConfig) -> list:
        return [T.tolist() for _, T in build_unit_load(1.3, config, np.random.default_rng(3)).pieces]

    others = replace(PLAIN, totes=PLAIN.totes[:1], drums=PLAIN.drums[:1], sacks=PLAIN.sacks[:1])
    assert poses(others) == poses(PLAIN)
    assert poses(replace(PLAIN, **{fraction: 1e-12})) != poses(PLAIN)


def test_an_empty_pallet_is_a_load_of_one_piece() -> None:
    load = build_unit_load(0.2, replace(PLAIN, empty_fraction=1.0), np.random.default_rng(0))
    assert len(load.pieces) == 1
    assert load.payload == 0.0
    assert load.mass == 25.0
    assert load.height == pytest.approx(0.1445)


def test_film_and_posts_go_with_the_group_but_physics_leaves_them_alone() -> None:
    config = replace(
        PLAIN,
        cartons=("carton_600x400x300",),
        wrap_fraction=1.0,
        corner_post_fraction=1.0,
        slip_sheet_fraction=1.0,
        height=Distribution.constant(0.95),
        stacking=StackingConfig(top_layer_fraction=Distribution.constant(1.0)),
    )
    load = build_unit_load(1.5, config, np.random.default_rng(0))
    classes = [model.class_name for model, _ in load.pieces]
    assert classes == ["pallet", "slip_sheet", *["carton"] * 12, *["corner_post"] * 4, "wrap"]
    scene = placed(load)
    loose = {scene.model_of(item).class_name: item.dynamic for item in scene.instances if item.group}
    assert loose == {"pallet": True, "slip_sheet": True, "carton": True, "corner_post": False, "wrap": False}
    assert {item.group for item in scene.instances[1:]} == {1}
    film, T_load_film = load.pieces[-1]
    vertices = transform_points(T_load_film, film.mesh().vertices)
    goods = np.concatenate([OrientedBox(T, m.size).corners() for m, T in load.pieces[2:-1]])
    assert np.all(vertices.max(axis=0)[:2] >= goods.max(axis=0)[:2])
    assert vertices[:, 2].min() == pytest.approx(0.144 - 0.07, abs=0.001)


def test_damaged_pallets_keep_their_meaning() -> None:
    load = build_unit_load(1.5, replace(PLAIN, damaged_fraction=1.0), np.random.default_rng(0))
    fresh = catalog_object(load.pallet.name.split("~")[0])
    assert load.pallet.name != fresh.name
    assert load.pallet.obj_id == fresh.obj_id
    assert load.pallet.pockets is fresh.pockets
    assert len(load.pieces) > 1


@pytest.mark.parametrize("name", PALLETS)
def test_any_pallet_of_the_catalog_can_be_requested_for(name: str) -> None:
    load = build_unit_load(1.5, replace(PLAIN, pallets=(name,), slip_sheet_fraction=1.0), np.random.default_rng(1))
    assert load.pallet is catalog_object(name)
    assert len(load.pieces) > 2


def test_a_slot_may_limit_the_footprint() -> None:
    names = {
        build_unit_load(1.5, RICH, np.random.default_rng(seed), footprint=(1.2, 0.8)).pallet.name.split("~")[0]
        for seed in range(40)
    }
    assert {"epal1", "epal6"} <= names
    assert all(np.all(catalog_object(name).size[:2] <= [1.2001, 0.8001]) for name in names)
    with pytest.raises(PlacementError, match="list a smaller one"):
        build_unit_load(1.5, PLAIN, np.random.default_rng(0), footprint=(1.0, 0.6))


def test_sacks_are_stacked_up_to_the_mass_that_is_allowed_and_ten_high() -> None:
    tall = replace(PLAIN, sack_fraction=1.0, height=Distribution.constant(2.4), max_cartons=300, pallets=("epal6",))
    for seed in range(10):
        light, free = (build_unit_load(3.0, tall, np.random.default_rng(seed), most_mass=x) for x in (400.0, np.inf))
        assert 320.0 < light.mass <= 400.0
        assert free.payload <= safe_working_load(free.pallet)
        assert len({round(float(T[2, 3]), 3) for model, T in free.pieces if model.class_name == "sack"}) == 10
    assert safe_working_load(catalog_object("epal1")) == 1500.0
    assert safe_working_load(catalog_object("epal2")) == 1250.0


def test_the_envelope_of_a_drum_does_not_grow_when_the_drum_is_turned() -> None:
    drum = catalog_object(sorted(DRUMS)[0])
    for angle in (0.0, 0.4, np.pi / 4):
        load = UnitLoad(((drum, make_transform(rotation_z(angle), np.array([0.0, 0.0, drum.size[2] / 2]))),))
        assert np.all(load.envelope.size[:2] <= drum.size[:2] * 1.08)


@pytest.mark.parametrize("seed", range(3))
def test_the_envelope_of_pallet_and_cartons_is_the_box_around_their_sizes(seed: int) -> None:
    load = build_unit_load(1.3, UnitLoadConfig(empty_fraction=0.0), np.random.default_rng(seed))
    corners = np.concatenate([OrientedBox(T, model.size).corners() for model, T in load.pieces])
    np.testing.assert_allclose(load.envelope.size[:2], np.ptp(corners[:, :2], axis=0), atol=1e-9)
    assert load.envelope.T_parent_box[2, 3] - load.envelope.size[2] / 2 == pytest.approx(0.02)
    assert load.envelope.corners()[:, 2].max() == pytest.approx(corners[:, 2].max())
    assert load.height == pytest.approx(corners[:, 2].max())


def test_jitter_shrinks_when_half_the_tries_were_in_vain() -> None:
    assert [jitter_scale(number, 50) for number in (0, 24, 25)] == [1.0, 1.0, 1.0]
    assert jitter_scale(40, 50) == pytest.approx(0.4)
    assert jitter_scale(50, 50) == 0.0
