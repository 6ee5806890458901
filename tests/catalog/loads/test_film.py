"""Stretch film as a machine winds it."""

import numpy as np
import pytest

from tests.catalog.covering import volume
from tests.catalog.pallets.touching import is_closed
from warehouse_sim.catalog.loads.securing import CORNER_POSTS, SLIP_SHEETS, corner_post, slip_sheet, stretch_wrap, wrap
from warehouse_sim.catalog.loads.securing.film_skin import COLUMNS, Level, Sheet, _simplified, film_skin, laid_on
from warehouse_sim.catalog.loads.securing.film_winding import DENSE, DOUBLE, THIN, wound_film
from warehouse_sim.catalog.materials import materials
from warehouse_sim.geometry.convex import convex_hull
from warehouse_sim.geometry.mesh import TriangleMesh
from warehouse_sim.schema import ObjectModel

SQUARE = np.array([[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]])
CORNER = SQUARE * 0.5 + [-0.3, -0.2]  # the quarter of the upper layer that is taken
LEVELS = [Level(SQUARE, 0.1, 0.6), Level(SQUARE, 0.6, 1.0), Level(CORNER, 1.0, 1.4)]


def part(model: ObjectModel, material: str) -> TriangleMesh:
    return next(item.mesh for item in model.parts if item.material == material)


def area_within(mesh: TriangleMesh, low: float, high: float) -> float:
    """Return the area of upright faces whose centre lies between two heights (m)."""
    level = mesh.vertices[mesh.faces].mean(axis=1)[:, 2]
    upright = np.abs(mesh.face_normals()[:, 2]) < 0.2
    return float(mesh.face_areas()[(level > low) & (level < high) & upright].sum())


@pytest.mark.parametrize("slack", [0.0, 1.0])
def test_film_keeps_outside_of_the_goods_of_every_layer_and_close_to_them(slack: float) -> None:
    skin = film_skin(LEVELS, 0.004, slack, np.random.default_rng(0))
    column, height = (grid.ravel() for grid in np.meshgrid(np.linspace(0, COLUMNS, 241), np.linspace(0.1, 1.4, 53)))
    x, y, z = skin.points(column, height).T
    over = np.maximum(np.maximum(-0.6 - x, x - 0.6), np.maximum(-0.4 - y, y - 0.4))
    assert np.all(over[z <= 1.0] > 0.0)
    assert np.all(over[z <= 1.0] < 0.008 + 0.014 * slack)
    upper = z > 1.0
    beside = np.maximum(np.maximum(-0.6 - x, x), np.maximum(-0.4 - y, y))[upper]
    assert np.all(beside > 0.0)
    # Drawn in from the broad layer: straight, and tight around the small one from halfway up.
    assert np.all(beside[z[upper] > 1.2] < 0.008 + 0.014 * slack)
    assert beside[z[upper] < 1.05].max() > 0.2


def test_film_on_the_way_to_a_smaller_layer_is_straight() -> None:
    skin = film_skin([Level(SQUARE, 0.0, 0.5), Level(SQUARE * 0.8, 0.5, 1.0)], 0.004, 0.0, np.random.default_rng(0))
    rings = skin.points(np.full(5, COLUMNS / 8), np.linspace(0.5, skin.heights[2], 5))
    steps = np.diff(rings[:, 1])
    assert np.all(steps > 0.0)
    np.testing.assert_allclose(steps, steps.mean(), atol=0.004)


def test_foot_and_top_have_more_layers_and_turns_overlap_between() -> None:
    model, centre = wound_film(LEVELS[:2], 0.0)
    dense, double, thin = (part(model, name) for name in (DENSE, DOUBLE, THIN))
    around = 4.0  # m of a turn
    z = float(centre[2])
    assert area_within(dense, 0.1 - z, 0.3 - z) > 0.19 * around
    assert area_within(dense, 0.45 - z, 0.7 - z) < 0.1 * 0.25 * around
    # Of 300 mm that the film rises in a turn, 200 mm lie over the turn before.
    middle = [area_within(mesh, 0.37 - z, 0.77 - z) for mesh in (double, thin)]
    assert sum(middle) == pytest.approx(0.4 * around, rel=0.15)
    assert middle[0] / middle[1] == pytest.approx(2.0, rel=0.3)
    opacities = [materials()[name].opacity for name in (THIN, DOUBLE, DENSE)]
    assert opacities == sorted(opacities)
    assert 0.0 < opacities[0] < opacities[2] < 1.0


def test_film_faces_outwards_and_has_no_body() -> None:
    model, centre = wound_film(LEVELS, 0.3)
    for item in model.parts:
        assert item.mesh.face_areas().min() > 0.0
    mesh = part(model, DOUBLE)
    middle, normal = mesh.vertices[mesh.faces].mean(axis=1) + centre, mesh.face_normals()
    low = middle[:, 2] < 1.0
    assert np.all((middle[low, :2] * normal[low, :2]).sum(axis=1) > 0.0)
    assert model.collision == ()
    assert (model.class_name, model.obj_id) == ("wrap", 60)
    points = model.mesh().vertices
    np.testing.assert_allclose(points.max(axis=0), model.size / 2)
    np.testing.assert_allclose(points.min(axis=0), -model.size / 2)


def test_equal_loads_have_equal_film() -> None:
    one, two, loose = wound_film(LEVELS, 0.2)[0], wound_film(LEVELS, 0.2)[0], wound_film(LEVELS, 0.9)[0]
    assert one.name == two.name
    np.testing.assert_array_equal(one.mesh().vertices, two.mesh().vertices)
    assert loose.name != one.name


def simplified_whole(points: np.ndarray) -> np.ndarray:
    """Leave out the flattest corner again and again, with the heights of all that are left computed again."""
    while len(points) > 4:
        before, after = np.roll(points, 1, axis=0), np.roll(points, -1, axis=0)
        chord, up = after - before, points - before
        height = np.abs(chord[:, 0] * up[:, 1] - chord[:, 1] * up[:, 0]) / np.linalg.norm(chord, axis=1)
        if height.min() > 0.002:
            break
        points = np.delete(points, int(height.argmin()), axis=0)
    return points


def test_flat_corners_are_left_out_one_by_one() -> None:
    rng = np.random.default_rng(0)
    found = set()
    for count in (4, 5, 8, 30, 200):
        for _ in range(20):
            outline = convex_hull(rng.normal(size=(count, 2)) * (0.6, 0.01 * rng.uniform(0.1, 40.0)))
            kept = _simplified(outline)
            np.testing.assert_array_equal(kept, simplified_whole(outline))
            found.add((len(outline) > len(kept), len(kept) > 4))
    assert len(found) == 4


def sheet(rng: np.random.Generator, count: int, proud: float = 0.0) -> Sheet:
    column, height = np.sort(rng.uniform(0, COLUMNS, (2, count)), axis=1), rng.uniform(0.0, 1.0, (2, count))
    return Sheet(column, height, proud, rng.random(count) < 0.6 if count % 2 else None)


def test_sheets_laid_at_once_are_those_laid_point_by_point() -> None:
    rng = np.random.default_rng(3)
    skin = film_skin([Level(SQUARE, 0.0, 0.5), Level(SQUARE * 0.8, 0.5, 1.0)], 0.004, 0.7, rng)
    sheets = {"thin": [sheet(rng, 7), sheet(rng, 4, 0.001)], "none": [], "dense": [sheet(rng, 9, 0.004)]}
    meshes = laid_on(skin, sheets)
    assert list(meshes) == ["thin", "none", "dense"]
    assert len(meshes["none"].faces) == len(meshes["none"].vertices) == 0
    for name, group in sheets.items():
        triangles = []
        for item in group:
            low, high = (
                [skin.points(np.array([c]), np.array([h]), item.proud)[0] for c, h in zip(*line, strict=True)]
                for line in zip(item.column, item.height, strict=True)
            )
            spans = [
                i for i in range(len(low) - 1) if item.wide is None or item.wide[i] or item.wide[i + 1]
            ]  # what lies between two narrow places is left out
            triangles += [(low[i], low[i + 1], high[i + 1]) for i in spans]
            triangles += [(low[i], high[i + 1], high[i]) for i in spans]
        found = meshes[name].vertices[meshes[name].faces]
        np.testing.assert_array_equal(found, np.array(triangles).reshape(-1, 3, 3))


# Sheets, posts and film.


def test_sheets_have_the_sizes_of_pallets_and_the_thickness_of_board() -> None:
    assert {tuple(slip_sheet(name).size[:2]) for name in SLIP_SHEETS} == {
        (1.2, 0.8),
        (1.2, 1.0),
        (1.219, 1.016),
        (0.8, 0.6),
    }
    assert all(0.0006 <= slip_sheet(name).size[2] <= 0.0015 for name in SLIP_SHEETS)
    assert slip_sheet("slip_sheet_1200x800").mass == pytest.approx(750 * 1.2 * 0.8 * 0.0015)


def test_a_post_is_an_angle_whose_corner_is_at_minus_x_minus_y() -> None:
    for name in CORNER_POSTS:
        model = corner_post(name)
        mesh = model.mesh()
        assert volume(mesh) == pytest.approx(0.004 * 0.096 * model.size[2]), name
        assert not np.any((mesh.vertices[:, 0] > -0.02) & (mesh.vertices[:, 1] > -0.02)), name
        assert model.collision == (), name
        assert name == f"corner_post_{round(1000 * model.size[2])}"


def test_film_goes_closely_around_every_level_and_over_the_top() -> None:
    model, centre = stretch_wrap([Level(SQUARE, 0.1, 1.0), Level(SQUARE * 0.5, 1.0, 1.3)])
    vertices = model.mesh().vertices + centre
    np.testing.assert_allclose(np.abs(vertices[:, :2]).max(axis=0), [0.6, 0.4], atol=0.002)
    assert np.all(np.abs(vertices[vertices[:, 2] > 1.001][:, :2]) <= [0.302, 0.202])
    np.testing.assert_allclose([vertices[:, 2].min(), vertices[:, 2].max()], [0.1, 1.3005])
    top = vertices[vertices[:, 2] > 1.2999]
    assert np.abs(top[:, 1]).min() == pytest.approx(0.2 - 0.07, abs=0.002)
    np.testing.assert_allclose(model.size, np.ptp(vertices, axis=0))


def test_film_is_closed_thin_and_translucent() -> None:
    model, _ = stretch_wrap([Level(SQUARE, 0.0, 1.1)])
    (part,) = model.parts
    assert is_closed(part.mesh)
    assert 0.0 < volume(part.mesh) < 0.003 * 4.0 * 1.1  # not filled
    assert 0.0 < materials()[part.material].opacity < 1.0
    assert model.collision == ()
    assert (model.class_name, model.obj_id) == ("wrap", 60)


def test_equal_film_has_an_equal_name_and_other_film_another() -> None:
    one, _ = stretch_wrap([Level(SQUARE, 0.0, 1.1)])
    two, _ = stretch_wrap([Level(SQUARE, 0.0, 1.1)])
    other, _ = stretch_wrap([Level(SQUARE, 0.0, 1.2)])
    assert one.name == two.name
    assert one.name != other.name


def test_the_shell_of_the_catalog_goes_around_a_block_of_its_name() -> None:
    np.testing.assert_allclose(wrap("wrap_1200x800x1000").size, [1.2, 0.8, 1.0], atol=0.003)
