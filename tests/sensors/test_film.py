"""Layers of film against Fresnel's formulas, layers added one by one, and the balance of energy."""

from dataclasses import replace

import numpy as np
import pytest

from warehouse_sim.geometry.camera import PinholeCamera
from warehouse_sim.geometry.pose import level_camera
from warehouse_sim.render.conformance.scenes import MATERIALS, at, box_model, make_scene
from warehouse_sim.schema import Material, ObjectModel, SceneSpec
from warehouse_sim.sensors.film import FilmSight, see_film
from warehouse_sim.sensors.film.sight import FilmOptics, _slopes, layers_and_dye, pile_reflectance, wrinkled

ONE = Material("film", (0.8, 0.8, 0.8), roughness=0.12, remission=0.15, opacity=0.13)


def optics(film: Material = ONE) -> FilmOptics:
    return FilmOptics.of((film,))


def added_one_by_one(cosine: float, surfaces: int) -> float:
    """Return what surfaces mirror by adding one after the other with all that goes to and fro between them."""
    sine = np.sqrt(1.0 - cosine**2)
    inside = np.arcsin(sine / 1.5)
    outside = np.arcsin(sine)
    fraction = []
    if sine == 0:
        single = [((1.5 - 1) / (1.5 + 1)) ** 2] * 2
    else:
        # The other way of writing Fresnel's formulas: sines and tangents of sum and difference.
        single = [
            (np.sin(outside - inside) / np.sin(outside + inside)) ** 2,
            (np.tan(outside - inside) / np.tan(outside + inside)) ** 2,
        ]
    for r in single:
        whole = 0.0
        for _ in range(surfaces):
            whole = whole + (1 - whole) ** 2 * r / (1 - whole * r)
        fraction.append(whole)
    return float(np.mean(fraction))


@pytest.mark.parametrize("layers", [1, 2, 3, 5])
@pytest.mark.parametrize("angle_deg", [0.0, 30.0, 56.0, 75.0, 88.0])
def test_a_pile_mirrors_what_its_surfaces_do_one_by_one(layers: int, angle_deg: float) -> None:
    cosine = np.cos(np.deg2rad(angle_deg))
    assert pile_reflectance(np.array([cosine]), layers)[0] == pytest.approx(added_one_by_one(cosine, 2 * layers))


def test_one_layer_passes_what_clear_film_is_sold_with() -> None:
    film = optics()
    assert film.mirrored[0] == pytest.approx(2 * 0.04 / 1.04, abs=1e-4)
    assert film.passed[0, -1] * film.clear[0, -1] == pytest.approx(0.905, abs=0.002)
    thrice = optics(Material("film", (0.8,) * 3, opacity=1 - 0.87**3))
    assert thrice.mirrored[0] == pytest.approx(6 * 0.04 / 1.2, abs=1e-4)


def test_no_light_is_won_or_lost_in_clear_film() -> None:
    cosine = np.linspace(0.0, 1.0, 256)
    for opacity in (0.13, 0.28, 0.46):
        film = optics(Material("film", (0.8,) * 3, remission=0.15, opacity=opacity))
        layers, dye = layers_and_dye(opacity)
        assert dye == 0
        np.testing.assert_allclose(film.passed[0] + pile_reflectance(cosine, layers), 1.0, atol=1e-6)
        # What goes back without direction is part of what is turned aside.
        assert (film.diffuse[0] <= 1 - film.clear[0] + 1e-6).all()


def test_the_lobe_holds_all_that_is_mirrored() -> None:
    for roughness in (0.12, 0.2):
        film = optics(Material("film", (0.8,) * 3, roughness=roughness, opacity=0.13))
        theta = np.linspace(0.0, np.pi / 2, 200_001)
        cosine = np.cos(theta).astype(np.float32)
        # The light sent back is F pi D / 4, and D cos integrates to 1 over the half sphere.
        density = 4.0 * film.highlight(np.zeros(len(theta), int), cosine) / (np.pi * film.mirrored[0])
        whole = np.trapezoid(density * np.cos(theta) * 2 * np.pi * np.sin(theta), theta)
        assert whole == pytest.approx(1.0, rel=0.02)


def test_dye_takes_what_layers_do_not() -> None:
    black = optics(Material("film", (0.0,) * 3, remission=0.05, opacity=0.85))
    white = optics(Material("film", (0.9,) * 3, remission=0.8, opacity=0.85))
    clear = optics(Material("film", (0.9,) * 3, remission=0.8, opacity=1 - 0.87**5))
    assert black.passed[0, -1] == pytest.approx(clear.passed[0, -1] * 0.15 / 0.87**5, rel=1e-4)
    assert black.diffuse[0, -1] < 0.1 < 0.5 < white.diffuse[0, -1]


def test_wrinkles_stay_where_they_are_and_turn_with_the_film() -> None:
    rng = np.random.default_rng(0)
    for axis in range(3):
        normals = np.zeros((5000, 3), np.float32)
        normals[:, axis] = 1.0
        points = rng.uniform(-2.0, 2.0, (5000, 3)).astype(np.float32)
        ids = np.full(5000, 7, np.int32)
        fine = wrinkled(points, normals, ids)
        np.testing.assert_array_equal(fine, wrinkled(points, normals, ids))
        np.testing.assert_allclose(np.linalg.norm(fine, axis=1), 1.0, atol=1e-6)
        slope = np.tan(np.arccos(np.clip(fine[:, axis], -1, 1)))
        assert np.sqrt(np.square(slope).mean()) == pytest.approx(0.11, rel=0.15)
    # Slopes of one height: no curl.
    along_u, along_v = np.fft.fft2(_slopes().astype(float))
    u, v = np.meshgrid(*(np.fft.fftfreq(256),) * 2)
    assert np.abs(v * along_u - u * along_v).max() < 1e-4 * np.abs(v * along_u).max()


# Which film rays meet: closed forms, and each ray against each triangle.


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
