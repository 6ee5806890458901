from collections import Counter

import numpy as np
import pytest

from tests.scene.building.halls import ALL_SERVICES, hall_scene
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.scene.building.hall import HallConfig, equip_hall
from warehouse_sim.scene.building.services import ServicesConfig
from warehouse_sim.scene.draft import SceneDraft
from warehouse_sim.scene.layouts.rack_aisle import RackAisleConfig
from warehouse_sim.scene.layouts.site import build_site
from warehouse_sim.scene.solids import Solids
from warehouse_sim.schema import SceneSpec

EVERYTHING = {"length": 40.0, "width": 30.0, "height": 9.0, "columns": "steel", "services": ALL_SERVICES}
SHELL = ("floor", "wall", "ceiling")


def _counts(scene: SceneSpec) -> Counter[str]:
    return Counter(item.model.split("_")[0] + ":" + scene.model_of(item).class_name for item in scene.instances)


@pytest.fixture(scope="module")
def scene() -> SceneSpec:
    return hall_scene(**EVERYTHING)


def test_all_that_is_requested_for_is_there(scene: SceneSpec) -> None:
    names = {item.model for item in scene.instances}
    for start in ("sprinkler_line", "cable_tray", "duct", "light_line", "rooflight", "window_band", "exit_sign"):
        assert any(name.startswith(start) for name in names), start
    for name in ("extinguisher", "fire_sign", "fire_hose_cabinet", "mandatory_sign", "column_guard", "bollard"):
        assert name in names
    for name in ("guard_rail", "rubbish_bin", "floor_sign", "load_notice", "keep_clear_marking", "crossing_marking"):
        assert name in names
    assert {"corner_marking", "lane_line_white_6000", "floor_label_01"} <= names
    assert any(name.startswith("aisle_sign") for name in names)


def test_by_default_nothing_is_added_and_no_other_draw_moves() -> None:
    plain, rich = hall_scene(), hall_scene(services=ALL_SERVICES, tyre_tracks=5, stains=3, patches=1, puddles=1)
    added = _counts(rich) - _counts(plain)
    assert added
    assert not _counts(plain) - _counts(rich)
    assert not any(name.endswith(":service") for name in _counts(plain))
    pallets = [[item.T_world_object for item in scene.instances if item.dynamic] for scene in (plain, rich)]
    assert len(pallets[0]) == len(pallets[1])


@pytest.mark.parametrize("index", range(3))
def test_nothing_stands_in_a_door(index: int) -> None:
    layout = {"kind": "dock_staging", "doors": 4, "open_fraction": 1.0, "trailer_fraction": 0.0, "aisle_width": 9.0}
    scene = hall_scene(
        index, layout=layout, length=30.0, width=30.0, outdoors=True, services=ALL_SERVICES | {"bins": 8}
    )
    for door in (item for item in scene.instances if item.model == "dock_door_open"):
        for item in scene.instances:
            if scene.model_of(item).class_name in ("bin", "fire_equipment", "bollard", "guard"):
                off = np.abs(item.T_world_object[:2, 3] - door.T_world_object[:2, 3])
                assert off[0] > 1.4 or off[1] > 1.7, item.model


def test_what_is_solid_overlaps_nothing(scene: SceneSpec) -> None:
    fixed = [item for item in scene.instances if not item.dynamic]
    names = {item.instance_id: scene.model_of(item).class_name for item in fixed}
    solids = Solids.of(fixed, scene.models)
    mine = ("fire_equipment", "bin", "bollard", "guard", "sign")
    low, high = solids.extents
    for number in np.flatnonzero([names[int(owner)] in mine for owner in solids.owner]):
        near = np.flatnonzero((low <= high[number]).all(axis=1) & (high >= low[number]).all(axis=1))
        pairs = np.array([(number, other) for other in near if solids.owner[other] != solids.owner[number]])
        if len(pairs):
            boxes = BoxStack(solids.boxes.centre, solids.boxes.rotation, solids.boxes.half)
            assert boxes.separation(boxes, pairs).distance.min() > -1e-3, names[int(solids.owner[number])]


def test_what_hangs_stays_within_the_hall(scene: SceneSpec) -> None:
    for item in scene.instances:
        model = scene.model_of(item)
        if model.class_name in ("service", "window", "sign", "fire_equipment"):
            corners = model.mesh().vertices @ item.T_world_object[:3, :3].T + item.T_world_object[:3, 3]
            assert (corners >= [-20.0 - 1e-6, -40.0, -1e-6]).all(), item.model
            assert (corners <= [20.0 + 1e-6, 20.0, 9.0 + 1e-6]).all(), item.model


def test_nothing_under_the_roof_meets_racks_or_other_services(scene: SceneSpec) -> None:
    hung = [
        item for item in scene.instances if item.model.startswith(("cable_tray", "duct", "sprinkler", "light_line"))
    ]
    boxes = []
    for item in hung:
        half = np.abs(item.T_world_object[:3, :3]) @ scene.model_of(item).size / 2
        boxes.append((item.T_world_object[:3, 3] - half, item.T_world_object[:3, 3] + half))
    for number, (low, high) in enumerate(boxes):
        for other_low, other_high in boxes[:number]:
            assert not ((low < other_high) & (high > other_low)).all(), hung[number].model


@pytest.mark.parametrize(("preset", "sky"), [("nominal", 320.0), ("dim", 35.2), ("night", 0.32)])
def test_the_sky_has_the_hour_of_the_preset(preset: str, sky: float) -> None:
    scene = hall_scene(outdoors=True, lights={"preset": preset}, services={"windows": True})
    assert scene.materials["outdoor_sky_0"].emission == pytest.approx(sky)
    day = hall_scene(outdoors=True, lights={"preset": "nominal"})
    assert scene.materials["outdoor_asphalt"].emission <= day.materials["outdoor_asphalt"].emission


def test_rows_of_light_glow_with_the_luminaires_and_are_dark_with_them() -> None:
    services = {"light_lines": True}
    on, off = (
        hall_scene(length=40.0, width=40.0, services=services, lights={"preset": preset, "luminaires": 6})
        for preset in ("nominal", "night")
    )
    assert on.materials["led_row"].emission > 100.0
    assert off.materials["led_row"].emission == 0.0


@pytest.mark.parametrize("index", range(3))
def test_nothing_is_hung_or_stood_in_the_place_of_a_load(index: int) -> None:
    draft = SceneDraft()
    hall = HallConfig(roof=True, length=24.0, width=12.0, height=8.0, services=ServicesConfig(
        bins=8, fire_equipment=True, guards=True, signs=True
    ))  # fmt: skip
    site = build_site(draft, RackAisleConfig(bays=6), hall, np.random.default_rng(index))
    before = len(draft.instances)
    equip_hall(draft, hall, site.aisle, site.hall, np.random.default_rng(index), site.places_of_loads())
    rooms = BoxStack.of(site.places_of_loads())
    added = draft.instances[before:]
    assert any(item.model == "rubbish_bin" for item in added)
    for item in added:
        if draft.models[item.model].class_name not in ("marking", "sign"):
            assert rooms.clear_of(OrientedBox(item.T_world_object, draft.models[item.model].size), 0.0), item.model
