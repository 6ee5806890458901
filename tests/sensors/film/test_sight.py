"""Which film rays meet: closed forms, and each ray against each triangle."""

from dataclasses import replace

import numpy as np

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import level_camera
from warehouse_sim.render.conformance.scenes import MATERIALS, at, box_model, make_scene
from warehouse_sim.schema import Material, ObjectModel, SceneSpec
from warehouse_sim.sensors.film import FilmSight, see_film

CAMERA = PinholeCamera.from_focal(96, 64, 70.0)
FILM = {"film": Material("film", (0.8, 0.8, 0.8), roughness=0.15, remission=0.15, opacity=0.13)}
ALONG_X = level_camera(np.zeros(3), 0.0)


def film_model(size: tuple[float, float, float], name: str = "sheet", class_name: str = "wrap") -> ObjectModel:
    return box_model(name, size, "film", class_name, 60)


def scene_of(*placed: tuple[ObjectModel, np.ndarray]) -> SceneSpec:
    models = [model for model, _ in placed]
    return make_scene(models, [(model.name, T) for model, T in placed], materials={**MATERIALS, **FILM})


def test_a_sheet_is_seen_where_it_hangs_and_only_before_what_is_solid() -> None:
    sight = FilmSight(scene_of((film_model((0.002, 1.0, 0.6)), at(2.001, 0, 0))))
    behind = np.full((64, 96), 3.0, np.float32)
    behind[:, 48:] = 1.5
    film = see_film(sight, CAMERA, ALONG_X, behind)
    assert film is not None
    met = np.isfinite(film.depth)
    np.testing.assert_allclose(film.depth[met], 2.0, atol=1e-5)
    rows, columns = np.nonzero(met)
    # 70 px / 2 m: 35 px across and 21 px down for half a metre and 0.3 m, less what stands before.
    assert (2 * columns.min(), 2 * columns.max()) == (30, 46)
    assert (2 * rows.min(), 2 * rows.max()) == (22, 42)
    np.testing.assert_allclose(film.passed[met], 0.923, atol=0.003)
    assert (film.passed[~met] == 1).all()
    assert (film.light[~met] == 0).all()
    whole = film.whole(behind)
    assert np.isfinite(whole.depth).sum() == 4 * met.sum()


def test_no_film_before_nothing_and_none_of_the_floor() -> None:
    sheet = film_model((0.002, 1.0, 0.6))
    assert see_film(FilmSight(scene_of((sheet, at(2, 0, 0)))), CAMERA, ALONG_X, np.zeros((64, 96), np.float32)) is None
    puddle = scene_of((film_model((0.002, 1.0, 0.6), "puddle", "floor"), at(2, 0, 0)))
    assert see_film(FilmSight(puddle), CAMERA, ALONG_X, np.full((64, 96), 3.0, np.float32)) is None
    away = FilmSight(scene_of((sheet, at(-2, 0, 0))))
    assert see_film(away, CAMERA, ALONG_X, np.full((64, 96), 3.0, np.float32)) is None


def test_blocks_of_rays_miss_nothing_that_single_rays_find() -> None:
    """Any film anywhere, before a far wall: each ray against each triangle, by Moeller and Trumbore."""
    rng = np.random.default_rng(3)
    for _ in range(6):
        placed = []
        for number in range(5):
            size = tuple(rng.uniform(0.02, 1.2, 3).tolist())
            place = at(*rng.uniform([0.3, -2.5, -1.5], [6.0, 2.5, 1.5]).tolist(), yaw=float(rng.uniform(0, 6)))
            placed.append((film_model(size, f"film{number}"), place))
        scene = scene_of(*placed)
        far = np.full((64, 96), 50.0, np.float32)
        film = see_film(FilmSight(scene), CAMERA, ALONG_X, far)
        slow = nearest_triangles(scene)
        assert film is not None
        np.testing.assert_array_equal(np.isfinite(film.depth), np.isfinite(slow))
        np.testing.assert_allclose(film.depth[np.isfinite(slow)], slow[np.isfinite(slow)], rtol=1e-4)


def nearest_triangles(scene: SceneSpec) -> np.ndarray:
    rays = CAMERA.rays()[::2, ::2].reshape(-1, 3) @ ALONG_X[:3, :3].T
    best = np.full(len(rays), np.inf)
    for item in scene.instances:
        for part in scene.model_of(item).parts:
            mesh = part.placed()
            corners = (mesh.vertices @ item.T_world_object[:3, :3].T + item.T_world_object[:3, 3])[mesh.faces]
            for a, b, c in corners:
                ab, ac = b - a, c - a
                p = np.cross(rays, ac)
                det = p @ ab
                with np.errstate(divide="ignore", invalid="ignore"):
                    u = (p @ -a) / det
                    q = np.cross(-a, ab)
                    v = (rays @ q) / det
                    t = (ac @ q) / det
                    inside = (u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0)
                best = np.where(inside & (t < best), t, best)
    return best.reshape(32, 48)


def test_film_of_another_colour_is_film_too() -> None:
    scene = scene_of((film_model((0.002, 1.0, 0.6)), at(2, 0, 0)))
    black = Material("film black", (0.01,) * 3, roughness=0.15, remission=0.04, opacity=0.85)
    painted = replace(scene.instances[0], paint={"film": black.name})
    scene = replace(scene, materials={**scene.materials, black.name: black}, instances=(painted,))
    film = see_film(FilmSight(scene), CAMERA, ALONG_X, np.full((64, 96), 3.0, np.float32))
    assert film is not None
    assert film.passed.min() < 0.3
