from collections import Counter
from typing import Any

import numpy as np
import pytest

from warehouse_sim.config import from_mapping
from warehouse_sim.errors import PlacementError
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.scene.building.hall import HallConfig, equip_hall
from warehouse_sim.scene.building.services import ServicesConfig
from warehouse_sim.scene.draft import SceneDraft
from warehouse_sim.scene.layouts.rack_aisle import RackAisleConfig
from warehouse_sim.scene.layouts.site import build_site
from warehouse_sim.scene.recipe import SceneRecipe
from warehouse_sim.scene.sampling import sample_scene
from warehouse_sim.scene.solids import Solids
from warehouse_sim.schema import SceneSpec

ALL_SERVICES = {
    **dict.fromkeys(
        ("sprinklers", "cable_trays", "ducts", "light_lines", "rooflights", "windows", "signs", "fire_equipment"), True
    ),
    **dict.fromkeys(("guards", "markings", "floor_labels"), True),
    "bins": 4,
    "floor_signs": 1,
}


def hall_scene(index: int = 0, layout: dict[str, Any] | None = None, lights: Any = None, **hall: Any) -> SceneSpec:
    """Return scene ``index`` of a hall with these settings, without loads."""
    plain = {
        "layout": layout or {"bays": 2, "beam_levels": [1.5], "aisle_width": 9.5},
        "hall": {"roof": True, **hall},
        "shelving": {"empty_slot_fraction": 1.0},
        "lanes": {"fill": 0.0},
        "staging": {"count": 2},
        "lights": lights or {},
        "viewpoints": {"distance": {"min": 2.0, "max": 6.0}},
        "observations_per_scene": 2,
    }
    return sample_scene(from_mapping(SceneRecipe, plain, "test"), 7, index)


EVERYTHING = {"length": 40.0, "width": 30.0, "height": 9.0, "columns": "steel", "services": ALL_SERVICES}


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


SIZES = ((12.0, 14.0, 5.0), (48.0, 30.0, 9.0), (120.0, 90.0, 14.0))
DOCK = {"kind": "dock_staging", "doors": 2, "open_fraction": 1.0, "trailer_fraction": 0.5, "aisle_width": 9.0}


def _rays(scene: SceneSpec, count: int = 3000) -> tuple[np.ndarray, np.ndarray]:
    """Return where rays in all directions from the middle of the aisle, at eye height, meet what (m, class names)."""
    x_min, x_max, y_min, y_max = scene.aisle
    rays = np.random.default_rng(3).normal(size=(count, 3))
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    start = np.array([(x_min + x_max) / 2, (y_min + y_max) / 2, 1.6])
    hits = RayCaster(scene).cast(np.tile(start, (count, 1)), rays)
    classes = {item.instance_id: scene.model_of(item).class_name for item in scene.instances}
    names = np.array([classes.get(int(number), "nothing") for number in hits.instance_ids])
    return start + hits.distance[:, None] * rays, names


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("kind", ["truss", "beam", "board"])
def test_a_hall_has_the_size_that_is_requested_for_and_no_hole(size: tuple[float, float, float], kind: str) -> None:
    length, width, height = size
    scene = hall_scene(length=length, width=width, height=height, roof_kind=kind, lights={"mounting_height": 3.0})
    points, names = _rays(scene)
    assert "nothing" not in names
    walls = points[names == "wall"]
    roof = points[names == "ceiling"]
    assert np.ptp(walls[:, 0]) == pytest.approx(length, abs=1e-3)
    assert np.ptp(walls[:, 1]) == pytest.approx(width, abs=1e-3)
    assert roof[:, 2].max() == pytest.approx(height + (0.0 if kind == "board" else 0.2), abs=0.06)


@pytest.mark.parametrize("walls", ["panels", "cladding"])
def test_a_hall_of_no_given_size_is_closed(walls: str) -> None:
    """Walls of 9.00 m under a sheet at 9.24 m leave no strip of sky."""
    _, names = _rays(hall_scene(walls=walls), 60_000)
    assert "nothing" not in names


@pytest.mark.parametrize("settings", [{}, {"length": 40.0, "width": 40.0, "height": 8.0}])
def test_an_open_dock_without_trailer_shows_the_yard_and_no_hole(settings: dict[str, float]) -> None:
    scene = hall_scene(layout=DOCK, outdoors=True, **settings)
    _, names = _rays(scene, 20_000)
    assert "nothing" not in names
    assert "outdoors" in names
    assert "trailer" in names


def test_without_outdoors_the_same_door_is_a_hole() -> None:
    _, names = _rays(hall_scene(layout=DOCK), 20_000)
    assert "nothing" in names


@pytest.mark.parametrize(
    ("settings", "key"),
    [({"length": 10.0, "width": 40.0}, "hall.length"), ({"length": 48.0, "width": 10.0}, "hall.width")],
)
def test_a_hall_too_small_names_the_setting_and_the_remedy(settings: dict[str, float], key: str) -> None:
    layout = {"bays": 6, "beam_levels": [1.5], "aisle_width": 9.5}
    with pytest.raises(PlacementError, match=f"{key}.*raise {key}"):
        hall_scene(layout=layout, **settings)


def test_luminaires_above_the_roof_are_rejected_and_null_hangs_them_below_the_girders() -> None:
    with pytest.raises(PlacementError, match=r"lights\.mounting_height.*give null"):
        hall_scene(length=30.0, width=20.0, height=5.0, lights={"mounting_height": 7.0})
    scene = hall_scene(length=30.0, width=22.0, height=6.0, lights={"mounting_height": None, "luminaire": "round"})
    lamps = [item for item in scene.instances if item.model.startswith("luminaire_round")]
    assert lamps
    assert all(item.T_world_object[2, 3] == pytest.approx(6.0 - 1.0 - 0.12) for item in lamps)
