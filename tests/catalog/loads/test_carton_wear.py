"""A battered carton lies inside of the one that it was, closed, and its print stays on its board."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.loads.carton_wear import CartonWearConfig, battered
from warehouse_sim.catalog.loads.open_cartons import OPEN_CARTONS
from warehouse_sim.catalog.loads.strength import bears
from warehouse_sim.catalog.materials import materials
from warehouse_sim.catalog.shipped import SHIPPED
from warehouse_sim.render.raycaster import RayCaster
from warehouse_sim.schema import ObjectInstance, ObjectModel, SceneSpec

NAMES = ("carton_600x400x400", "carton_600x400x350", "carton_400x300x150")
HARD = CartonWearConfig(fraction=1.0, depth=0.04, bulge=0.008)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("seed", range(4))
def test_board_only_goes_inwards_and_the_mesh_stays_closed(name: str, seed: int) -> None:
    model = catalog_object(name)
    after = battered(model, HARD, np.random.default_rng(seed))
    assert after.name.startswith(f"{name}~")
    assert (after.obj_id, after.class_name, after.collision) == (model.obj_id, model.class_name, model.collision)
    body = after.parts[0].placed()
    assert (np.abs(body.vertices) <= model.size / 2 + 1e-9).all()
    solid = trimesh.Trimesh(body.vertices, body.faces, process=True)
    assert solid.is_watertight
    assert solid.is_winding_consistent
    nominal = float(np.prod(model.size))
    assert 0.8 * nominal < solid.volume < 0.999 * nominal
    assert np.linalg.norm(solid.vertices[:, None] - solid.bounds.mean(axis=0), axis=-1).max() < 0.6


def seen_from_the_sides(model: ObjectModel) -> tuple[np.ndarray, list[str | None]]:
    """Return the distance to a grid of points of the four sides, and the material there."""
    y, z = (grid.ravel() for grid in np.meshgrid(np.linspace(-0.45, 0.45, 40), np.linspace(-0.45, 0.45, 40)))
    origins, directions = [], []
    for axis, sign in ((0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0)):
        start = np.column_stack([y, y, z]) * model.size
        start[:, axis] = sign * 1.0
        origins.append(start)
        directions.append(np.tile(-sign * np.eye(3)[axis], (len(y), 1)))
    item = ObjectInstance(1, model.name, np.eye(4))
    caster = RayCaster(SceneSpec(0, 0, {model.name: model}, materials(), (item,), (), ()))
    hits = caster.cast(np.concatenate(origins), np.concatenate(directions))
    return hits.distance, [caster.materials[number] if number >= 0 else None for number in hits.materials]


@pytest.mark.parametrize("name", NAMES)
def test_print_and_labels_stay_on_the_board(name: str) -> None:
    model = catalog_object(name)
    after = battered(model, HARD, np.random.default_rng(1))
    distance, seen = seen_from_the_sides(after)
    board, _ = seen_from_the_sides(replace(after, parts=after.parts[:1]))
    assert (board - distance).max() < 0.004  # nothing hovers before a dent
    _, before = seen_from_the_sides(model)
    for material in {part.material for part in model.parts}:
        count = before.count(material)
        assert seen.count(material) == pytest.approx(count, abs=0.15 * count + 25), material


def test_wear_is_seen_and_comes_from_the_stream() -> None:
    model = catalog_object(NAMES[0])
    one, same, other = (battered(model, HARD, np.random.default_rng(seed)) for seed in (1, 1, 2))
    assert one.name == same.name != other.name
    assert np.array_equal(one.parts[0].mesh.vertices, same.parts[0].mesh.vertices)
    for item in (one, other):
        vertices = item.parts[0].placed().vertices
        distance = (model.size / 2 - np.abs(vertices)).min(axis=1)
        assert 0.004 < distance.max() < 0.07


@pytest.mark.parametrize("name", OPEN_CARTONS)
def test_flaps_stay_over_the_carton_and_the_size_is_exact(name: str) -> None:
    model, closed = catalog_object(name), catalog_object(OPEN_CARTONS[name][0])
    np.testing.assert_array_equal(model.size[:2], closed.size[:2])
    flap = model.size[2] - closed.size[2]
    assert 0.3 * closed.size[1] / 2 < flap < closed.size[1] / 2 + 0.01
    assert model.mass < closed.mass
    assert bears(model) == 0.0
    assert model.class_name == "carton"


def test_numbers_are_their_own() -> None:
    numbers = [catalog_object(name).obj_id for name in OPEN_CARTONS]
    others = {catalog_object(name).obj_id for name in SHIPPED if name not in OPEN_CARTONS}
    assert len(set(numbers)) == len(numbers)
    assert set(numbers) <= set(range(930, 978))
    assert not others.intersection(numbers)
