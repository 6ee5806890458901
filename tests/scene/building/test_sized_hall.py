import numpy as np
import pytest

from tests.scene.building.halls import hall_scene
from warehouse_sim.errors import PlacementError
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.schema import SceneSpec

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
