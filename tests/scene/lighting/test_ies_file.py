"""Photometric files against closed forms, and what is rejected."""

from pathlib import Path

import numpy as np
import pytest

from warehouse_sim.errors import ConfigError
from warehouse_sim.resources import find_photometry
from warehouse_sim.scene.lighting.ies_file import IesFile, distribution_of, load_distribution, read_ies
from warehouse_sim.scene.lighting.photometry import as_cone, light_illuminance, luminous_flux, spot
from warehouse_sim.schema import IntensityDistribution, Light

DOWN, X = np.array([0.0, 0.0, -1.0]), np.array([1.0, 0.0, 0.0])


def ies(
    vertical: np.ndarray,
    horizontal: np.ndarray,
    candela: np.ndarray,
    header: str = "IESNA:LM-63-2002",
    lamp: str = "1 -1 1",
    ballast: str = "1 1 100",
) -> str:
    rows = [" ".join(f"{value:.9g}" for value in row) for row in np.atleast_2d(candela)]
    sizes = f"{len(vertical)} {len(horizontal)} 1 2 0.3 1.2 0"
    angles = [" ".join(f"{value:g}" for value in angles) for angles in (vertical, horizontal)]
    return "\n".join([header, "[TEST] none", "TILT=NONE", f"{lamp} {sizes}", ballast, *angles, *rows]) + "\n"


def written(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "own.ies"
    path.write_text(text)
    return path


def from_planes(horizontal: list[float], candela: list[list[float]]) -> IntensityDistribution:
    vertical = np.linspace(0.0, 90.0, len(candela[0]))
    return distribution_of(IesFile(vertical, np.array(horizontal), np.array(candela)), "made")


def shining(distribution: IntensityDistribution, length: np.ndarray = X) -> Light:
    return spot(distribution, np.array([0.0, 0.0, 5.0]), DOWN, length, 10_000.0, color=(1.0, 1.0, 1.0), radius=0.1)


def floor_lux(light: Light, x: float, y: float) -> float:
    return float(light_illuminance(light, np.array([[x, y, 0.0]]), -DOWN[None])[0])


def test_a_lambertian_file_has_pi_lumens_a_candela_and_lights_as_the_cosine_does(tmp_path: Path) -> None:
    vertical = np.arange(0.0, 91.0, 1.0)
    cosine = np.cos(np.deg2rad(vertical))
    file = read_ies(written(tmp_path, ies(vertical, np.array([0.0]), 1000.0 * cosine)))
    distribution = distribution_of(file, "lambert")
    assert distribution.flux_per_candela == pytest.approx(np.pi, rel=2e-4)
    light = shining(distribution)
    assert luminous_flux(light) == pytest.approx(10_000.0)
    for angle in (0.0, 0.3, 0.77, 1.2):
        expected = 10_000.0 / np.pi * np.cos(angle) ** 4 / 25.0
        assert floor_lux(light, 5 * np.tan(angle), 0.0) == pytest.approx(expected, rel=1e-3)
        assert floor_lux(light, 0.0, -5 * np.tan(angle)) == pytest.approx(expected, rel=1e-3)


def test_an_even_file_over_the_whole_sphere_has_four_pi_lumens_a_candela(tmp_path: Path) -> None:
    text = ies(np.array([0.0, 90.0, 180.0]), np.array([0.0]), np.array([50.0, 50.0, 50.0]))
    distribution = distribution_of(read_ies(written(tmp_path, text)), "even")
    assert distribution.flux_per_candela == pytest.approx(4 * np.pi, rel=1e-12)
    assert distribution.peak == 50.0
    above = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.6, 0.0, -0.8]])
    np.testing.assert_allclose(distribution.at(above, DOWN, X), 1.0)


def test_flux_is_that_of_a_slow_sum_over_directions() -> None:
    for name in ("aisle_narrow", "highbay_wide"):
        distribution = load_distribution(find_photometry(name))
        directions = np.random.default_rng(5).normal(size=(400_000, 3))
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
        mean = float(distribution.at(directions, DOWN, X).mean())
        assert 4 * np.pi * mean == pytest.approx(distribution.flux_per_candela, rel=0.02)


def test_multiplier_and_ballast_count(tmp_path: Path) -> None:
    vertical, flat = np.array([0.0, 90.0]), np.array([10.0, 10.0])
    text = ies(vertical, np.array([0.0]), flat, lamp="2 1500 3", ballast="0.5 1 80")
    file = read_ies(written(tmp_path, text))
    assert file.candela.tolist() == [[15.0, 15.0]]


@pytest.mark.parametrize("header", ["IESNA:LM-63-2002", "IESNA:LM-63-1995", "IESNA91"])
def test_numbers_may_stand_anywhere(tmp_path: Path, header: str) -> None:
    text = ies(np.array([0.0, 45.0, 90.0]), np.array([0.0]), np.array([3.0, 2.0, 1.0]), header=header)
    head, _, numbers = text.partition("TILT=NONE\n")
    spread = head + "TILT=NONE\r\n" + "\r\n".join(numbers.replace("3 2", "3,2").split())
    assert read_ies(written(tmp_path, spread)).candela.tolist() == [[3.0, 2.0, 1.0]]


def test_what_a_last_angle_leaves_out_is_mirrored() -> None:
    def around(distribution: IntensityDistribution) -> list[float]:
        turned = np.deg2rad([0.0, 90.0, 180.0, 270.0])
        # Anticlockwise on a plan, whose x is the length: C 90 is the world's +y.
        level = np.cos(turned)[:, None] * X + np.sin(turned)[:, None] * np.array([0.0, 1.0, 0.0])
        return distribution.at((level + DOWN) / np.sqrt(2.0), DOWN, X).round(6).tolist()

    rows = [[value] * 3 for value in (1.0, 0.5, 0.25, 0.75, 1.0)]
    assert around(from_planes([0.0, 90.0], rows[:2])) == [1.0, 0.5, 1.0, 0.5]
    assert around(from_planes([0.0, 90.0, 180.0], rows[:3])) == [1.0, 0.5, 0.25, 0.5]
    assert around(from_planes([0.0, 90.0, 180.0, 270.0, 360.0], rows)) == [1.0, 0.5, 0.25, 0.75]


def test_an_asymmetric_file_turns_with_the_luminaire() -> None:
    one_sided = from_planes([0.0, 90.0, 180.0], [[1.0] * 3, [0.1] * 3, [0.1] * 3])
    for degrees in (0.0, 90.0, 215.0):
        turn = np.deg2rad(degrees)
        light = shining(one_sided, np.array([np.cos(turn), np.sin(turn), 0.0]))
        ahead, behind = (floor_lux(light, side * np.cos(turn), side * np.sin(turn)) for side in (1.0, -1.0))
        assert ahead == pytest.approx(10 * behind, rel=1e-3)


def test_a_tilted_luminaire_keeps_its_axes_square() -> None:
    distribution = load_distribution(find_photometry("aisle_narrow"))
    tilt = np.deg2rad(35.0)
    axis = np.array([np.sin(tilt), 0.0, -np.cos(tilt)])
    light = spot(distribution, np.zeros(3), axis, X, 1.0, color=(1.0, 1.0, 1.0), radius=0.1)
    assert np.dot(light.along, axis) == pytest.approx(0.0, abs=1e-12)
    assert np.linalg.norm(light.along) == pytest.approx(1.0)


def test_the_shipped_files_are_what_they_say() -> None:
    """The formulas stand in the files; what is read lies within rounding of them."""
    wide = read_ies(find_photometry("highbay_wide"))
    angle = np.deg2rad(wide.vertical)
    expected = 3600 * np.clip(np.cos(angle), 0.0, None) ** 0.7 * (1 + 0.8 * np.sin(1.5 * angle) ** 2)
    np.testing.assert_allclose(wide.candela[0], expected, atol=0.51)
    aisle = load_distribution(find_photometry("aisle_narrow"))
    along, across = (np.array([[np.sin(t) * x, np.sin(t) * y, -np.cos(t)]]) for x, y, t in ((1, 0, 0.7), (0, 1, 0.7)))
    assert float(aisle.at(along, DOWN, X)[0]) > 10 * float(aisle.at(across, DOWN, X)[0])
    for name in ("highbay_wide", "aisle_narrow"):
        assert "made for warehouse_sim" in find_photometry(name).read_text()
        distribution = load_distribution(find_photometry(name))
        # What a luminaire of 130-150 W gives today.
        assert 15_000 < distribution.peak * distribution.flux_per_candela < 30_000


def test_renderers_of_cones_get_the_same_flux() -> None:
    light = shining(load_distribution(find_photometry("aisle_narrow")))
    cone = as_cone(light)
    assert cone.distribution is None
    assert luminous_flux(cone) == pytest.approx(luminous_flux(light))


GOOD = ies(np.array([0.0, 45.0, 90.0]), np.array([0.0, 90.0]), np.ones((2, 3)))


@pytest.mark.parametrize(
    ("old", "new", "line", "says"),
    [
        ("IESNA:LM-63-2002", "hello", 1, "first line"),
        ("TILT=NONE", "TILT=INCLUDE", 3, "only TILT=NONE"),
        ("TILT=NONE", "", 9, "no line TILT=NONE"),
        ("3 2 1 2 0.3", "3 2 2 2 0.3", 4, "type B"),
        ("3 2 1 2 0.3", "3 2 1 3 0.3", 4, "unit of lengths"),
        ("1 -1 1 3", "1 -1 0 3", 4, "candela multiplier must be above 0"),
        ("1 -1 1 3", "1 -1 1 2.5", 4, "whole number"),
        ("1 -1 1 3", "1 -1 1 90000", 4, "number of vertical angles"),
        ("1 1 100", "1 1 nan", 5, "finite"),
        ("1 1 100", "1 1 1e99", 5, "finite"),
        ("0 45 90\n", "0 90 45\n", 6, "must rise"),
        ("0 45 90\n", "5 45 90\n", 6, "0 or 90"),
        ("0 90\n", "0 100\n", 7, "0, 90, 180 or 360"),
        ("1 1 1\n1 1 1", "1 1 1\n1 x 1", 9, "expected a number, found 'x'"),
        ("1 1 1\n1 1 1", "1 1 1\n1 -4 1", 9, "must not be negative"),
        ("1 1 1\n1 1 1", "1 1 1\n1 1", 9, "ends where candela"),
        ("1 1 1\n1 1 1", "1 1 1\n1 1 1 7", 9, "more numbers"),
        ("1 1 1\n1 1 1", "0 0 0\n0 0 0", 9, "gives no light"),
    ],
)
def test_what_is_wrong_is_named_with_its_line(tmp_path: Path, old: str, new: str, line: int, says: str) -> None:
    assert old in GOOD
    path = written(tmp_path, GOOD.replace(old, new, 1))
    with pytest.raises(ConfigError, match=says) as caught:
        read_ies(path)
    assert str(caught.value).startswith(f"{path}: line {line}: ")
    assert "\n" not in str(caught.value)


def test_empty_missing_and_huge_files_are_rejected(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="found nothing"):
        read_ies(written(tmp_path, ""))
    with pytest.raises(ConfigError, match="cannot be read"):
        read_ies(tmp_path / "no.ies")
    with pytest.raises(ConfigError, match="larger than"):
        read_ies(written(tmp_path, "x" * 4_000_001))
