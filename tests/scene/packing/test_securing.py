import numpy as np
import pytest

from warehouse_sim.catalog import catalog_object
from warehouse_sim.catalog.loads.cartons import carton
from warehouse_sim.geometry.boxes import OrientedBox
from warehouse_sim.geometry.pose import make_transform, rotation_z, transform_points
from warehouse_sim.geometry.separation import BoxStack
from warehouse_sim.scene.distribution import Distribution
from warehouse_sim.scene.packing.contents import Goods
from warehouse_sim.scene.packing.securing import FilmConfig, corner_posts, film_around

FLOOR = 0.144
DECK = (1.2, 0.8)
MODEL = carton("carton_600x400x300")


def block(layers: int, top: int = 4) -> Goods:
    """Return four cartons a layer, ``top`` in the last."""
    rng = np.random.default_rng(0)
    goods = []
    for level in range(layers):
        for i in range(top if level == layers - 1 else 4):
            x, y = 0.301 * (2 * (i % 2) - 1), 0.201 * (2 * (i // 2) - 1)
            place = np.array([x, y, FLOOR + 0.15 + 0.3005 * level])
            goods.append((MODEL, make_transform(rotation_z(rng.normal(0.0, 0.002)), place)))
    return goods


def points(goods: Goods) -> np.ndarray:
    return np.concatenate([OrientedBox(T, model.size).corners() for model, T in goods])


def test_posts_stand_at_the_four_corners_and_touch_nothing() -> None:
    goods = block(3)
    posts = corner_posts(goods, FLOOR)
    assert [model.name for model, _ in posts] == ["corner_post_900"] * 4
    stack = BoxStack.of([OrientedBox(T, model.size) for model, T in goods])
    outer = np.abs(points(goods)).max(axis=0)
    for (model, T), signs in zip(posts, ((-1, -1), (1, -1), (1, 1), (-1, 1)), strict=True):
        vertices = transform_points(T, model.mesh().vertices)
        assert vertices[:, 2].min() == pytest.approx(FLOOR)
        tip = (vertices[:, :2] * signs).max(axis=0)
        assert np.all((tip > outer[:2]) & (tip < outer[:2] + 0.009))
        corner = np.array([*(np.array(signs) * (tip - 0.002)), FLOOR + 0.2])  # the middle of the angle
        assert stack.distances_to(corner).min() > 0.001


def test_there_are_no_posts_where_a_corner_is_missing() -> None:
    assert corner_posts(block(3, top=2), FLOOR) == []
    assert corner_posts(block(1), FLOOR + 0.1) == []


@pytest.mark.parametrize("top", [4, 2, 1])
def test_film_holds_all_goods_and_the_edge_of_the_pallet(top: int) -> None:
    goods = block(3, top)
    goods += corner_posts(goods, FLOOR)
    model, T_load_film = film_around(goods, DECK, FLOOR, FilmConfig(), np.random.default_rng(0))
    film = transform_points(T_load_film, model.mesh().vertices)
    inner = points(goods)
    assert np.all(film.max(axis=0)[:2] > inner.max(axis=0)[:2] + 0.002)
    assert np.all(film.max(axis=0)[:2] < inner.max(axis=0)[:2] + 0.02)
    assert film[:, 2].min() == pytest.approx(FLOOR - 0.07)
    assert film[:, 2].max() == pytest.approx(inner[:, 2].max(), abs=0.002)
    uppermost = film[film[:, 2] > inner[:, 2].max() - 0.05]
    if top == 1:  # the film of the last level is tight around its one carton
        assert np.ptp(uppermost[:, 0]) < 0.62


def test_film_around_a_load_far_from_the_edge_starts_on_the_pallet() -> None:
    goods = [(MODEL, make_transform(translation=np.array([0.0, 0.0, FLOOR + 0.15])))]
    model, T_load_film = film_around(goods, DECK, FLOOR, FilmConfig(), np.random.default_rng(0))
    film = transform_points(T_load_film, model.mesh().vertices)
    assert film[:, 2].min() == pytest.approx(FLOOR)
    np.testing.assert_allclose(np.abs(film[:, :2]).max(axis=0), [0.303, 0.203], atol=0.003)


@pytest.mark.parametrize("top", [4, 2, 1])
def test_wound_film_follows_every_layer(top: int) -> None:
    goods = block(3, top)
    model, T_load_film = film_around(goods, DECK, FLOOR, FilmConfig("wound"), np.random.default_rng(0))
    film, inner = transform_points(T_load_film, model.mesh().vertices), points(goods)
    assert np.all(film.max(axis=0)[:2] > inner.max(axis=0)[:2] + 0.002)
    assert np.all(film.max(axis=0)[:2] < inner.max(axis=0)[:2] + 0.025)
    assert film[:, 2].min() == pytest.approx(FLOOR - 0.07)
    assert film[:, 2].max() == pytest.approx(inner[:, 2].max(), abs=0.004)
    if top == 1:
        uppermost = film[film[:, 2] > inner[:, 2].max() - 0.05]
        assert np.ptp(uppermost[:, 0]) < 0.64


def test_level_bands_draw_nothing_and_loose_film_is_another() -> None:
    goods, rng = block(2), np.random.default_rng(0)
    before = rng.bit_generator.state
    film_around(goods, DECK, FLOOR, FilmConfig(), rng)
    assert rng.bit_generator.state == before
    names = {
        film_around(goods, DECK, FLOOR, FilmConfig("wound", Distribution.constant(slack)), rng)[0].name
        for slack in (0.0, 1.0)
    }
    assert len(names) == 2


def test_wound_film_is_as_tight_around_drums_however_they_are_turned() -> None:
    drum = catalog_object("drum_steel_216_blue")
    sizes = []
    for turn in (0.0, np.pi / 4, 1.0):
        goods = [
            (drum, make_transform(rotation_z(turn), np.array([x, 0.0, FLOOR + drum.size[2] / 2]))) for x in (-0.3, 0.3)
        ]
        model, T_load_film = film_around(goods, DECK, FLOOR, FilmConfig("wound"), np.random.default_rng(0))
        film = transform_points(T_load_film, model.mesh().vertices)
        above = film[film[:, 2] > FLOOR + 0.3]
        assert np.hypot(np.abs(above[:, 0]).clip(0.3) - 0.3, above[:, 1]).max() < 0.32
        sizes.append(np.ptp(above[:, :2], axis=0))
    np.testing.assert_allclose(sizes, [sizes[0]] * 3, atol=0.02)
