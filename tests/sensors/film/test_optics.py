"""Layers of film against Fresnel's formulas, layers added one by one, and the balance of energy."""

import numpy as np
import pytest

from warehouse_sim.schema import Material
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
